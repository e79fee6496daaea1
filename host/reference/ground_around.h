// Light between ground and air (S4.9) as the reference has it: once from the plan's map and spectra, once from the full
// table, with the ground around each pixel found by Embree.
#pragma once

#include <array>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/reference/sampled_pixel.h"

namespace raycube::reference {

/// [material][wavelength]
using Reflectances = std::vector<std::vector<double>>;

/// What materials send back of an even sky's light: as the ground around they know no angles.
Reflectances ground_albedos(const scene::CompiledScene& scene, const std::vector<double>& wavelength_um);

/// Where a pixel looks: the mean of its samples' points; where its centre ray meets the plan's lowest height when none
/// hits.
glm::dvec3 ground_point(const SampledPixel& pixel, const plan::Plan& plan);

/// Arithmetic form: spectrum on the plan's grid, from the plan's nodes. reflectance: ground_albedos on that grid.
std::vector<double> environment_light(const SampledPixel& pixel, const plan::Plan& plan,
                                      const Reflectances& reflectance);

/// Model form: S, T_dif, t and E_g0 of the table where they are needed, and the ground around by vertical rays.
class EnvironmentModel {
 public:
  /// Keeps references. The plan must carry light between ground and air.
  EnvironmentModel(const ReferenceScene& scene, const plan::Plan& plan, const atmos::RenderTable& table);

  /// What the air sends back down from a zenith angle, on the table's wavelengths.
  std::vector<double> sky_increment(double height_m, double zenith_deg) const;
  /// Reflectance of the ground around a point on the table's wavelengths: [molecules, aerosol].
  std::array<std::vector<double>, 2> around(const glm::dvec3& point) const;
  /// What ground of these reflectances adds to a path from this height, on the table's wavelengths.
  std::vector<double> light(const std::array<std::vector<double>, 2>& around, double height_m, double zenith_deg) const;

 private:
  /// Adds a surface's reflectance; false where a vertical ray meets none.
  bool add_ground(double x_m, double y_m, double weight, std::vector<double>& sum) const;
  std::vector<double> ground_radiance(double height_m) const;

  const ReferenceScene& scene_;
  const plan::Plan& plan_;
  const atmos::RenderTable& table_;
  Reflectances reflectance_;  ///< ground_albedos on the table's wavelengths
  std::vector<double> mean_;
};

}  // namespace raycube::reference
