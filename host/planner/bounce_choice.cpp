#include "host/planner/bounce_choice.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/plan/bounces.h"
#include "host/planner/open_share.h"
#include "host/planner/trial_pixels.h"

namespace raycube::planner {

namespace {

constexpr double kMissedShare = 0.1;  ///< of the tolerance
constexpr double kNothing = 1e-9;
constexpr double kLowest = 0.1;  ///< sine of the sun's elevation below which no surface is thought of as facing it
constexpr std::uint64_t kLook = 0x1f83d9ab;  ///< added to the seed: pixels and draws of its own
constexpr int kLookedRuns = 64, kLookRays = 128, kLookedAtOnce = 512;  ///< of 8 pixels each; pixels traced at once

constexpr double kStepsOfOctave = 8;  ///< in which it is told: what devices round differently does not move it

double rounded_up(double value) {
  return value > 0 ? std::exp2(std::ceil(std::log2(value) * kStepsOfOctave - 1e-3) / kStepsOfOctave) : 0;
}

/// What paths change on some pixels, by the same samples and rays with them and without, from above: two draws of the
/// rays, so that their noise adds nothing.
double changed_by_paths(render::Renderer& renderer, const scene::Simulation& simulation,
                        const scene::Instrument& instrument, const plan::Plan& plan) {
  const scene::Instrument few = first_launched(simulation, instrument, plan);
  plan::Plan with = plan;
  with.sky.rays = std::min(plan.sky.rays, kLookRays);
  plan::Plan without = with;
  without.bounces.levels = 0;
  const std::uint64_t seed = simulation.seed + kLook;
  const auto tiles = trial_tiles(few, seed, kLookedRuns);
  TrialImage image;
  image.bands = plan.bands.size();
  for (const auto& tile : tiles)
    image.run_end.push_back((image.run_end.empty() ? 0 : image.run_end.back()) + tile.pixels());
  const auto render = [&](const plan::Plan& by) {
    std::vector<TrialImage> out(2, image);
    auto draws = renderer.draws_of(few, by, simulation.sun, {{seed, 0}, {seed, 1}}, joined(tiles, kLookedAtOnce));
    for (std::size_t d = 0; d < out.size(); ++d) out[d].radiance = std::move(draws[d]);
    return out;
  };
  const auto all = render(with), once = render(without);
  return common_error(once[0], once[1], all[0], all[1], judged_means(all[0])).bound;
}

}  // namespace

bool choose_bounces(render::Renderer& renderer, const scene::Simulation& simulation,
                    const scene::Instrument& instrument, plan::Plan& plan) {
  const plan::Bounces& bounces = plan.bounces;
  const plan::SkyRays::Met& met = plan.sky.met;
  if (simulation.bounces_given || !bounces.any() || !met.known) return false;
  const double most = bounces.brightest(), each = most * met.on;  // each: of light at a surface, what the next one gets
  const double facing = plan.sun_up ? std::max(kLowest, static_cast<double>(plan.sun_direction[2])) : 1;
  // A gloss shows of other surfaces what the look does not weigh: beside dark matter it is most of what is seen. So may
  // be what a lamp makes bright, and all that lies behind plates.
  const bool kept = plan.matter.glossy || plan.matter.plates || plan.lamps.sources() > 0;
  // Of thermal light the surroundings count most already: what is left no bound is near to, so it is looked at.
  const double once_missed =
      std::min(1.0, plan.thermal.on && !kept ? rounded_up(changed_by_paths(renderer, simulation, instrument, plan))
                                             : met.rms * most / (facing * std::max(1 - each, 1e-3)));
  const double share = kMissedShare * plan.tolerance, missed = once_missed * std::pow(each, bounces.levels);
  const bool drop = once_missed <= share && !kept;
  // What the wavelengths err by counts where surfaces are met.
  if (drop || (bounces.error * met.mean <= bounces.share && bounces.amplified <= plan::kMostAmplified))
    std::erase_if(plan.notices, [](const auto& told) { return told.starts_with(plan::kBetweenSurfaces); });
  if (missed > share)
    plan.notices.push_back(
        fmt::format("{}{} surfaces after the first may leave out {:.2g} % of what is seen (asked: "
                    "{:.2g} %)",
                    plan::kBetweenSurfaces, bounces.levels, 100 * missed, 100 * share));
  plan::BounceReport& report = plan.report.bounces;
  report = {false, true, drop ? once_missed : missed < kNothing ? 0 : missed, once_missed};
  plan.report.total_error = std::hypot(plan.report.total_error, report.missed);
  plan.report.within_tolerance = plan.report.total_error <= plan.tolerance;
  if (drop) plan = plan::without_paths(plan);
  return drop;
}

}  // namespace raycube::planner
