#include "host/planner/bounce_choice.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "host/plan/baked_rows.h"
#include "host/plan/bounces.h"

namespace raycube::planner {

namespace {

constexpr double kMissedShare = 0.1;  ///< of the tolerance
constexpr double kNothing = 1e-9;
constexpr double kLowest = 0.1;  ///< sine of the sun's elevation below which no surface is thought of as facing it

}  // namespace

bool choose_bounces(const scene::Simulation& simulation, plan::Plan& plan) {
  const plan::Bounces& bounces = plan.bounces;
  const plan::SkyRays::Met& met = plan.sky.met;
  if (simulation.bounces_given || !bounces.any() || !met.known) return false;
  const double most = bounces.brightest(), each = most * met.on;  // each: of light at a surface, what the next one gets
  const double facing = plan.sun_up ? std::max(kLowest, static_cast<double>(plan.sun_direction[2])) : 1;
  const double once_missed = std::min(1.0, met.rms * most / (facing * std::max(1 - each, 1e-3)));
  const double share = kMissedShare * plan.tolerance, missed = once_missed * std::pow(each, bounces.levels);
  // A gloss shows of other surfaces what the look does not weigh: beside dark matter it is most of what is seen. So may
  // be what a lamp makes bright, and all that lies behind plates.
  const bool drop = once_missed <= share && !plan.matter.glossy && !plan.matter.plates && plan.lamps.sources() == 0;
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
  if (drop) plan.bounces = {};
  if (drop && plan.baked)
    plan.baked = std::make_shared<plan::BakedRows>();  // rows of the skeleton are none of this one's
  return drop;
}

}  // namespace raycube::planner
