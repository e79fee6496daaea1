// What separates ground and air, from runs over ground of known albedo (ATMOSPHERE S4.9). Over Lambertian ground of
// albedo r
//   L(r) = L0 + r C / (1 - r S),   C = (T_dir + T_dif) E_g0 / pi
// with S the spherical albedo of the air from below and E_g0 the irradiance on a plane over black ground.
#pragma once

namespace raycube::atmos::imported {

struct GroundCoupling {
  double spherical_albedo;  ///< S
  double coefficient;       ///< C, in the unit of the radiances
};

/// From radiances over albedos 0, r1 and r2 (0 < r1 < r2 <= 1): with D = L - L0, S = (D2/r2 - D1/r1) / (D2 - D1) and
/// C = D1 (1/r1 - S). Where the ground is not seen (D2 = D1 = 0) both are 0.
GroundCoupling coupling_of_three_runs(double radiance_0, double radiance_1, double radiance_2, double r1, double r2);

}  // namespace raycube::atmos::imported
