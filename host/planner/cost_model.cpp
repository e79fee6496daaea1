#include "host/planner/cost_model.h"

namespace raycube::planner {

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
    counts.path_rays = 2.0 * directions * plan.bounces.levels;
    counts.terms += static_cast<double>(plan.bounces.skeleton.size()) * held(plan.height.count) * held(plan.view.count);
  }
  counts.bands = static_cast<double>(plan.bands.size());
  return counts;
}

}  // namespace raycube::planner
