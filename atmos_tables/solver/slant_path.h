// Slant paths through a spherical, refracting atmosphere (atmosphere specification S4.2): n r sin(zenith) is
// constant along a ray (Bouguer), ds = dr / sqrt(1 - (c/(n r))^2). Every constituent has its own airmass,
// because each has its own height profile.
#pragma once

#include <vector>

namespace raycube::atmos::solver {

/// Levels of an atmosphere from the top down.
struct RefractingAir {
  std::vector<double> height_m;  ///< strictly falling, at least two; the last is where the observer stands
  std::vector<double>
      refractivity;  ///< n - 1 at each level, [0, 0.01]; empty = no refraction. Exponential in height between
  double planet_radius_m = 6371.23e3;  ///< at height 0
};

/// Amount of an absorber along the ray that leaves the lowest level at `zenith_deg` (apparent, [0, 90]) to
/// the highest level, in units of density times metres. density: at each level, >= 0; exponential in height
/// between levels, linear next to a 0. A density of 1 everywhere gives the ray's length (m). Relative error
/// of the quadrature below 1e-8. Throws base::Error(Fault::input) where these ranges do not hold.
double slant_amount(const RefractingAir& air, const std::vector<double>& density, double zenith_deg);

/// Length of that ray in each layer over the layer's thickness, layers as in `air`: the first lies below the highest
/// level.
std::vector<double> slant_factors(const RefractingAir& air, double zenith_deg);

/// slant_amount over the vertical amount; 1 for an absorber that is nowhere.
double relative_airmass(const RefractingAir& air, const std::vector<double>& density, double zenith_deg);

}  // namespace raycube::atmos::solver
