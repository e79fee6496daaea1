#include "host/planner/cost_model.h"

#include <algorithm>
#include <cmath>

namespace raycube::planner {

namespace {

/// Surfaces that one path comes to, as many as may be expected. From the third on it goes on with the chance of what it
/// can carry.
double surfaces_of_path(const plan::Plan& plan) {
  const plan::SkyRays::Met& met = plan.sky.met;
  double reflected = 0;
  for (const auto& law : plan.bounces.scattering) reflected = std::max(reflected, static_cast<double>(law.y));
  reflected = std::min(reflected, 1.0);
  double surfaces = 0, comes = met.mean;
  for (int level = 1; level <= plan.bounces.levels; ++level) {
    surfaces += comes;
    comes *= met.on * (level < 2 ? 1 : level == 2 ? reflected * reflected : reflected);
  }
  return surfaces;
}

}  // namespace

PixelCounts pixel_counts(const plan::Plan& plan, double samples, double directions) {
  PixelCounts counts;
  counts.samples = samples;
  counts.sun_rays = plan.sun_up && plan.sun_sources > 0 ? samples : 0;
  counts.sky_rays = plan.components() > 0 ? directions : 0;
  // Two materials in the typical pixel; a node axis of more than one node gives two terms.
  const auto held = [](int count) { return count > 1 ? 2.0 : 1.0; };
  constexpr double materials = 2;
  counts.terms = materials * plan.sources() * held(plan.height.count) * held(plan.view.count) +
                 held(plan.height.count) * held(plan.path_x.count) * held(plan.path_y.count) +
                 (plan.environment.empty() ? 0 : 4 * held(plan.height.count) * held(plan.view.count));
  if (plan.bounces.levels > 0) {
    counts.paths = directions, counts.path_surfaces = directions * surfaces_of_path(plan);
    counts.skeleton = static_cast<double>(plan.bounces.skeleton.size());
    counts.terms += counts.skeleton * held(plan.height.count) * held(plan.view.count);
  }
  counts.bands = static_cast<double>(plan.bands.size());
  return counts;
}

}  // namespace raycube::planner
