// The terrain of PERFORMANCE.md section 0: few, large triangles.
#include <algorithm>

#include "bench/cases.h"
#include "bench/rays.h"
#include "bench/scenes/scenes.h"
#include "bench/trace_comparison.h"
#include "host/sensors/ray_groups.h"

namespace raycube::bench {

void run_terrain(const Settings& settings, Report& report) {
  const auto scene = compile({terrain_mesh()}, {{kIdentity}});
  const auto camera = terrain_camera();
  const auto groups = sensors::make_ray_groups(camera, scene, 0, camera.lines);
  TraceRig rig(scene, camera, groups.size(), bench_sun(), settings.threads);
  rig.set_groups(groups);
  rig.run();
  const auto hits = rig.hits();
  const auto lost = std::count_if(hits.begin(), hits.end(), [](const RayResult& r) { return r.instance == RC_NONE; });
  report.validate("terrain: our rays that miss the closed ground", static_cast<double>(lost), 0);
  // Embree's default and robust modes part in 1.7e-5 of the rays, kernels like ours from the default one in up to
  // 4.3e-5; shadows in 1.0e-5 (PERFORMANCE.md 2.3).
  const Limits limits{4.3e-5, 1e-5};
  const Comparison c = compare_traces(scene, camera, groups, bench_sun(), false, limits, settings, report, "terrain");
  report.add("primary_vs_embree16", c.primary.ratio(), "x", Goal::at_least(3.6));
  report.add("shadow_vs_embree16", c.shadow.ratio(), "x", Goal::at_least(3.5));
  const double rays = static_cast<double>(groups.size()) * RC_GROUP_WIDTH * camera.samples_u * camera.samples_v;
  report.add("primary_mrays_s", 1e-6 * rays / spread_of(c.primary.ours_s).median, "Mrays/s");
}

}  // namespace raycube::bench
