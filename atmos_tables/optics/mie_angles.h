// Light scattered by a sphere against angle: amplitudes, phase function and its Legendre moments.
//
// A phase function P(mu), mu = cosine of the scattering angle, has the integral 4 pi over the sphere (1/2 int P dmu =
// 1). Its moments are chi_k = 1/2 int P(mu) P_k(mu) dmu, so P = sum (2k + 1) chi_k P_k, chi_0 = 1, chi_1 = asymmetry.
#pragma once

#include <complex>
#include <cstddef>
#include <vector>

#include "atmos_tables/optics/gauss_legendre.h"
#include "atmos_tables/optics/mie.h"

namespace raycube::atmos {

/// S1 (perpendicular) and S2 (parallel), Bohren & Huffman eq. 4.74. At cosine 1 both are S(0), and extinction =
/// 4/x^2 Re S(0) (the optical theorem).
struct MieAmplitudes {
  std::complex<double> s1, s2;
};
MieAmplitudes mie_amplitudes(const MieSphere& sphere, double cosine);

/// (|S1|^2 + |S2|^2) / 2 at +-cosine[i], all in [0, 1], from one recurrence (Wiscombe 1980, eq. 22-23): forward at
/// +cosine, backward at -cosine, added to the sums with a weight.
void add_mie_intensity(const MieSphere& sphere, const std::vector<double>& cosine, double weight,
                       std::vector<double>& forward, std::vector<double>& backward);

/// Phase function of one sphere, integral 4 pi.
double mie_phase(const MieSphere& sphere, double cosine);

/// Moments chi_0..chi_last of one sphere, by a Gauss rule that is exact: intensity and P_k are polynomials in mu.
std::vector<double> mie_moments(const MieSphere& sphere, std::size_t last);

/// Nodes that make moments up to `last` exact for spheres with this many terms.
std::size_t mie_nodes(std::size_t terms, std::size_t last);

}  // namespace raycube::atmos
