// Band integrals: the spectral grid on which every spectrum of a plan is sampled, and the weights of each band on it.
#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "host/plan/plan.h"

namespace raycube::plan {

/// A Gaussian response is cut at this many FWHM from its centre: exp(-4 ln2 2.5^2) = 3e-8 of the peak, 4e-9 of the
/// area.
inline constexpr double kGaussianCutFwhm = 2.5;

/// First and last wavelength (um) at which the band's response counts.
std::pair<double, double> band_support(const scene::Band& band);

/// Response at a wavelength (um), unnormalised: R = exp(-4 ln2 (l - lc)^2 / FWHM^2) inside the cut (S11), or the
/// tabulated curve, linear between its nodes. 0 outside the support.
double band_response(const scene::Band& band, double wavelength_um);

/// Grid for `bands`: every breakpoint (node of the table's axis or of a used curve) near a band, and the midpoint of
/// every interval that a response touches. Odd entries of an interval chain are such midpoints: see `band_quadrature`.
struct SpectralGrid {
  std::vector<double> wavelength_um;  ///< ascending
  std::vector<std::size_t> interval;  ///< index of the left end of each interval [i, i + 2] with midpoint i + 1
};

/// breakpoints: any order, duplicates within 1e-9 um are merged. Must cover every band's support.
SpectralGrid make_spectral_grid(std::vector<double> breakpoints, const std::vector<scene::Band>& bands);

/// Weights by integrating the three quadratic Lagrange polynomials of each interval (ends and midpoint) against the
/// response, Gauss-Legendre with 8 points on pieces no wider than half a FWHM. Exact for any product of two functions
/// that are linear between breakpoints; weights sum to 1. A single weight may be slightly negative where a narrow
/// response sits inside one interval.
BandQuadrature band_quadrature(const scene::Band& band, const SpectralGrid& grid);

/// What a spectrum on the bands' grid is in each of them.
std::vector<double> in_bands(const std::vector<BandQuadrature>& bands, const std::vector<double>& spectrum);

/// Nodes and weights of the n-point Gauss-Legendre rule on [-1, 1].
std::vector<std::pair<double, double>> gauss_legendre(int n);

}  // namespace raycube::plan
