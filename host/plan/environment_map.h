// The ground around every place of a scene, weighed by the environment functions: which materials send the light that
// the air scatters into a pixel's path. Made once per render on the host; no tile and no thread can change it.
#pragma once

#include "host/plan/plan.h"

namespace raycube::plan {

/// The ground is seen from straight above (its uppermost surfaces, points on a square grid), in up to three rasters:
/// the view and its near surroundings finely, coarser out to where 99 % of the aerosol's light comes from. What lies
/// outside these or the scene, or shows no surface, counts as the scene's mean: the area mean of the widest raster.
/// Around each node of the map
/// 4096 places per environment function, on a spiral of equal shares of F, say what is there. `local` false: one node,
/// the mean. z_lo, z_hi: heights of the ground looked at. On as many threads (0: all), the same on any number.
EnvironmentMap make_environment(const scene::CompiledScene& scene, const ViewBounds& view, double z_lo, double z_hi,
                                bool local, int threads = 0);

/// Reflectance of the scene's mean at wavelengths in um; curves keep their end values outside.
std::vector<double> mean_reflectance(const EnvironmentMap& map, const scene::CompiledScene& scene,
                                     const std::vector<double>& wavelength_um);

/// Samples the curves that the map names on the plan's spectral grid.
void sample_environment(EnvironmentMap& map, const scene::CompiledScene& scene,
                        const std::vector<double>& wavelength_um);

}  // namespace raycube::plan
