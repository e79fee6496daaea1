// Legendre polynomials and their associated functions, in the normalisation that makes the addition theorem
// free of factorials.
#pragma once

#include <vector>

namespace raycube::atmos::solver {

/// sqrt((l-m)!/(l+m)!) P_l^m(x) for l = order ... degree_end - 1 (result[l - order]); |x| <= 1. No overflow
/// at any order. Dave & Armstrong (1970), JQSRT 10, 557. Sign: all positive at l = m.
std::vector<double> normalized_legendre(int order, int degree_end, double x);

/// sum over k of (2k+1) moments[k] P_k(x), k < count: the phase function of Legendre moments (integral over
/// the sphere 4 pi).
double legendre_series(const std::vector<double>& moments, std::size_t count, double x);

}  // namespace raycube::atmos::solver
