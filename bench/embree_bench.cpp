// Embree against itself: if its packets are not several times faster than its single rays, it was built or called wrong
// and no ratio to it counts.
#include <cmath>
#include <cstdio>

#include "bench/cases.h"
#include "bench/embree_baseline.h"
#include "bench/rays.h"
#include "bench/scenes/scenes.h"
#include "bench/timing.h"
#include "host/sensors/ray_groups.h"

namespace raycube::bench {

void run_embree_baseline(const Settings& settings, Report& report) {
  const auto scene = compile({terrain_mesh()}, {{kIdentity}});
  const auto camera = terrain_camera();
  const auto groups = sensors::make_ray_groups(camera, scene, 0, camera.lines);
  const PrimaryRays rays = primary_rays(camera, groups);
  const EmbreeBaseline embree(scene);
  report.add("terrain_triangles", scene.meshes[0].triangle_count(), "");
  std::vector<RayResult> packet(rays.rays()), single(rays.rays());
  const auto run16 = [&] { embree.primary(rays, EmbreeMode::packet16_coherent, settings.threads, packet.data()); };
  const auto run1 = [&] { embree.primary(rays, EmbreeMode::single, settings.threads, single.data()); };
  const Pairs pairs = alternate(run1, run16);
  // Two of Embree's own modes part in 1.7e-5 of the rays (PERFORMANCE.md 2.3).
  report.validate("Embree 16 against Embree 1, rays that differ", differing(packet, single), 5e-5);
  report.add("embree16_vs_embree1", pairs.ratio(), "x", Goal::at_least(3.5).as_guard());
  report.add("embree16_mrays_s", 1e-6 * static_cast<double>(rays.rays()) / spread_of(pairs.ours_s).median, "Mrays/s");
  report.add("terrain_candidates_mean", mean(candidates(scene, camera, groups, settings.threads)), "");
}

}  // namespace raycube::bench
