// Rays from surface to surface: from what a camera sees by the cosine, of these the ones that go down or are hidden,
// and from what they meet once more; closest hits, against the best Embree can do with the same scene.
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

#include "bench/any_hit_rig.h"
#include "bench/cases.h"
#include "bench/opponents.h"
#include "bench/park_job.h"
#include "bench/rays.h"
#include "bench/scenes/scenes.h"
#include "bench/trace_comparison.h"
#include "bench/trace_rig.h"
#include "host/reference/double_trace.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"

namespace raycube::bench {
namespace {

constexpr float kNoRay = std::numeric_limits<float>::quiet_NaN();
constexpr double kOff_ulp = 32;  // of a point's coordinates: where the next ray starts, off its surface
constexpr std::size_t kMostJudged = 3000;

std::vector<float>* parts(ShadowRays& rays, std::size_t i) {
  std::vector<float>* all[] = {&rays.x, &rays.y, &rays.z, &rays.dx, &rays.dy, &rays.dz};
  return all[i];
}

reference::Ray ray_of(const ShadowRays& rays, std::size_t i) {
  return {{rays.x[i], rays.y[i], rays.z[i]}, {rays.dx[i], rays.dy[i], rays.dz[i]}, {}};
}

/// Rays that a render would follow: those that go down, and those that meet something.
ShadowRays followed(ShadowRays rays, const std::vector<RayResult>& met) {
  for (std::size_t i = 0; i < rays.x.size(); ++i)
    if (rays.dz[i] > 0 && met[i].instance == RC_NONE) rays.x[i] = kNoRay;
  return rays;
}

/// From where they end, by the cosine about the side that they came to.
ShadowRays next_rays(const scene::CompiledScene& scene, const ShadowRays& rays, const std::vector<RayResult>& met) {
  ShadowRays out;
  for (std::size_t k = 0; k < 6; ++k) parts(out, k)->assign(rays.x.size(), kNoRay);
  for (std::size_t i = 0; i < met.size(); ++i) {
    if (met[i].instance == RC_NONE || std::isnan(rays.x[i])) continue;
    const reference::Ray ray = ray_of(rays, i);
    const reference::Hit hit{met[i].instance, met[i].primitive};
    glm::dvec3 normal = reference::world_normal(scene, hit);
    if (glm::dot(normal, reference::to_double(ray.direction)) > 0) normal = -normal;
    const auto draw = [&](std::uint32_t what) {
      return static_cast<double>(rc_unit_float(rc_hash(11u, static_cast<std::uint32_t>(i), 0u, what)));
    };
    const glm::dvec3 other = std::abs(normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 across = glm::normalize(glm::cross(normal, other)), along = glm::cross(normal, across);
    const double u = draw(0), turn = 2 * std::numbers::pi * draw(1);
    const glm::dvec3 way =
        std::sqrt(u) * (std::cos(turn) * across + std::sin(turn) * along) + std::sqrt(1 - u) * normal;
    const glm::dvec3 point = reference::hit_point(scene, ray, hit);
    const glm::dvec3 from = point + normal * (kOff_ulp * reference::kUlp * (1 + glm::length(point)));
    for (std::size_t k = 0; k < 3; ++k) {
      (*parts(out, k))[i] = static_cast<float>(from[static_cast<glm::length_t>(k)]);
      (*parts(out, 3 + k))[i] = static_cast<float>(way[static_cast<glm::length_t>(k)]);
    }
  }
  return out;
}

/// Those that are rays, in their order.
ShadowRays joined(const ShadowRays& first, const ShadowRays& second) {
  ShadowRays out;
  for (const ShadowRays* from : {&first, &second})
    for (std::size_t i = 0; i < from->x.size(); ++i) {
      if (std::isnan(from->x[i])) continue;
      ShadowRays& source = const_cast<ShadowRays&>(*from);
      for (std::size_t k = 0; k < 6; ++k) parts(out, k)->push_back((*parts(source, k))[i]);
    }
  return out;
}

/// Ours against double arithmetic where the two differ.
void judge_closest(const scene::CompiledScene& scene, const ShadowRays& rays, const std::vector<RayResult>& ours,
                   const std::vector<RayResult>& theirs, const std::string& name, Report& report) {
  const std::vector<std::size_t> differ = which_differ(ours, theirs);
  const reference::DoubleTracer tracer(scene);
  std::size_t wrong = 0;
  for (std::size_t n = 0; n < differ.size(); n += differ.size() / kMostJudged + 1) {
    const reference::Ray ray = ray_of(rays, differ[n]);
    const RayResult& r = ours[differ[n]];
    const reference::Hit own = r.instance == RC_NONE ? reference::Hit{} : reference::Hit{r.instance, r.primitive};
    wrong += tracer.explain(ray, own, tracer.trace(ray).hit) == reference::Cause::unexplained;
  }
  std::printf("  %s: %.3g of the rays end elsewhere\n", name.c_str(),
              static_cast<double>(differ.size()) / static_cast<double>(ours.size()));
  report.validate(name + ": rays of ours that double contradicts beyond rounding", static_cast<double>(wrong), 0);
}

void compare_closest(const scene::CompiledScene& scene, const scene::Instrument& camera, const std::string& label,
                     const Settings& settings, Report& report) {
  const auto groups = some_lines(camera, scene, kMostRays);
  TraceRig rig(scene, camera, groups.size(), bench_sun(), settings.threads);
  rig.set_groups(groups);
  rig.run();
  const ShadowRays all = rig.sky_rays();
  ClosestHitRig looked(scene, all, settings.threads);
  looked.run();
  const std::vector<RayResult> met = looked.results();
  const ShadowRays first = followed(all, met), rays = joined(first, next_rays(scene, first, met));
  ClosestHitRig ours(scene, rays, settings.threads);
  ours.run();
  const std::vector<RayResult> mine = ours.results();

  const auto forms = embree_forms(scene, label);
  std::vector<Opponent> opponents;
  std::vector<RayResult> theirs(mine.size());
  for (const auto& [form, embree] : forms)
    for (const EmbreeMode mode : {EmbreeMode::packet16, EmbreeMode::single}) {
      opponents.push_back({label + ", Embree " + form_name(form) + ", " + mode_name(mode), embree.get(), mode, {}});
      embree->closest(rays, mode, settings.threads, theirs.data());
      embree->to_scene(theirs.data(), theirs.size());
      judge_closest(scene, rays, mine, theirs, opponents.back().name, report);
    }
  time_in_turn(
      opponents,
      [&](const Opponent& o) {
        return seconds_of([&] { o.embree->closest(rays, o.mode, settings.threads, theirs.data()); });
      },
      [&] { return ours.run(); });
  const Opponent& best = best_of(opponents);
  const auto traced = static_cast<double>(rays.x.size());
  const auto hits = std::count_if(mine.begin(), mine.end(), [](const RayResult& r) { return r.instance != RC_NONE; });
  report.set_text("bounce_" + label + "_baseline", best.name);
  report.add("bounce_" + label + "_closest_vs_embree", best.times.ratio(), "x", Goal::at_least(1.0));
  report.add("bounce_" + label + "_rays", traced, "");
  report.add("bounce_" + label + "_met", static_cast<double>(hits) / traced, "");
  report.add("bounce_" + label + "_mrays_s", 1e-6 * traced / spread_of(best.times.ours_s).median, "Mrays/s");
  report.add("bounce_" + label + "_embree_mrays_s", 1e-6 * traced / spread_of(best.times.reference_s).median,
             "Mrays/s");
}

}  // namespace

void run_bounce(const Settings& settings, Report& report) {
  const scene::Simulation park = load_park(settings);
  compare_closest(park.scene, park.instruments.at(0), "park", settings, report);
  compare_closest(compile({terrain_mesh()}, {{kIdentity}}), terrain_camera(), "terrain", settings, report);
}

}  // namespace raycube::bench
