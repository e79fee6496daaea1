#include "host/planner/bounce_level.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "host/plan/baked_rows.h"
#include "host/plan/bounces.h"
#include "host/planner/open_share.h"
#include "host/planner/trial_pixels.h"

namespace raycube::planner {

namespace {

constexpr std::uint64_t kBounceLevel = 0x1b873593u;  ///< added to the seed: pixels and draws of its own
constexpr int kLevelRuns = 32, kLevelColumns = 512;  ///< of 8 pixels each; pixels traced at once
constexpr int kLevelPaths = 16;                      ///< of a pixel and draw
/// The skeleton may err by more the less of that light there is, but some places have more of it than most.
constexpr double kLeastPart = 0.25;
constexpr double kMissedShare = 0.1;  ///< of the tolerance
/// Errors are told in so many steps of that: what devices round differently does not move the choice.
constexpr double kToldSteps = 16;
constexpr std::array kLevels = {0, 1, 2, 4, 8, 16};
static_assert(kLevels.back() == scene::kMostChosenBounces);
using Draws = std::array<std::vector<float>, 2>;  ///< radiance [pixel][band] under two seeds

Draws radiances(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& few,
                const plan::Plan& plan, const std::vector<render::Tile>& tiles) {
  Draws out;
  for (std::size_t draw = 0; draw < out.size(); ++draw)
    renderer.probe_together(few, plan, simulation.sun, simulation.seed + kBounceLevel * (draw + 1), tiles,
                            [&](const render::PixelProbe& probe) {
                              out[draw].insert(out[draw].end(), probe.radiance.begin(), probe.radiance.end());
                            });
  return out;
}

/// Of the worst band, over that band's mean of `whole`.
double missed(const Draws& part, const Draws& whole, std::size_t bands) {
  const std::size_t pixels = whole[0].size() / bands;
  std::vector<double> sum(bands), off(bands), product(bands);
  for (std::size_t i = 0; i < whole[0].size(); ++i) {
    const double one = double{whole[0][i]} - double{part[0][i]}, two = double{whole[1][i]} - double{part[1][i]};
    const std::size_t b = i % bands;
    sum[b] += 0.5 * (double{whole[0][i]} + double{whole[1][i]});
    off[b] += 0.5 * (one + two), product[b] += one * two;
  }
  const auto count = static_cast<double>(pixels);
  const std::vector<double> mean = judged_means(std::move(sum), count);
  double worst = 0;
  for (std::size_t b = 0; b < bands; ++b)
    if (mean[b] > 0)
      worst = std::max(worst, std::max(std::sqrt(std::max(0.0, product[b] / count)), off[b] / count) / mean[b]);
  return worst;
}

/// What a geometric series has beyond its sixteenth term, of which `four` and `eight` lie between that and the fourth
/// and the eighth: with y the ratio over four terms, eight / four = y (1 + y) / (1 + y + y^2).
double beyond_last(double four, double eight) {
  if (!(eight > 0)) return 0;
  const double q = four > 0 ? std::min(eight / four, 0.66) : 0.66;  // below 2/3, where y is 1 and nothing ends
  const double y = 0.5 * (std::sqrt(1 + 4 * q / (1 - q)) - 1);
  return eight * y * y / (1 - y * y);
}

/// What the last count misses joins the error of each. Paths that come far are few: beyond four levels no count misses
/// less than it would if each further pair of levels took away the share that the third and fourth did.
void add_rare(std::array<double, kLevels.size()>& error) {
  const double two = error[2], four = error[3];
  const auto at = [&](int levels) { return two > 0 ? four * std::pow(four / two, 0.5 * (levels - 4)) : 0; };
  error.back() = std::max(beyond_last(four, error[4]), at(kLevels.back()));
  error[4] = std::max(error[4], at(kLevels[4]));
  for (std::size_t k = 0; k + 1 < error.size(); ++k) error[k] += error.back();
}

}  // namespace

bool choose_bounces(render::Renderer& renderer, const scene::Simulation& simulation,
                    const scene::Instrument& instrument, plan::Plan& plan) {
  plan::Bounces& bounces = plan.bounces;
  if (simulation.bounces_given || !bounces.any()) return false;
  const scene::Instrument few = first_launched(simulation, instrument, plan);
  const auto tiles = joined(trial_tiles(few, simulation.seed + kBounceLevel, kLevelRuns), kLevelColumns);
  plan::Plan tried = plan;
  tried.sky.rays = kLevelPaths;
  std::array<Draws, kLevels.size()> found;
  for (std::size_t k = 0; k < kLevels.size(); ++k) {
    tried.bounces.levels = kLevels[k];
    found[k] = radiances(renderer, simulation, few, tried, tiles);
  }
  std::array<double, kLevels.size()> error{};
  for (std::size_t k = 0; k + 1 < kLevels.size(); ++k) error[k] = missed(found[k], found.back(), plan.bands.size());
  add_rare(error);
  const double share = kMissedShare * plan.tolerance;
  std::size_t chosen = 0;
  plan::BounceReport& report = plan.report.bounces;
  for (double& missing : error) missing = std::round(missing / share * kToldSteps) / kToldSteps * share;
  while (chosen + 1 < kLevels.size() && error[chosen] > share) ++chosen;
  report = {false, true, error[chosen], error[0]};
  plan.report.total_error = std::hypot(plan.report.total_error, error[chosen]);
  plan.report.within_tolerance = plan.report.total_error <= plan.tolerance;
  std::erase_if(plan.notices, [](const std::string& told) { return told.starts_with(plan::kBetweenSurfaces); });
  if (error[chosen] > share)
    plan.notices.push_back(
        fmt::format("{}{} surfaces after the first leave out {:.2g} % of what is seen (asked: {:.2g} "
                    "%); bounces = 64 is the most",
                    plan::kBetweenSurfaces, kLevels[chosen], 100 * error[chosen], 100 * share));
  plan::plan_bounces(plan, simulation.scene, kLevels[chosen], simulation.sky_directions,
                     bounces.share / std::clamp(error[0] / std::max(bounces.strength, error[0]), kLeastPart, 1.0));
  if (plan.baked) plan.baked = std::make_shared<plan::BakedRows>();  // rows of another skeleton are none of this one's
  return true;
}

}  // namespace raycube::planner
