// The law by which a pixel's sky rays are drawn (kernels/sampling/sky_rays.h), fitted to the plan's sky.
#pragma once

#include "host/plan/plan.h"
#include "kernels/sampling/sky_rays.h"

namespace raycube::plan {

inline constexpr int kMostSkyRays = 4096;

/// Rays for a sky of these maps, or of the thermal sky's where there are no others. Of laws of a few shares and
/// asymmetries the one under which the light that a ray brings varies least, on the mean over surfaces of many tilts:
/// an even sky takes the cosine alone, by which open sky has no noise whatever the tilt. The share of the cosine is at
/// least kLeastCosineShare, since it alone looks below the horizon and along every surface.
SkyRays make_sky_rays(const SkyBasis& basis, const Thermal& thermal, double sun_azimuth_rad,
                      const std::array<float, 3>& sun_direction, int rays);
inline constexpr double kLeastCosineShare = 0.3;

/// The law as kernels and the reference draw by it.
SkyDensity sky_density(const Plan& plan);

/// A map's ascending nodes as kernels search them (kernels/light/sky_map.h): INFINITY up to whole words of 16.
std::vector<float> searched_nodes(const std::vector<double>& nodes);

}  // namespace raycube::plan
