// How far away the ground lies whose light the air scatters into a line of sight (ATMOSPHERE S4.9: rho_e): environment
// functions F(r), the share of the diffusely transmitted light that left the ground within r of the point looked at,
// over ground of one radiance. Figures of 6S (Vermote, Tanre, Deuze, Herman & Morcrette 1997, IEEE Trans. Geosci.
// Remote Sens. 35, 675-686; its user guide, routine ENVIRO): sums of two exponentials for molecules and for aerosol at
// 16 sensor heights from 0.5 km, and their dependence on the view zenith. Fitted there to Monte Carlo runs of
// exponential profiles (scale heights 8 and 2 km); 6S states no error. Heights between are linear in the coefficients,
// as in 6S. Below 0.5 km, where 6S stays at its lowest node, r scales with the height: in air of one density a
// single-scattering kernel has no other length.
#pragma once

namespace raycube::atmos {

enum class Scatterer { molecules, aerosol };

/// F of the horizontal distance in km from the point looked at; height_km of the sensor above it, > 0; cos_view of the
/// view zenith, 0.5..1 (clamped: the fits turn back on themselves beyond 60 deg). 0 at 0, rising to 1.
double environment_function(Scatterer scatterer, double radius_km, double height_km, double cos_view);

/// The distance in km within which F = share, 0 <= share < 1; at most 1000 km.
double environment_radius_km(Scatterer scatterer, double share, double height_km, double cos_view);

/// Diffuse transmission of the molecules alone between two heights (m above the level of `pressure_hPa`): total minus
/// direct, two-stream, ((2/3 + mu) + (2/3 - mu) exp(-tau/mu)) / (4/3 + tau) (Tanre et al. 1979, Appl. Opt. 18, 3587; 1
/// % at depths below 0.5), molecules falling off over 8 km. It says which part of T_dif has the molecules' environment
/// function.
double molecular_diffuse_transmission(double wavelength_um, double pressure_hPa, double low_m, double high_m,
                                      double cos_view);

}  // namespace raycube::atmos
