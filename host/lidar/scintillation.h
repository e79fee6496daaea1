// Scintillation: how much received power flickers, how an aperture averages it, and draws of it (LIDAR specification,
// 8.3 and 8.4).
#pragma once

#include "host/lidar/draws.h"

namespace raycube::lidar {

/// Gamma-gamma distribution: product of two unit-mean gamma variates.
struct GammaGamma {
  double alpha = 0, beta = 0;
  double scintillation_index() const { return 1 / alpha + 1 / beta + 1 / (alpha * beta); }
};
/// Andrews & Phillips (2005), chapter 9, zero inner scale, from the Rytov variance s: plane wave (1.11, 0.69) and
/// spherical wave (0.56, 0.69, s the spherical variance). s > 0.
GammaGamma gamma_gamma_plane(double rytov_variance);
GammaGamma gamma_gamma_spherical(double rytov_variance);
/// The same shape with another scintillation index, as aperture averaging leaves it: both parameters times a common
/// factor.
GammaGamma with_index(const GammaGamma& shape, double scintillation_index);

/// Probability that irradiance of unit mean is below a level, 0 < level: log-normal with that scintillation index;
/// gamma-gamma by quadrature of the incomplete gamma function's mixture.
double log_normal_below(double level, double scintillation_index);
double gamma_gamma_below(double level, const GammaGamma& distribution);

/// Ratio of the scintillation index over an aperture of diameter D to a point's, d = k D^2 / (4 L): direct integral,
/// weak turbulence, tabulated to d = 316 and joined to its asymptotes 0.933 d^(-7/6) (plane) and 4.675 d^(-7/6)
/// (spherical). Falls from 1.
double aperture_averaging_plane(double d);
double aperture_averaging_spherical(double d);

/// Irradiance of mean 1: log-normal (gamma_gamma = false) or gamma-gamma about the index. Index 0: 1.
double draw_irradiance(Stream& stream, double scintillation_index, const GammaGamma* gamma_gamma);

}  // namespace raycube::lidar
