#include "host/planner/cost_model.h"

#include <cmath>

namespace raycube::planner {

namespace {

/// Surfaces that one path comes to, as many as may be expected. From the second on it goes on by the chance of what it
/// can carry: of the one that is seen, the first and the second together, then of each.
double surfaces_of_path(const plan::Plan& plan) {
  const plan::SkyRays::Met& met = plan.sky.met;
  const double reflected = plan.bounces.brightest();
  double surfaces = 0, comes = met.mean;
  for (int level = 1; level <= plan.bounces.levels; ++level) {
    surfaces += comes;
    comes *= met.on * (level < 2 ? 1 : level == 2 ? std::pow(reflected, 3) : reflected);
  }
  return surfaces;
}

}  // namespace

PixelCounts pixel_counts(const plan::Plan& plan, double samples, double directions) {
  return pixel_counts(plan, samples, directions, plan.sky.paths_per_two);
}

PixelCounts pixel_counts(const plan::Plan& plan, double samples, double directions, int paths_per_two) {
  PixelCounts counts;
  counts.samples = samples;
  counts.sun_rays = plan.sun_up && plan.sun_sources > 0 ? samples : 0;
  counts.lamp_rays = samples * plan.lamps.sources();
  counts.lamps = samples * static_cast<double>(plan.lamps.lamp.size());
  counts.sky_rays = plan.components() > 0 ? directions : 0;
  // Two materials in the typical pixel; a node axis of more than one node gives two terms.
  const auto held = [](int count) { return count > 1 ? 2.0 : 1.0; };
  constexpr double materials = 2;
  counts.terms = materials * plan.sources() * held(plan.height.count) * held(plan.view.count) +
                 held(plan.height.count) * held(plan.path_x.count) * held(plan.path_y.count) +
                 (plan.environment.empty() ? 0 : 4 * held(plan.height.count) * held(plan.view.count));
  if (plan.bounces.levels > 0) {
    counts.paths = plan::paths_beside(static_cast<int>(directions), paths_per_two);
    counts.path_surfaces = counts.paths * surfaces_of_path(plan);
    counts.skeleton = static_cast<double>(plan.bounces.skeleton.size());
    counts.lamp_rays += counts.path_surfaces * plan.lamps.sources();
    counts.lamps += counts.path_surfaces * static_cast<double>(plan.lamps.lamp.size());
    counts.terms += static_cast<double>(plan.skeleton_rows()) * held(plan.height.count) * held(plan.view.count);
  }
  counts.bands = static_cast<double>(plan.bands.size());
  return counts;
}

}  // namespace raycube::planner
