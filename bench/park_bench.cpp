// The shipped park: the pixels that look into its trees.
#include "bench/cases.h"
#include "bench/park_job.h"
#include "bench/rays.h"
#include "bench/trace_comparison.h"
#include "host/base/error.h"

namespace raycube::bench {
void run_park(const Settings& settings, Report& report) {
  const scene::Simulation park = load_park(settings);
  const scene::Instrument& spectir = park.instruments.at(0);
  report.add("park_instances", static_cast<double>(park.scene.instances.size()), "");
  const auto groups = groups_with_candidates(park.scene, spectir, 100, settings.threads);
  report.add("park_leaf_pixels", static_cast<double>(groups.size() * RC_GROUP_WIDTH), "", Goal::at_least(2000));
  if (groups.empty())
    throw base::Error(base::Fault::check, "bench: no pixel of the park has 100 candidates; is this the shipped scene?");
  // In crowns kernels and Embree part in 6.5e-4 of the rays by rounding alone, and 1e-3 may (PERFORMANCE.md section
  // 11). With instances Embree parts more, for it rounds an origin 600 m away in the tree's frame by its own fp32
  // inverse: only our share is bounded. Shadow rays start near and part in at most 2.3e-5 there, ten times that over
  // instances.
  const Limits limits{1e-3, 2.3e-4};
  const Comparison c =
      compare_traces(park.scene, spectir, groups, sun_vector(park.sun), true, limits, settings, report, "park");
  report.add_programs("group park", {"", c.program_hash});
  report.add("park_leaf_primary_vs_embree16", c.primary.ratio(), "x", Goal::at_least(2.5));
  report.add("park_leaf_primary_vs_best_embree", c.primary_best.ratio(), "x");
  report.add("park_leaf_shadow_vs_embree16", c.shadow.ratio(), "x", Goal::at_least(1.4));
  report.add("park_leaf_shadow_vs_best_embree", c.shadow_best.ratio(), "x", Goal::at_least(1.2));
  const double mrays =
      1e-6 * static_cast<double>(groups.size()) * RC_GROUP_WIDTH * spectir.samples_u * spectir.samples_v;
  report.add("park_leaf_primary_mrays_s", mrays / spread_of(c.primary.ours_s).median, "Mrays/s");
  report.add("park_leaf_embree16_mrays_s", mrays / spread_of(c.primary.reference_s).median, "Mrays/s");
}

}  // namespace raycube::bench
