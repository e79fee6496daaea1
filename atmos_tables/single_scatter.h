// Single scattering of a beam in a homogeneous layer, exact, for any slant slopes: the closed forms of Liou (2002),
// "An Introduction to Atmospheric Radiation", eq. 3.4.10-3.4.11, written so that no difference of like numbers remains.
#pragma once

namespace raycube::atmos {

/// (1 - exp(-x)) / x for x >= 0; 1 at x = 0. Mean of exp(-x s) over s in [0, 1].
double slab_mean(double x);

/// Light scattered up, seen at the layer's top, per unit of (omega P / 4 pi) times the beam that enters at the top.
/// depth: vertical extinction depth; sun_slope, view_slope: slant depth per vertical depth (1/mu0, 1/mu when plane).
/// = mu0/(mu0 + mu) (1 - exp(-depth (1/mu + 1/mu0))) in the plane case.
double layer_scatter_up(double depth, double sun_slope, double view_slope);

/// Light scattered down, seen at the layer's bottom; same unit. mu0 = mu is no special case.
/// = mu0/(mu0 - mu) (exp(-depth/mu0) - exp(-depth/mu)) in the plane case.
double layer_scatter_down(double depth, double sun_slope, double view_slope);

/// Light of an isotropic, constant source of unit strength in the layer, seen from outside: 1 - exp(-depth view_slope).
double layer_emission(double depth, double view_slope);

/// Henyey-Greenstein phase function, integral over the sphere 4 pi. asymmetry in (-1, 1).
double phase_henyey_greenstein(double asymmetry, double cos_angle);

}  // namespace raycube::atmos
