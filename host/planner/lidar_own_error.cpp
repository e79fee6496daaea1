#include "host/planner/lidar_own_error.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/planner/lidar_fire.h"
#include "host/planner/plan_lines.h"

namespace raycube::planner {

namespace {

constexpr double kOwnRays = 3e5, kOwnPart = 0.01;  ///< first rays in all, or this part of the survey's
constexpr int kLeastDraws = 8, kMostPulses = 256, kLeastReference = 256, kCrop_px = 8;
/// Two patterns that share less than this of their squared light in the same bins are too coarse to tell how much
/// light there is: it is taken to be this much, and the error, which is several times the waveform, is less than it is.
constexpr double kLeastShared = 0.1;

/// The middle of a receiver's array: its pixels stand about the axis, whatever their number.
lidar::LidarPlan cropped(const lidar::LidarPlan& plan) {
  lidar::LidarPlan out = plan;
  auto& receiver = out.lidar.receiver;
  if (receiver_sampling(plan))
    receiver.columns = std::min(receiver.columns, kCrop_px), receiver.rows = std::min(receiver.rows, kCrop_px);
  return out;
}

/// What is fired: pulses, and how often on other patterns.
struct Shooting {
  std::vector<std::uint64_t> pulses;
  int rounds = 1, reference_subrays = kLeastReference;
};

Shooting planned(const lidar::LidarPlan& plan) {
  Shooting out;
  const int subrays = plan.lidar.transport.subrays;
  out.reference_subrays = std::max(subrays, kLeastReference);
  const double fans = receiver_sampling(plan) ? static_cast<double>(plan.pixels()) : 1;
  const double draw = fans * (subrays + 2.0 * out.reference_subrays);
  const double budget = std::max(kOwnRays, kOwnPart * fans * subrays * static_cast<double>(plan.lidar.pulses));
  const double draws = std::clamp(budget / draw, double{kLeastDraws}, double{kMostPulses});
  const double held = static_cast<double>(kComparedFloats) / (3 * static_cast<double>(floats_of_pulse(plan)));
  const double wanted = std::min(receiver_sampling(plan) ? draws / kLeastDraws : draws, held);
  out.pulses = hashed_pulses(plan, kMostPulses);  // more than are wanted: not every one is fired
  const auto count = static_cast<std::size_t>(std::max(1.0, wanted));
  std::vector<std::uint64_t> even;
  for (std::size_t i = 0; i < std::min(count, out.pulses.size()); ++i)
    even.push_back(out.pulses[i * out.pulses.size() / std::min(count, out.pulses.size())]);
  out.pulses = even;
  const int independent = receiver_sampling(plan) ? 1 : static_cast<int>(even.size());
  out.rounds = independent > 0 ? std::max(1, (kLeastDraws + independent - 1) / independent) : 1;
  return out;
}

/// Sums over the bins of a pulse.
struct Compared {
  double difference = 0;  ///< (a - r)(a - s)
  double shared = 0;      ///< r s
  double power = 0;       ///< (r^2 + s^2) / 2
  double own = 0;         ///< a^2
  void add(const std::vector<float>& own_row, const std::vector<float>& one, const std::vector<float>& two) {
    for (std::size_t i = 0; i < own_row.size(); ++i) {
      const double a = own_row[i], r = one[i], s = two[i];
      difference += (a - r) * (a - s), shared += r * s, power += 0.5 * (r * r + s * s), own += a * a;
    }
  }
};

/// Draws of the error: pulses on each pattern; of a receiver patterns.
std::vector<Compared> drawn(render::LidarRenderer& renderer, const lidar::LidarPlan& plan, const Shooting& shooting) {
  std::uint64_t rays = 0;
  const Waveforms own =
      fire_pulses(renderer, plan, shooting.pulses, {plan.lidar.transport.subrays, plan.seed, false}, rays);
  std::vector<Compared> out;
  for (int round = 0; round < shooting.rounds; ++round) {
    const std::uint64_t first = plan.seed + static_cast<std::uint64_t>(5 + 2 * round) * kOtherPulses;
    const Waveforms one = fire_pulses(renderer, plan, shooting.pulses, {shooting.reference_subrays, first, true}, rays);
    const Waveforms two =
        fire_pulses(renderer, plan, shooting.pulses, {shooting.reference_subrays, first + kOtherPulses, true}, rays);
    for (std::size_t p = 0; p < own.pulse.size(); ++p) {
      if (p == 0 || !receiver_sampling(plan)) out.emplace_back();
      out.back().add(own.pulse[p], one.pulse[p], two.pulse[p]);
    }
  }
  return out;
}

}  // namespace

LidarOwnError own_error(render::LidarRenderer& renderer, const lidar::LidarPlan& given, const LidarDecision& decision) {
  LidarOwnError out;
  out.tolerance = decision.tolerance;
  if (decision.estimated) {
    out.total = decision.error, out.likely = decision.likely;
    out.from = fmt::format("the plan's trial of {} pulses", decision.trial_pulses);
    return out;
  }
  const lidar::LidarPlan plan = cropped(given);
  if (3 * floats_of_pulse(plan) > kComparedFloats) {
    out.from = "a pulse's waveforms are too many to be held three times; `raycube plan` measures it";
    return out;
  }
  const Shooting shooting = planned(plan);
  if (shooting.pulses.empty()) {
    out.from = "none of the pulses tried is fired";
    return out;
  }
  const std::vector<Compared> draws = drawn(renderer, plan, shooting);
  double sum = 0, squares = 0, shared = 0, power = 0, own = 0;
  for (const Compared& one : draws)
    sum += one.difference, squares += one.difference * one.difference, shared += one.shared, power += one.power,
        own += one.own;
  const auto count = static_cast<double>(draws.size());
  const double whole = std::max(shared, kLeastShared * power) / count;
  if (!(whole > 0)) {
    out.from =
        "of " + std::to_string(shooting.pulses.size()) + " tried, " +
        (own > 0 ? "no pulse shows light in the gate to others than the run's own sub-rays; `raycube plan` tries more"
                 : "no pulse shows light of surfaces in the gate");
    return out;
  }
  const double average = sum / count,
               standard_error = std::sqrt(std::max(0.0, squares / count - average * average) / (count - 1));
  out.likely = std::sqrt(std::max(0.0, average) / whole);
  out.total = std::sqrt((std::max(0.0, average) + 2 * standard_error) / whole);
  out.from = fmt::format("{} {} fired {} times{}; `raycube plan` measures it", shooting.pulses.size(),
                         shooting.pulses.size() == 1 ? "pulse" : "pulses", 1 + 2 * shooting.rounds,
                         plan.pixels() < given.pixels() ? fmt::format(" in the middle {} pixels", plan.pixels()) : "");
  return out;
}

std::string own_error_text(const LidarOwnError& e) {
  if (!e.known()) return "error of the waveforms not known: " + e.from;
  return fmt::format(
      "error of the waveforms about {}, at most {}, of {:.3g} % tolerated{} (sub-rays, of surfaces; by {})",
      percent_text(e.likely), percent_text(e.total), 100 * e.tolerance, e.kept() ? "" : ": NOT KEPT", e.from);
}

std::string own_error_json(const LidarOwnError& e) {
  using Json = nlohmann::json;
  const auto of = [&](const Json& value) { return e.known() ? value : Json(); };
  return Json{{"tolerance", e.tolerance},
              {"total", of(e.total)},
              {"likely", of(e.likely)},
              {"within_tolerance", of(e.kept())},
              {"from", e.from}}
      .dump();
}

}  // namespace raycube::planner
