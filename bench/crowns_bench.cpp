// Generated tree crowns, merged into one mesh and instanced: what two levels cost, and the leaf figures without the
// park.
#include "bench/cases.h"
#include "bench/rays.h"
#include "bench/scenes/scenes.h"
#include "bench/trace_comparison.h"
#include "host/sensors/ray_groups.h"

namespace raycube::bench {
namespace {

std::size_t geometry_bytes(const scene::CompiledScene& scene) {
  return scene.nodes.size() * sizeof(shared::BvhNode) + scene.blocks.size() * sizeof(shared::TriBlock) +
         scene.instances.size() * sizeof(shared::Instance);
}

void run_memory(Report& report, const scene::CompiledScene& merged) {
  report.add("bytes_per_triangle", static_cast<double>(geometry_bytes(merged)) / merged.meshes[0].triangle_count(),
             "B");
  // What one more instance costs: the same mesh once and 10 001 times.
  const auto mesh = crown_mesh(100, 0.07, 1);
  std::vector<std::array<double, 12>> many;
  for (int i = 0; i <= 10000; ++i) {
    auto place = kIdentity;
    place[3] = 7.0 * (i % 100);
    place[7] = 7.0 * (i / 100);
    many.push_back(place);
  }
  const auto one = compile({mesh}, {{kIdentity}}), lots = compile({mesh}, {many});
  report.add("bytes_per_instance", static_cast<double>(geometry_bytes(lots) - geometry_bytes(one)) / 10000, "B");
}

}  // namespace

void run_crowns(const Settings& settings, Report& report) {
  const std::vector<scene::TriangleMesh> trees{crown_mesh(20000, 0.07, 1), crown_mesh(20000, 0.07, 2),
                                               crown_mesh(20000, 0.07, 3)};
  const auto places = crown_places();
  std::vector<std::vector<std::array<double, 12>>> stands(4);
  scene::TriangleMesh all = crown_ground();
  stands[3] = {kIdentity};
  for (std::size_t i = 0; i < places.size(); ++i) {
    stands[i % 3].push_back(places[i]);
    append(all, trees[i % 3], places[i]);
  }
  const auto instanced = compile({trees[0], trees[1], trees[2], crown_ground()}, stands),
             merged = compile({all}, {{kIdentity}});
  run_memory(report, merged);

  const auto camera = crown_camera();
  const auto groups = groups_with_candidates(instanced, camera, 100, settings.threads);
  report.add("crown_leaf_pixels", static_cast<double>(groups.size() * RC_GROUP_WIDTH), "", Goal::at_least(1000));
  // In crowns kernels and Embree part in 6.5e-4 of the rays by rounding alone, and 1e-3 may (PERFORMANCE.md section
  // 11). With instances Embree parts more, for it rounds an origin 600 m away in the tree's frame by its own fp32
  // inverse: only our share is bounded. Shadow rays start near and part in at most 2.3e-5 there, ten times that over
  // instances.
  const Limits limits{1e-3, 2.3e-4};
  const Comparison c = compare_traces(instanced, camera, groups, bench_sun(), true, limits, settings, report, "crowns");
  report.add("crown_leaf_primary_vs_embree16", c.primary.ratio(), "x");
  report.add("crown_leaf_primary_vs_best_embree", c.primary_best.ratio(), "x");
  report.add("crown_leaf_shadow_vs_embree16", c.shadow.ratio(), "x");

  TraceRig two_levels(instanced, camera, groups.size(), bench_sun(), settings.threads);
  TraceRig one_level(merged, camera, groups.size(), bench_sun(), settings.threads);
  two_levels.set_groups(groups);
  one_level.set_groups(groups);
  // The merged vertices were rounded once more, by up to half a float step of 40 m (2e-6 m), against 7 cm leaves.
  two_levels.run();
  one_level.run();
  report.validate("merged against instanced: rays that hit in one and miss in the other",
                  hit_or_miss(two_levels.hits(), one_level.hits()), 1e-4);
  std::vector<double> ratios;
  for (int i = 0; i < kPairs; ++i) {
    const double merged_s = one_level.run().primary_s;
    ratios.push_back(merged_s / two_levels.run().primary_s);
  }
  report.add("instanced_vs_merged", spread_of(ratios), "x");
}

void run_layers(const Settings& settings, Report& report) {
  constexpr double leaf_m = 0.2, side_m = 10;
  std::vector<std::array<double, 12>> places;
  for (int i = 0; i < 49; ++i) {
    auto place = kIdentity;
    place[3] = side_m * (i % 7 - 3), place[7] = side_m * (i / 7 - 3), place[11] = 1;
    places.push_back(place);
  }
  for (const int layers : {2, 4, 7, 14}) {
    const auto scene = compile({leaf_slab(layers, leaf_m, side_m, 8, 1), crown_ground()}, {places, {kIdentity}});
    const auto camera = crown_camera();
    const auto groups = sensors::make_ray_groups(camera, scene, 0, camera.lines);
    const std::string name = "layers" + std::to_string(layers);
    report.add(name + "_candidates", mean(candidates(scene, camera, groups, settings.threads)), "triangles/pixel");
    const Comparison c =
        compare_traces(scene, camera, groups, bench_sun(), true, {1e-3, 2.3e-4}, settings, report, name);
    report.add(name + "_primary_vs_embree16", c.primary.ratio(), "x");
    report.add(name + "_primary_vs_best_embree", c.primary_best.ratio(), "x");
    report.add(name + "_shadow_vs_embree16", c.shadow.ratio(), "x");
    const double rays = static_cast<double>(groups.size()) * RC_GROUP_WIDTH * camera.samples_u * camera.samples_v;
    report.add(name + "_primary_mrays_s", 1e-6 * rays / spread_of(c.primary.ours_s).median, "Mrays/s");
  }
}

}  // namespace raycube::bench
