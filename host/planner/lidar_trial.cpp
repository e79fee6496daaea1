#include "host/planner/lidar_trial.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/lidar/footprint.h"
#include "host/planner/lidar_fire.h"
#include "host/planner/plan_lines.h"

namespace raycube::planner {

namespace {

constexpr int kLookPulses = 8192, kLookSubrays[2] = {6, 9};  ///< of the first look
constexpr int kTrialPulses = 768, kFirstSubrays = 64, kReferenceSubrays = 2048, kMostPulseRounds = 12;
constexpr double kUseOfPulses = 0.9;  ///< part of the tolerance that is spent
/// Error of twice the sub-rays over that of a level, squared: taken off their difference.
constexpr double kDoubleShare = 0.38;
constexpr double kWorthAPulseTry = 0.7;  ///< of the sub-rays
constexpr double kReferenceRays =
    8e6;                              ///< neither a reference nor a look at all pulses traces more first rays than this
constexpr double kFinerRays = 6.4e7;  ///< of a reference where the law asks for more sub-rays than the first can judge
constexpr int kFinestSubrays = 16384;

/// What 95 in 100 do not exceed; value and weight of each.
double nearly_most(std::vector<std::pair<double, double>> of) {
  std::sort(of.begin(), of.end());
  double whole = 0, sum = 0;
  for (const auto& [value, weight] : of) whole += weight;
  for (const auto& [value, weight] : of)
    if ((sum += weight) >= 0.95 * whole) return value;
  return of.empty() ? 0 : of.back().first;
}

class LidarTrial {
 public:
  LidarTrial(render::LidarRenderer& renderer, const lidar::LidarPlan& plan) : renderer_(renderer), plan_(plan) {
    fans_ = receiver_sampling(plan) ? static_cast<double>(plan.pixels()) : 1;
    look();
    const double fit = kReferenceRays / (fans_ * static_cast<double>(std::max<std::size_t>(1, pulses_.size())));
    reference_subrays_ = std::clamp(static_cast<int>(fit), 256, kReferenceSubrays);
  }

  /// Estimate and bound (two standard errors over the draws) of the error with `subrays`.
  TrialError error(int subrays) {
    if (one_.pulse.empty())
      one_ = fire(pulses_, reference_subrays_, plan_.seed + kOtherPulses, true),
      two_ = fire(pulses_, reference_subrays_, plan_.seed + 2 * kOtherPulses, true);
    const Waveforms tried = fire(pulses_, subrays, plan_.seed, false);
    double whole = 0, sum = 0, square_sum = 0, even_square_sum = 0, draws = 0;
    std::vector<std::pair<double, double>> of_pulses;  // squared, and how many pulses of the survey each stands for
    for (std::size_t p = 0; p < tried.pulse.size(); ++p) {
      double here = 0, energy = 0;
      for (std::size_t i = 0; i < tried.pulse[p].size(); ++i) {
        const double a = tried.pulse[p][i], r = one_.pulse[p][i], s = two_.pulse[p][i];
        here += (a - r) * (a - s);
        energy += r * s;
      }
      // A pulse that was drawn with more than an even chance counts for less.
      const Draw& draw = draws_[p];
      if (energy > 0) of_pulses.emplace_back(std::max(0.0, here / energy), draw.times / draw.share);
      here /= draw.share;
      sum += draw.times * here;
      square_sum += draw.times * here * here;
      even_square_sum += draw.times * here * here * draw.share;
      whole += draw.times * energy / draw.share;
      draws += draw.times;
    }
    if (!(whole > 0)) return {};
    pulse_error_ = std::sqrt(nearly_most(of_pulses));
    const double average = sum / draws;
    double variance = draws > 1 ? std::max(0.0, square_sum / draws - average * average) / (draws - 1) : 0;
    // The pulses drawn from are themselves but a part of the survey.
    if (looked_at_.size() > 1)
      variance += left_out_ * std::max(0.0, even_square_sum / draws - average * average) /
                  static_cast<double>(looked_at_.size() - 1);
    const double mean_energy = whole / draws;
    return {std::sqrt(std::max(0.0, average / mean_energy)),
            std::sqrt(std::max(0.0, (average + 2 * std::sqrt(variance)) / mean_energy))};
  }

  /// Error over all the pulses looked at, from the difference between `subrays` and twice as many: a pattern may lie
  /// badly in one pulse of a thousand, which the coarse looks did not show. Below 0: too many rays to be told so, or
  /// there was no look (a receiver; every pulse in the trial).
  double error_of_all(int subrays) {
    if (looked_at_.empty() || 3.0 * subrays * static_cast<double>(looked_at_.size()) > kReferenceRays) return -1;
    double squares = 0, whole = 0;
    compare(looked_at_, {subrays, plan_.seed}, {2 * subrays, plan_.seed},
            [&](double difference, double energy) { squares += difference, whole += energy; });
    return whole > 0 ? std::sqrt(squares / whole / (1 + kDoubleShare)) : 0;
  }

  /// Of the sub-rays tried last: of 95 in 100 pulses each of its own waveforms.
  double pulse_error() const { return pulse_error_; }
  std::size_t pulses() const { return pulses_.size(); }
  std::uint64_t rays() const { return rays_; }
  /// References with more sub-rays from now on; false: there are none to be had.
  bool refine() {
    const int finer = static_cast<int>(std::min<double>(
        kFinestSubrays, kFinerRays / (fans_ * static_cast<double>(std::max<std::size_t>(1, pulses_.size())))));
    if (finer <= reference_subrays_) return false;
    reference_subrays_ = finer;
    one_ = two_ = {};
    return true;
  }
  /// The highest level whose error the references can tell.
  int largest_tried() const {
    return *std::prev(std::upper_bound(subray_levels().begin(), subray_levels().end(), reference_subrays_ / 2));
  }

 private:
  /// Two coarse looks at many pulses (not by a receiver: its pulses have many pixels); those where they differ are
  /// drawn for the trial. Where one pulse in a thousand meets a pipe that shines, an even draw of a few hundred may
  /// miss it, and all the error is there (0.19 % found of 0.42 %).
  void look() {
    const auto all = static_cast<std::uint64_t>(std::max<std::int64_t>(plan_.lidar.pulses, 0));
    const double room = kReferenceRays / (fans_ * kReferenceSubrays);
    // A receiver's pulse has rows of many pixels: two say more than four whose reference has half the sub-rays.
    const int draws =
        static_cast<int>(std::clamp(room, receiver_sampling(plan_) ? 2.0 : 4.0, static_cast<double>(kTrialPulses)));
    const auto seen = static_cast<std::uint64_t>(receiver_sampling(plan_) ? draws : kLookPulses);
    pulses_ = hashed_pulses(plan_, seen);
    if (pulses_.size() <= static_cast<std::size_t>(draws)) {
      draws_.assign(pulses_.size(), Draw{});
      return;
    }
    left_out_ = 1 - static_cast<double>(std::min(seen, all)) / static_cast<double>(all);
    std::vector<double> error;
    compare(pulses_, {kLookSubrays[0], plan_.seed + 3 * kOtherPulses}, {kLookSubrays[1], plan_.seed + 4 * kOtherPulses},
            [&](double difference, double) { error.push_back(difference); });
    std::swap(pulses_, looked_at_);
    draws_ = draw_runs(error, plan_.seed, draws);
    for (const Draw& draw : draws_) pulses_.push_back(looked_at_[draw.run]);
  }

  struct Setting {
    int subrays;
    std::uint64_t seed;
  };
  /// each(squared difference, squared second) of every pulse in turn, few pulses at a time.
  template <class Each>
  void compare(const std::vector<std::uint64_t>& pulses, const Setting& first, const Setting& second,
               const Each& each) {
    const std::size_t together =
        std::max<std::size_t>(1, kComparedFloats / std::max<std::size_t>(1, floats_of_pulse(plan_)));
    for (std::size_t from = 0; from < pulses.size(); from += together) {
      const auto at = pulses.begin() + static_cast<std::ptrdiff_t>(from);
      const std::vector<std::uint64_t> some(at,
                                            at + static_cast<std::ptrdiff_t>(std::min(together, pulses.size() - from)));
      const Waveforms one = fire(some, first.subrays, first.seed, false),
                      two = fire(some, second.subrays, second.seed, false);
      for (std::size_t p = 0; p < one.pulse.size(); ++p) {
        double squares = 0, whole = 0;
        for (std::size_t i = 0; i < one.pulse[p].size(); ++i) {
          const double a = one.pulse[p][i], b = two.pulse[p][i];
          squares += (a - b) * (a - b), whole += b * b;
        }
        each(squares, whole);
      }
    }
  }

  Waveforms fire(const std::vector<std::uint64_t>& pulses, int subrays, std::uint64_t seed, bool moved) {
    return fire_pulses(renderer_, plan_, pulses, {subrays, seed, moved}, rays_);
  }

  render::LidarRenderer& renderer_;
  const lidar::LidarPlan& plan_;
  std::vector<std::uint64_t> pulses_, looked_at_;  ///< of the trial; of the first look, where there was one
  std::vector<Draw> draws_;                        ///< of the pulses
  double fans_ = 1, left_out_ = 0;                 ///< left out: share of the survey that the look did not see
  int reference_subrays_ = kReferenceSubrays;
  double pulse_error_ = -1;
  Waveforms one_, two_;
  std::uint64_t rays_ = 0;
};

}  // namespace

const std::vector<int>& subray_levels() {
  static const std::vector<int> all = {1,    2,    3,    4,    6,     8,     12,    16,    24,    32,   48,
                                       64,   96,   128,  192,  256,   384,   512,   768,   1024,  1536, 2048,
                                       3072, 4096, 6144, 8192, 12288, 16384, 24576, 32768, 49152, 65536};
  return all;
}

/// First rays of a pulse.
std::uint64_t rays_of_pulse(const lidar::LidarPlan& plan, int subrays) {
  const bool receiver = plan.lidar.transport.sampling == scene::LidarSampling::receiver;
  return static_cast<std::uint64_t>(subrays) * static_cast<std::uint64_t>(receiver ? plan.pixels() : 1);
}

void set_subrays(lidar::LidarPlan& plan, int subrays) {
  plan.lidar.transport.subrays = subrays;
  plan.footprint = lidar::make_footprint(plan.lidar, lidar::exit_matters(plan.lidar));
}

LidarDecision subrays_as_given(const lidar::LidarPlan& plan, double tolerance) {
  LidarDecision out;
  out.subrays = plan.lidar.transport.subrays;
  out.given = plan.lidar.transport.subrays_given;
  out.tolerance = tolerance;
  out.rays_per_pulse = rays_of_pulse(plan, out.subrays);
  return out;
}

LidarDecision decide_subrays(render::LidarRenderer& renderer, const lidar::LidarPlan& plan, double tolerance,
                             bool estimate_given) {
  LidarDecision out = subrays_as_given(plan, tolerance);
  if ((out.given && !estimate_given) || plan.lidar.pulses < 1) return out;
  LidarTrial trial(renderer, plan);
  ErrorLaw law(kSubrayLaw);
  std::map<int, double> of_pulses;  // of the levels tried
  const auto add = [&](int level) {
    const TrialError error = trial.error(level);
    law.measured(level, error.estimate, error.bound);
    of_pulses[level] = trial.pulse_error();
  };
  if (out.given) {
    if (out.subrays > trial.largest_tried()) trial.refine();
    add(std::min(out.subrays, trial.largest_tried()));
  } else {
    add(kFirstSubrays);
    const auto cheapest = [&](bool tried_alone) {
      for (const int level : subray_levels())
        if ((!tried_alone || law.has(level)) && law.bound(level) <= kUseOfPulses * tolerance) return level;
      return subray_levels().back();
    };
    do {
      for (int round = 0; round < kMostPulseRounds; ++round) {
        out.subrays = cheapest(false);
        // A law drawn from few sub-rays can ask for many times too many: the most that the references can judge are
        // tried first.
        const int probe = std::min(out.subrays, trial.largest_tried());
        if (law.has(probe)) break;
        add(probe);
      }
    } while (out.subrays > trial.largest_tried() && trial.refine());
    // Patterns of 12 and 16 sub-rays can lie the other way round than their law: what the references can judge must
    // have been tried.
    out.subrays = cheapest(false);
    if (!law.has(out.subrays) && out.subrays <= trial.largest_tried()) out.subrays = cheapest(true);
    // Fewer than the law has it may do: the fewest that can be hoped for are tried where that saves much.
    for (int round = 0; round < kMostPulseRounds; ++round) {
      const int hoped = *std::find_if(subray_levels().begin(), std::prev(subray_levels().end()),
                                      [&](int level) { return law.hope(level) <= kUseOfPulses * tolerance; });
      if (law.has(hoped) || hoped > kWorthAPulseTry * out.subrays || hoped > trial.largest_tried()) break;
      add(hoped);
      if (law.bound(hoped) <= kUseOfPulses * tolerance) out.subrays = hoped;
    }
    // What all the pulses looked at say of a level holds for it, and by the law for those above that are too dear to be
    // asked.
    double seen = 0;
    int last_asked = out.subrays;
    const auto all_told = [&](int level) {
      const double error = trial.error_of_all(level);
      seen = error >= 0 ? error : seen * std::pow(static_cast<double>(last_asked) / level, kSubrayLaw.beyond);
      last_asked = level;
      return std::max(seen, law.bound(level));
    };
    while (all_told(out.subrays) > kUseOfPulses * tolerance && out.subrays < subray_levels().back()) {
      out.subrays = *std::upper_bound(subray_levels().begin(), subray_levels().end(), out.subrays);
      if (!law.has(out.subrays) && out.subrays <= trial.largest_tried()) add(out.subrays);
    }
    if (seen > law.bound(out.subrays)) law.measured(out.subrays, seen, seen);
  }
  out.estimated = true;
  out.error = law.bound(out.subrays), out.likely = law.estimate(out.subrays);
  const auto at = std::lower_bound(subray_levels().begin(), subray_levels().end(), out.subrays);
  if (!out.given && at != subray_levels().begin()) out.less_error = law.estimate(*std::prev(at));
  // Of the level, or by the law from the nearest one that was tried.
  const auto tried = of_pulses.lower_bound(out.subrays);
  const auto nearest = tried == of_pulses.end() ? std::prev(tried) : tried;
  out.pulse_error =
      std::max(out.likely, nearest->second * std::pow(double(nearest->first) / out.subrays, kSubrayLaw.beyond));
  out.within = out.error <= tolerance;
  out.trial_pulses = trial.pulses(), out.trial_rays = trial.rays();
  out.rays_per_pulse = rays_of_pulse(plan, out.subrays);
  if (!out.within)
    out.notes.push_back(fmt::format(
        "{}: the tolerance of {:.3g} % is not kept: {} sub-rays leave an estimated {:.3g} % of the waveforms{}",
        plan.lidar.name, 100 * tolerance, out.subrays, 100 * out.error,
        out.given ? "; remove subrays from the file, or raise the tolerance" : "; raise the tolerance"));
  return out;
}

std::vector<PlanLine> lidar_lines(const LidarDecision& d, const lidar::LidarPlan& plan) {
  const auto& t = plan.lidar.transport;
  PlanLine rays{"sub-rays",
                std::to_string(d.subrays),
                d.error,
                d.less_error,
                fmt::format("{} first rays a pulse", d.rays_per_pulse),
                d.given
                    ? d.estimated ? "the file gives them" : "the file gives them; `raycube plan` estimates their error"
                : d.estimated ? fmt::format("trial of {} pulses", d.trial_pulses)
                              : "the default: nothing could be tried",
                d.given};
  return {rays,
          {"bounces", std::to_string(t.max_bounces), -1, -1, fmt::format("{} rays of a sub-ray at most", t.max_bounces),
           "as the file says", true},
          {"line nodes", std::to_string(plan.nodes.size()), -1, -1,
           fmt::format("{} depths of air a path", plan.nodes.size()),
           "Gauss-Hermite nodes of lines with a width, one of others", true}};
}

nlohmann::json lidar_decision_json(const LidarDecision& d, const std::vector<PlanLine>& lines) {
  using Json = nlohmann::json;
  const auto number = [](double value) { return value < 0 ? Json() : Json(value); };
  Json out = {{"tolerance", d.tolerance},
              {"subrays", d.subrays},
              {"error", number(d.error)},
              {"pulse_error", number(d.pulse_error)},
              {"within_tolerance", d.estimated ? Json(d.within) : Json()},
              {"cost", {{"first_rays_per_pulse", d.rays_per_pulse}}},
              {"notes", d.notes},
              {"lines", lines_json(lines)}};
  if (d.estimated) out["trial"] = {{"pulses", d.trial_pulses}, {"rays", d.trial_rays}};
  return out;
}

}  // namespace raycube::planner
