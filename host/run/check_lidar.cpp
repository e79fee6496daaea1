#include "host/run/check_lidar.h"

#include <algorithm>
#include <set>

#include "kernels/sampling/sampler.h"

namespace raycube::run {

namespace {

constexpr rc_u32 kPickDimension = 43;  ///< of the hash: no sampler uses it
/// Pulses that wait on the host before the reference takes them up together, and bins of their rows: those are all its
/// memory.
constexpr std::size_t kPulseBatch = 64, kMostBins = std::size_t{1} << 23;

}  // namespace

std::vector<lidar::Shot> pick_shots(const scene::Lidar& lidar, std::uint64_t seed, std::uint64_t pulses) {
  const auto all = static_cast<std::uint64_t>(lidar.pulses);
  std::set<std::uint64_t> numbers;
  if (2 * pulses >= all) {
    for (std::uint64_t i = 0; i < all && numbers.size() < pulses; ++i) numbers.insert(i);
  } else {
    for (rc_u32 i = 0; numbers.size() < pulses; ++i) {
      const std::uint64_t high = rc_hash(static_cast<rc_u32>(seed), i, static_cast<rc_u32>(seed >> 32), kPickDimension);
      numbers.insert(
          (high << 32 | rc_hash(static_cast<rc_u32>(seed), i, static_cast<rc_u32>(seed >> 32), kPickDimension + 1)) %
          all);
    }
  }
  std::vector<lidar::Shot> shots;
  for (const std::uint64_t number : numbers)
    for (lidar::Shot& shot : lidar::make_shots(lidar, static_cast<std::int64_t>(number), 1, seed))
      shots.push_back(shot);
  return shots;
}

std::uint64_t default_pulses(const lidar::LidarPlan& plan) {
  const bool receiver = plan.lidar.transport.sampling == scene::LidarSampling::receiver;
  const std::uint64_t rays = plan.footprint.a.size() * static_cast<std::uint64_t>(receiver ? plan.pixels() : 1);
  return std::clamp<std::uint64_t>(300000 / std::max<std::uint64_t>(rays, 1), 2, 100);
}

reference::LidarReport check_lidar(render::LidarRenderer& renderer, const scene::CompiledScene& scene,
                                   const lidar::LidarPlan& plan, const LidarCheckOptions& options,
                                   const std::function<void(std::uint64_t)>& progress) {
  reference::LidarCompareOptions compare;
  compare.threads = options.threads;
  reference::LidarComparison comparison(scene, plan, compare);
  const std::size_t bins = static_cast<std::size_t>(plan.pixels()) * static_cast<std::size_t>(plan.lines()) *
                           static_cast<std::size_t>(plan.lidar.gate.bins);
  const std::size_t batch = std::clamp<std::size_t>(kMostBins / bins, 1, kPulseBatch);
  std::vector<lidar::ShotResult> waiting;
  const auto flush = [&] {
    comparison.add(waiting);
    if (progress) progress(waiting.size());
    waiting.clear();
  };
  renderer.render(
      plan, pick_shots(plan.lidar, plan.seed, options.pulses),
      [&](lidar::ShotResult&& shot) {
        waiting.push_back(std::move(shot));
        if (waiting.size() >= batch) flush();
      },
      true);
  flush();
  return comparison.report();
}

reference::LidarReport check_survey(render::LidarRenderer& renderer, const scene::Simulation& simulation,
                                    const LidarJob& job, const LidarCheckOptions& options, const Services& services) {
  const Step step(services, "check " + job.lidar->name,
                  std::min<std::uint64_t>(options.pulses, static_cast<std::uint64_t>(job.lidar->pulses)), "pulses");
  return check_lidar(renderer, simulation.scene, job.plan, options, [&](std::uint64_t more) { step.advance(more); });
}

}  // namespace raycube::run
