#include "host/planner/open_share.h"

#include <algorithm>
#include <cmath>

#include "host/planner/pixel_trial.h"
#include "host/planner/replicated.h"
#include "host/planner/sample_pattern.h"

namespace raycube::planner {

namespace {

constexpr std::uint64_t kOpenShare = 0x3c6ef372u;  ///< added to the seed: pixels and draws of its own
constexpr int kRuns = 32, kWidest = 512;           ///< of 8 pixels each; pixels traced at once
constexpr float kHalf = 0.5f;                      ///< taken for granted while it is measured
/// A surface that few rays left is thought of as all others are, with the weight of so many rays.
constexpr double kPrior = 16;
/// Shares are told in so many steps: what devices round differently does not move them.
constexpr double kSteps = 64;

struct Seen {
  double open = 0, all = 0, rays = 0;  ///< light that rays met and could have met, and their number
};

}  // namespace

scene::Instrument first_launched(const scene::Simulation& simulation, const scene::Instrument& instrument,
                                 const plan::Plan& plan) {
  scene::Instrument few = instrument;
  if (!few.samples_given)
    give_samples(few, may_replicate(simulation, few, plan) ? first_size(few, plan, simulation.tolerance).samples
                                                           : sample_pattern(few).look);
  few.first_samples = 0, few.small_objects = scene::SmallObjects::off, few.standard_error = scene::StandardError::off;
  return few;
}

void measure_open_share(render::Renderer& renderer, const scene::Simulation& simulation,
                        const scene::Instrument& instrument, plan::Plan& plan) {
  plan.sky.open_share.clear();
  if (plan.components() == 0) return;
  const auto& scene = simulation.scene;
  const scene::Instrument few = first_launched(simulation, instrument, plan);
  plan::Plan half = plan;
  half.sky.open_share.assign(scene.surfaces.size(), kHalf);
  half.bounces.levels = 0;
  half.sky.rays = std::min(plan.sky.rays, few.samples_u * few.samples_v);  // one ray a sample: its sign tells its fate
  std::vector<Seen> seen(scene.surfaces.size());
  // Of the first component: without any sky it is the surroundings', whose light is -1.
  const double bright = plan.sky_components + plan.thermal.sky_components > 0 ? 1 : -1;
  renderer.probe_together(
      few, half, simulation.sun, simulation.seed + kOpenShare,
      joined(trial_tiles(few, simulation.seed + kOpenShare, kRuns), kWidest), [&](const render::PixelProbe& probe) {
        const auto samples = static_cast<std::size_t>(probe.samples);
        const std::size_t planes = probe.sky_met.size() / std::max<std::size_t>(1, probe.hit_instance.size()) /
                                   static_cast<std::size_t>(probe.sides);
        for (std::size_t i = 0; i < probe.sky_met.size() / planes; ++i) {
          const std::size_t p = i / samples / static_cast<std::size_t>(probe.sides), s = i % samples;
          const double met = bright * static_cast<double>(probe.sky_met[planes * i]);
          if (met == 0) continue;
          const std::uint32_t primitive = probe.hit_primitive[p * samples + s];
          Seen& at = seen[scene.blocks[primitive / RC_BLOCK].surface[primitive % RC_BLOCK]];
          at.open += std::abs(met) + met, at.all += 2 * std::abs(met), at.rays += 1;
        }
      });
  Seen whole;
  for (const Seen& at : seen) whole.open += at.open, whole.all += at.all, whole.rays += at.rays;
  if (!(whole.all > 0)) return;
  const double mean = whole.open / whole.all, each = whole.all / whole.rays;
  for (const Seen& at : seen) {
    const double share = (at.open + kPrior * each * mean) / (at.all + kPrior * each);
    plan.sky.open_share.push_back(static_cast<float>(std::round(std::clamp(share, 0.0, 1.0) * kSteps) / kSteps));
  }
}

}  // namespace raycube::planner
