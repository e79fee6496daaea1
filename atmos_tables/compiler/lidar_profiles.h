// Profiles of extinction and backscatter for LIDAR: what a pulse meets at each height of the layered model's air.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

inline constexpr double kLidarFirst_um = 0.25, kLidarLast_um = 15;

struct LidarOptions {
  /// The receiver passes the Cabannes line alone and rejects the rotational Raman wings: molecules scatter back 2.5 %
  /// less (at 0.532 um) and 0.37 % of it depolarised instead of 1.44 %. Extinction stays.
  bool cabannes_only = false;
  /// Stated lidar ratios of components (AerosolColumn::name: "rural", "troposphere", "cumulus" ...) instead of the Mie
  /// functions', and their linear depolarisation, which the model takes as 0 (spheres).
  struct Particles {
    std::string component;
    double lidar_ratio_sr = -1;  ///< 1..1000; below 0: the model's
    double depolarization = 0;   ///< 0..1
  };
  std::vector<Particles> particles;
};

/// Heights above z = 0, m, from the ground to the top of the air at 100 km: 100 m apart to 2 km, 250 m to 6, 500 m to
/// 12, 1 km to 30,
/// 5 km to 50, 10 km beyond, and the places where aerosols and clouds begin, end or bend. About 75 without clouds.
std::vector<double> lidar_heights(const scene::AtmosphereSpec& spec);

/// A table with the axes wavelength (0.25..15 um, vacuum, ascending) and range_height (m above z = 0, ascending) and
/// the rows lidar_extinction_molecular, _aerosol, lidar_backscatter_molecular, _aerosol and lidar_depolarization.
/// lidar_extinction_gas is there when spec.layered names lines or cross-sections: those gases, and the continua and
/// ozone of the layered model. depolarization: perpendicular over parallel backscatter of a linearly polarised beam,
/// molecules and particles together. The provenance's "notices" are what a user should hear of this air; its "limits"
/// hold what is left out and takes little (gases_left_out of air_provenance.h). Throws Error(input) with every problem
/// found.
RenderTable build_lidar(const scene::AtmosphereSpec& spec, const std::vector<double>& wavelength_um,
                        const std::vector<double>& height_m, const LidarOptions& options = {});

}  // namespace raycube::atmos
