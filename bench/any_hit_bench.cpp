// Rays into the sky, each in a direction of its own, and primary rays among leaves, against the best Embree can do with
// the same scene: its fastest mode over the faster of its instanced and its merged form.
#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "bench/any_hit_rig.h"
#include "bench/cases.h"
#include "bench/opponents.h"
#include "bench/park_job.h"
#include "bench/rays.h"
#include "bench/trace_comparison.h"
#include "host/base/error.h"
#include "scene_compiler/load_simulation.h"

namespace raycube::bench {
namespace {

// Over instances Embree rounds origins by its own fp32 inverse of each matrix, and merged corners are rounded once
// more: rays that graze part, and only of ours is it asked that none contradicts double arithmetic.
constexpr double kShadowsOff = 2.3e-4;

void compare_any_hits(const scene::Simulation& simulation, const std::string& label, const Goal& goal,
                      const Settings& settings, Report& report) {
  const scene::CompiledScene& scene = simulation.scene;
  const scene::Instrument& camera = simulation.instruments.at(0);
  const auto groups = some_lines(camera, scene, kMostRays);
  TraceRig rig(scene, camera, groups.size(), bench_sun(), settings.threads);
  rig.set_groups(groups);
  rig.run();
  const std::vector<RayResult> hits = rig.hits();
  const ShadowRays rays = rig.sky_rays();
  const auto traced = static_cast<double>(std::count_if(rays.x.begin(), rays.x.end(), [](float x) { return x == x; }));
  AnyHitRig ours(scene, rays, hits, settings.threads);
  ours.run();
  const std::vector<RayResult> mine = ours.results();
  const auto blocked =
      std::count_if(mine.begin(), mine.end(), [](const RayResult& r) { return r.instance == RC_NONE; });

  const auto forms = embree_forms(scene, label);
  std::vector<Opponent> opponents;
  std::vector<RayResult> theirs(mine.size());
  for (const auto& [form, embree] : forms)
    for (const EmbreeMode mode : kEmbreeModes) {
      opponents.push_back({label + ", Embree " + form_name(form) + ", " + mode_name(mode), embree.get(), mode, {}});
      embree->shadow(rays, mode, settings.threads, theirs.data());
      const ShadowJudgement verdict = judge(scene, rays, hits, mine, theirs);
      report.validate(opponents.back().name + ": any-hit rays that differ",
                      static_cast<double>(verdict.differ) / traced, kShadowsOff);
      report.validate(opponents.back().name + ": any-hit rays of ours that are wrong in double",
                      static_cast<double>(verdict.ours_wrong), 0);
    }
  time_in_turn(
      opponents,
      [&](const Opponent& o) {
        return seconds_of([&] { o.embree->shadow(rays, o.mode, settings.threads, theirs.data()); });
      },
      [&] { return ours.run(); });
  const Opponent& best = best_of(opponents);
  report.set_text("any_hit_" + label + "_baseline", best.name);
  report.add("any_hit_" + label + "_vs_embree", best.times.ratio(), "x", goal);
  report.add("any_hit_" + label + "_blocked", static_cast<double>(blocked) / traced, "");
  report.add("any_hit_" + label + "_mrays_s", 1e-6 * traced / spread_of(best.times.ours_s).median, "Mrays/s");
  report.add("any_hit_" + label + "_embree_mrays_s", 1e-6 * traced / spread_of(best.times.reference_s).median,
             "Mrays/s");
}

/// Primary rays of the pixels that look into leaves, against coherent packets.
void compare_leaf_primary(const scene::Simulation& simulation, const Settings& settings, Report& report) {
  const scene::CompiledScene& scene = simulation.scene;
  const scene::Instrument& camera = simulation.instruments.at(0);
  const auto groups = groups_with_candidates(scene, camera, 100, settings.threads);
  if (groups.empty())
    throw base::Error(base::Fault::check, "bench: no pixel of " + settings.peer_file + " has 100 candidates");
  report.add("peer_leaf_pixels", static_cast<double>(groups.size() * RC_GROUP_WIDTH), "", Goal::at_least(2000));
  TraceRig rig(scene, camera, groups.size(), bench_sun(), settings.threads);
  rig.set_groups(groups);
  rig.run();
  const std::vector<RayResult> ours = rig.hits();
  const PrimaryRays rays = primary_rays(camera, groups);
  const auto forms = embree_forms(scene, "peer");
  std::vector<Opponent> opponents;
  std::vector<RayResult> theirs(rays.rays());
  constexpr EmbreeMode coherent = EmbreeMode::packet16_coherent;
  for (const auto& [form, embree] : forms) {
    opponents.push_back({std::string("peer leaves, Embree ") + form_name(form), embree.get(), coherent, {}});
    embree->primary(rays, coherent, settings.threads, theirs.data());
    embree->to_scene(theirs.data(), theirs.size());
    const Judgement verdict = judge(scene, rays, ours, theirs, 2000);
    std::printf("  %s: %.3g of the rays hit another primitive; of %zu judged in double ours are right in %zu\n",
                opponents.back().name.c_str(), differing(ours, theirs), verdict.judged, verdict.ours_right);
    report.validate(opponents.back().name + ": rays of ours that double contradicts beyond rounding",
                    static_cast<double>(verdict.unexplained), 0);
  }
  time_in_turn(
      opponents,
      [&](const Opponent& o) {
        return seconds_of([&] { o.embree->primary(rays, o.mode, settings.threads, theirs.data()); });
      },
      [&] { return rig.run().primary_s; });
  report.add("leaf_primary_vs_merged_embree16", best_of(opponents).times.ratio(), "x", Goal::at_least(1.7));
}

scene::Simulation load_peer(const Settings& settings) {
  if (!std::filesystem::exists(settings.peer_file))
    throw base::Error(base::Fault::environment, "bench: no scene at " + settings.peer_file +
                                                    "; make it with bench/peer_scene.py " +
                                                    std::filesystem::path(settings.peer_file).parent_path().string());
  return scene::load_simulation(settings.peer_file);
}

}  // namespace

void run_any_hit(const Settings& settings, Report& report) {
  const scene::Simulation peer = load_peer(settings);
  compare_any_hits(load_park(settings), "park", Goal::at_least(1.0), settings, report);
  compare_any_hits(peer, "peer", Goal::at_least(1.3), settings, report);
  compare_leaf_primary(peer, settings, report);
}

}  // namespace raycube::bench
