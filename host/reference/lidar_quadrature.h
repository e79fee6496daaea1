// Integrals along rays, in double.
#pragma once

#include <functional>
#include <vector>

namespace raycube::reference {

/// Sum over the pieces between ascending `cuts`, each by Gauss-Kronrod (7, 15), halved until the two rules differ by
/// less than `relative` of the whole sum's share of a piece.
double adaptive_integral(const std::function<double(double)>& value, const std::vector<double>& cuts, double relative);

}  // namespace raycube::reference
