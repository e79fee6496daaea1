#include "host/run/other_pulses.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/base/units.h"
#include "host/planner/lidar_fire.h"
#include "scene_compiler/lidar_reach.h"

namespace raycube::run {

namespace {

/// `back` of every pulse whose light can be in the gate of pulse 0, but its own.
std::vector<std::int64_t> periods_back(const scene::CompiledScene& scene, const scene::Lidar& lidar) {
  std::vector<std::int64_t> out;
  const double last_s = 2 * scene::reach_of(scene.lo, scene.hi, scene.volumes, lidar).farthest_m *
                        lidar.transport.group_index / base::kLightSpeed_m_s;
  const double begin_s = lidar.gate.start_s, end_s = begin_s + lidar.gate.bins * lidar.gate.bin_s;
  for (std::int64_t back = -static_cast<std::int64_t>(std::floor(end_s * lidar.prf_hz));
       begin_s + static_cast<double>(back) / lidar.prf_hz < last_s; ++back)
    if (back != 0 && end_s + static_cast<double>(back) / lidar.prf_hz > 0) out.push_back(back);
  return out;
}

void add(std::vector<float>& to, const std::vector<float>& from) {
  for (std::size_t i = 0; i < std::min(to.size(), from.size()); ++i) to[i] += from[i];
}

/// Enough to tell gates with light from those without.
constexpr std::uint64_t kLookPulses = 32;
constexpr int kLookSubrays = 16;

double light_in(const lidar::LidarPlan& plan, render::LidarRenderer& renderer) {
  std::uint64_t rays = 0;
  double sum = 0;
  for (const auto& row : planner::fire_pulses(renderer, plan, planner::hashed_pulses(plan, kLookPulses),
                                              {kLookSubrays, plan.seed, false}, rays)
                             .pulse)
    for (const float bin : row) sum += double{bin};
  return sum;
}

}  // namespace

OtherPulses::OtherPulses(const scene::Simulation& simulation, const lidar::LidarPlan& plan)
    : seed_(simulation.seed), pulses_(plan.lidar.pulses) {
  if (!plan.lidar.fold_ambiguous) return;
  for (const auto back : periods_back(simulation.scene, plan.lidar)) {
    others_.push_back({back, plan});
    others_.back().plan.lidar.gate.start_s += static_cast<double>(back) / plan.lidar.prf_hz;
  }
}

void OtherPulses::add_to(std::vector<lidar::ShotResult>& results, render::LidarRenderer& renderer,
                         const std::function<void(lidar::Shot&)>& ready, bool hits) const {
  if (others_.empty()) return;
  for (auto& result : results) result.others.clear();
  for (const auto& other : others_) {
    std::map<std::int64_t, lidar::ShotResult*> open;
    for (auto& result : results) open[result.shot.pulse - other.back] = &result;
    const std::int64_t first = open.empty() ? 0 : std::max<std::int64_t>(0, open.begin()->first);
    const std::int64_t last = open.empty() ? -1 : std::min(pulses_ - 1, open.rbegin()->first);
    if (last < first) continue;
    auto shots = lidar::make_shots(other.plan.lidar, first, last - first + 1, seed_);
    std::erase_if(shots, [&](const lidar::Shot& shot) { return open.count(shot.pulse) == 0; });
    for (auto& shot : shots) ready(shot);
    const auto join = [&](lidar::ShotResult&& found) {
      lidar::ShotResult& result = *open[found.shot.pulse];
      add(result.first, found.first), add(result.multiple, found.multiple), add(result.air, found.air);
      add(result.particles, found.particles);
      const auto bins = static_cast<std::size_t>(other.plan.lidar.gate.bins), lines = result.ledger.size();
      for (const auto* rows : {&found.first, &found.multiple, &found.air})
        for (std::size_t i = 0; i < rows->size(); ++i) {
          const std::size_t line = i / bins % lines;
          if (other.plan.photons[line] > 0) result.ledger[line].collected += (*rows)[i] / other.plan.photons[line];
        }
      result.rays += found.rays;
      if (hits) result.others.push_back({other.back, found.shot, std::move(found.hits)});
    };
    renderer.render(other.plan, shots, join, hits);
  }
}

lidar::LidarPlan OtherPulses::brightest(const lidar::LidarPlan& plan, render::LidarRenderer& renderer) const {
  if (others_.empty()) return plan;
  const lidar::LidarPlan* out = &plan;
  double most = light_in(plan, renderer);
  for (const auto& other : others_)
    if (const double light = light_in(other.plan, renderer); light > most) most = light, out = &other.plan;
  return *out;
}

}  // namespace raycube::run
