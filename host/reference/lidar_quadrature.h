// Integrals along rays, in double.
#pragma once

#include <functional>

namespace raycube::reference {

/// Gauss-Kronrod (7, 15), halved until the two rules agree to `relative` of the whole or nothing is left to halve.
double adaptive_integral(const std::function<double(double)>& value, double from, double to, double relative);

}  // namespace raycube::reference
