#include "host/planner/planner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/planner/judged_pixels.h"
#include "host/planner/plan_lines.h"
#include "host/planner/replicated.h"
#include "host/planner/sample_pattern.h"

namespace raycube::planner {

namespace {

constexpr int kMostTriedSamples = 1024;  ///< beyond, the law holds: more tell less than they cost
constexpr int kMostTriedDirections = 256;
constexpr int kMostRounds = 3;                        ///< settings tried after the first look
constexpr double kWorthATry = 0.75;                   ///< of the cost: a try takes up to a quarter of a render
constexpr double kMeasuring_s_per_wavelength = 1e-3;  ///< of the table, nominal: 2 s for the park's
constexpr double kWorthMeasuring = 0.3;  ///< of the tolerance: less takes 5 % of what is left for samples and sky

double squared(double x) { return x * x; }

/// What nodes and components of this error leave of the tolerance to samples and sky.
double left_of(const scene::Simulation& simulation, double plan_error) {
  return left_beside(simulation.tolerance_of.figure, kUse * simulation.tolerance, plan_error);
}

/// Level before `level` of a list, or 0.
int before(const std::vector<int>& levels, int level) {
  const auto at = std::lower_bound(levels.begin(), levels.end(), level);
  return at == levels.begin() ? 0 : *std::prev(at);
}

}  // namespace

const std::vector<int>& direction_levels() {
  static const std::vector<int> all = {1,  2,  3,  4,   5,   6,   8,   10,  12,  16,  20,   24,   32,   40,   48,
                                       64, 80, 96, 128, 160, 192, 256, 384, 512, 768, 1024, 1536, 2048, 3072, 4096};
  return all;
}

namespace {

std::vector<BandSquares> squares_of(const LevelErrors& errors, const std::vector<int>& levels) {
  std::vector<BandSquares> out;
  for (const int level : levels) out.emplace_back(errors(level));
  return out;
}

}  // namespace

Choice choose(const LevelErrors& of_samples, const LevelErrors& of_directions, double budget, const PixelCost& cost_s,
              const std::vector<int>& samples, const std::vector<int>& directions) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::vector<BandSquares> with_samples = squares_of(of_samples, samples),
                                 with_directions = squares_of(of_directions, directions);
  struct Pair {
    double cost_s;
    std::size_t samples, directions;
  };
  std::vector<Pair> pairs;
  for (std::size_t n = 0; n < samples.size(); ++n)
    for (std::size_t k = 0; k < directions.size(); ++k) pairs.push_back({cost_s(samples[n], directions[k]), n, k});
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.cost_s < b.cost_s; });
  std::size_t band = 0;  // in which the pair before erred too much: likely this one does there too
  const auto error = [&](const Pair& p, double enough) {
    return with_samples[p.samples].with(with_directions[p.directions], enough, band);
  };
  const auto chosen = [&](const Pair& p, bool within) {
    return Choice{samples[p.samples], directions[p.directions], within};
  };
  const auto dear =
      std::find_if(pairs.begin(), pairs.end(), [](const Pair& p) { return 1e6 * p.cost_s > kMost_s_per_megapixel; });
  if (dear == pairs.begin()) return chosen(pairs[0], error(pairs[0], infinity) <= squared(budget));
  for (auto p = pairs.begin(); p != dear; ++p)
    if (error(*p, squared(budget)) <= squared(budget)) return chosen(*p, true);
  auto best = pairs.begin();
  double least = infinity;
  for (auto p = pairs.begin(); p != dear; ++p)
    if (const double here = error(*p, least); here < least) least = here, best = p;
  return chosen(*best, false);
}

namespace {

/// Sky directions of the first look: its own, or fewer where the file gives fewer.
int look_directions(const Decision& out, const scene::Simulation& simulation) {
  return out.directions_given ? std::min(simulation.sky_directions, kLookDirections) : kLookDirections;
}

/// Tries samples and directions on the scene's own pixels until the cheapest levels that hold the tolerance are known.
/// What is measured is told in the decision.
class LevelSearch {
 public:
  /// Keeps references. out: with what the file gives, and the error of nodes and components.
  LevelSearch(PixelTrial& trial, const scene::Simulation& simulation, const scene::Instrument& instrument,
              const plan::Plan& plan, Decision& out)
      : trial_(trial),
        simulation_(simulation),
        instrument_(instrument),
        plan_(plan),
        out_(out),
        sky_(plan.sends_rays()),
        pattern_(sample_pattern(instrument)),
        samples_(out.samples_given ? std::vector<int>{1} : pattern_.levels),
        directions_(direction_levels()) {
    if (out.directions_given) directions_ = {simulation.sky_directions};
    if (!sky_) directions_ = {1};
    take_look();
  }

  /// What nodes and components of this error leave of the tolerance to samples and sky.
  double left_by(double plan_error) const { return left_of(simulation_, plan_error); }

  /// Nominal seconds of the whole image if nodes and components err by this much; infinite where the look knows of no
  /// setting that would do.
  double image_s(double plan_error) {
    const LevelErrors hoped = [&](int n) { return of_samples_.hoped(n); };
    const LevelErrors hoped_sky = [&](int k) { return of_directions_.hoped(k); };
    const Choice choice = choose(
        hoped, hoped_sky, left_by(plan_error), [&](int n, int k) { return cost_s(n, k); }, samples_, directions_);
    const double pixels = static_cast<double>(instrument_.pixels) * instrument_.lines;
    return choice.within ? pixels * cost_s(choice.samples, choice.directions) : std::numeric_limits<double>::infinity();
  }

  /// The cheapest levels; one sample stands for those that are given.
  Choice settle() {
    const double budget = left_by(out_.plan_error);
    const LevelErrors known = [&](int n) { return of_samples_.errors(n); };
    const LevelErrors hoped = [&](int n) {
      return n <= kMostTriedSamples ? of_samples_.hoped(n) : of_samples_.errors(n);
    };
    const LevelErrors sky = [&](int k) { return sky_errors(k); };
    const LevelErrors hoped_sky = [&](int k) {
      return k <= kMostTriedDirections ? of_directions_.hoped(k) : sky_errors(k);
    };
    const PixelCost cost = [&](int n, int k) { return cost_s(n, k); };
    for (int round = 0; round < kMostRounds; ++round) {
      Choice choice = choose(hoped, hoped_sky, budget, cost, samples_, directions_);
      if (out_.measure.figure != scene::ErrorFigure::rms) choice = as_may_be_tried(choice);
      // A level that only might do is worth a try where it saves much.
      const Choice safe = choose(known, sky, budget, cost, samples_, directions_);
      if (safe.within && cost_s(choice.samples, choice.directions) > kWorthATry * cost_s(safe.samples, safe.directions))
        choice = safe;
      // Between levels that were measured the law does not err by what another try would take.
      if (safe.within && choice.samples == safe.samples && choice.directions == safe.directions && between(safe)) break;
      if (!try_setting(choice)) break;
    }
    // Rounds spent: what was measured counts, the rest is the law's.
    return choose(known, sky, budget, cost, samples_, directions_);
  }

  /// The next choice where a draw of this one is off by `drawn`, more than nodes and components leave.
  Choice finer(const Choice& choice, double drawn) {
    const double left = left_by(out_.plan_error);
    const LevelErrors known = [&](int n) { return of_samples_.errors(n); };
    const LevelErrors sky = [&](int k) { return sky_errors(k); };
    stricter_ *= left / drawn;
    // Of other figures the law may say less than the draw: then as much less than the law.
    if (out_.measure.figure != scene::ErrorFigure::rms)
      stricter_ = std::min(stricter_, bound_together(known(choice.samples), sky(choice.directions)) / drawn);
    return choose(
        known, sky, stricter_ * left, [&](int n, int k) { return cost_s(n, k); }, samples_, directions_);
  }

  double cost_s(int samples, int directions) const {
    const double given = static_cast<double>(instrument_.samples_u) * instrument_.samples_v;
    return CostModel().seconds(
        pixel_counts(plan_, out_.samples_given ? given : samples, directions, out_.sampling.paths_per_two));
  }

  const ErrorLaw& of_samples() const { return of_samples_; }
  const ErrorLaw& of_directions() const { return of_directions_; }

 private:
  /// The same, no finer than what is tried: the law of rare errors is not trusted as far as that of the rms.
  Choice as_may_be_tried(const Choice& choice) const {
    const auto at_most = [](const std::vector<int>& levels, int level, int most) {
      return level <= most ? level : std::max(levels.front(), before(levels, most + 1));
    };
    return {at_most(samples_, choice.samples, kMostTriedSamples),
            at_most(directions_, choice.directions, kMostTriedDirections), choice.within};
  }

  void add(ErrorLaw& law, int level, const TrialError& found, const std::string& what) {
    const TrialError error = of_pixels(found, instrument_);
    law.measured(level, error.bands);
    out_.measured.push_back(
        fmt::format("{}: {:.2g} %, at most {:.2g} %", what, 100 * error.estimate, 100 * error.bound));
    sky_errors_.clear();
  }

  void add_samples(int level, const TrialError& error) { add(of_samples_, level, error, pattern_.name(level)); }
  void add_sky(int level, const TrialError& error) {
    add(of_directions_, level, error, fmt::format("directions {}", level));
  }

  /// Its own setting is a level like any other where samples are to be chosen.
  void take_look() {
    if (!sky_) add_sky(1, {0, 0, {{0}, {0}}});
    if (out_.samples_given) return try_given();
    add_samples(pattern_.look, trial_.look().samples);
    if (sky_) add_sky(look_directions(out_, simulation_), trial_.look().sky);
  }

  /// Samples that are given, with the directions that are given or a first level of them.
  void try_given() {
    const int directions = out_.directions_given ? simulation_.sky_directions : kLookDirections;
    if (instrument_.sampler != scene::SamplerKind::grid) {
      const SettingErrors found =
          trial_.replicates(instrument_.sampler, instrument_.samples_u, instrument_.samples_v, directions);
      add(of_samples_, 1, found.samples, "samples given");
      if (sky_) add_sky(directions, found.sky);
      return;
    }
    add(of_samples_, 1, trial_.sampling_error(instrument_.sampler, instrument_.samples_u, instrument_.samples_v),
        "samples given");
    if (sky_) add_sky(directions, trial_.sky_error(directions, instrument_.samples_u, instrument_.samples_v));
  }

  bool between(const Choice& choice) const {
    return (out_.samples_given || of_samples_.spans(choice.samples)) &&
           (!sky_ || of_directions_.spans(choice.directions));
  }

  /// Tries what of a choice was not measured; false: all of it was, or is past what is tried.
  bool try_setting(const Choice& choice) {
    const bool new_samples =
        !out_.samples_given && !of_samples_.has(choice.samples) && choice.samples <= kMostTriedSamples;
    const bool new_sky = sky_ && !of_directions_.has(choice.directions) && choice.directions <= kMostTriedDirections;
    if (!new_samples && !new_sky) return false;
    const int directions = std::min(choice.directions, kMostTriedDirections);
    if (out_.samples_given && instrument_.sampler == scene::SamplerKind::grid) {
      add_sky(directions, trial_.sky_error(directions, instrument_.samples_u, instrument_.samples_v));
      return true;
    }
    if (!new_samples && !out_.samples_given) {
      add_sky(directions, trial_.sky_error(std::min(choice.samples, kMostTriedSamples), directions));
      return true;
    }
    const int samples = std::min(choice.samples, kMostTriedSamples);
    const auto replicates = [&](int of_directions) {
      return out_.samples_given
                 ? trial_.replicates(instrument_.sampler, instrument_.samples_u, instrument_.samples_v, of_directions)
                 : trial_.replicates(samples, of_directions);
    };
    // Few directions are too noisy to see the samples' error beside theirs.
    const int quiet = out_.directions_given ? directions : std::max(directions, kLookDirections);
    const SettingErrors found = replicates(quiet);
    if (!out_.samples_given) add_samples(samples, found.samples);
    if (sky_) add_sky(quiet, found.sky);
    if (sky_ && quiet != directions) add_sky(directions, replicates(directions).sky);
    return true;
  }

  /// Of the law as it is: most choices differ by what was measured of the sides.
  const BandErrors& sky_errors(int level) {
    const auto [at, fresh] = sky_errors_.try_emplace(level);
    if (fresh) at->second = of_directions_.errors(level);
    return at->second;
  }

  PixelTrial& trial_;
  const scene::Simulation& simulation_;
  const scene::Instrument& instrument_;
  const plan::Plan& plan_;
  Decision& out_;
  bool sky_;
  const SamplePattern& pattern_;
  ErrorLaw of_samples_{kSamplesLaw}, of_directions_{kDirectionLaw};
  std::map<int, BandErrors> sky_errors_;
  double stricter_ = 1;                    ///< part of the budget that choices are held to since draws were off
  std::vector<int> samples_, directions_;  ///< levels to choose from
};

/// The settings of the levels chosen, where the file does not give them.
void take_levels(Decision& out, const plan::Plan& plan, const Choice& choice, const SamplePattern& pattern) {
  out.estimated = true;
  if (!out.samples_given)
    out.sampling.sampler = pattern.sampler, out.sampling.samples_u = pattern.along(choice.samples),
    out.sampling.samples_v = pattern.across(choice.samples);
  if (!out.directions_given) out.sampling.directions = choice.directions;
  count_cost(out, plan);
}

/// The errors of the levels chosen, and of those before them.
void take_errors(Decision& out, const Choice& choice, const ErrorLaw& of_samples, const ErrorLaw& of_directions,
                 bool sky, const SamplePattern& pattern) {
  out.samples_error = of_samples.bound(choice.samples);
  out.sky_error = sky ? of_directions.bound(choice.directions) : 0;
  if (const int less = before(pattern.levels, choice.samples); less > 0 && !out.samples_given)
    out.samples_less_error = of_samples.estimate(less);
  if (const int less = before(direction_levels(), choice.directions); less > 0 && sky && !out.directions_given)
    out.sky_less_error = of_directions.estimate(less);
  out.total_error =
      together(out.measure.figure, out.plan_error,
               bound_together(of_samples.errors(choice.samples), of_directions.errors(choice.directions)));
  out.within = out.total_error <= out.tolerance;
}

/// Notes a tolerance that is not kept, or that is dear.
void note_tolerance(Decision& out, const std::string& name) {
  if (!out.within)
    out.notes.push_back(fmt::format(
        "{}: the tolerance of {:.3g} % ({}) is not kept: estimated error {:.3g} % (nodes and components {:.3g} %, "
        "samples {:.3g} %, sky directions {:.3g} %, each of its own worst band){}; raise the tolerance{}",
        name, 100 * out.tolerance, measure_text(out.measure), 100 * out.total_error, 100 * out.plan_error,
        100 * out.samples_error, 100 * out.sky_error,
        out.samples_given || out.directions_given
            ? std::string(", with what the file gives")
            : fmt::format(", with the best that takes {:.0f} s per megapixel", kMost_s_per_megapixel),
        out.samples_given || out.directions_given ? " or remove samples and sky_directions from the file" : ""));
  else if (out.dear)
    out.notes.push_back(
        fmt::format("{}: the tolerance of {:.3g} % cannot be kept within {:.0f} s per megapixel (nominal machine of 2 "
                    "cores): {} x {} samples and {} sky "
                    "directions take about {:.3g} s; raise the tolerance, or give fewer of either",
                    name, 100 * out.tolerance, kDear_s_per_megapixel, out.sampling.samples_u, out.sampling.samples_v,
                    out.sampling.directions, out.s_per_megapixel));
}

/// Whether nodes and components are held against the whole tables: where their estimate takes much of the tolerance and
/// what the image would save if they erred by half of it is more than that takes, or where only errors are asked for.
bool measuring_pays(const Decision& out, LevelSearch& search, const plan::Plan& plan, bool all_given) {
  if (out.model_pixels > 0 || out.plan_estimate <= kWorthMeasuring * out.tolerance) return false;
  const double takes_s = kMeasuring_s_per_wavelength * static_cast<double>(plan.report.table_nodes);
  const double as_estimated_s = search.image_s(out.plan_estimate);
  return all_given || std::isinf(as_estimated_s) || as_estimated_s - search.image_s(out.plan_estimate / 2) > takes_s;
}

/// Refines the choice until the draw that the image will have is inside the tolerance, in the trial's pixels.
/// Returns the bound of that draw's error.
double hold_draw(PixelTrial& trial, LevelSearch& search, const scene::Instrument& instrument,
                 const SamplePattern& pattern, Choice& choice, Decision& out) {
  for (int round = 0;; ++round) {
    const TrialError own = of_pixels(trial.own_draw(choice.samples, choice.directions), instrument);
    out.measured.push_back(fmt::format("{}, directions {}, the image's own draw: {:.2g} %, at most {:.2g} %",
                                       pattern.name(choice.samples), choice.directions, 100 * own.estimate,
                                       100 * own.bound));
    if (together(out.measure.figure, out.plan_error, own.bound) <= out.tolerance || round == kMostRounds)
      return own.bound;
    const Choice next = search.finer(choice, own.bound);
    if (search.cost_s(next.samples, next.directions) <= search.cost_s(choice.samples, choice.directions))
      return own.bound;
    choice = next;
  }
}

/// How many paths go with the sky's rays, where both are the planner's.
void share_paths(Decision& out, PixelTrial& trial) {
  out.sampling.paths_per_two = trial.choose_paths();
  if (out.sampling.paths_per_two > 1)
    out.measured.push_back(fmt::format("{} paths between surfaces for two rays into the sky err least for their time",
                                       out.sampling.paths_per_two));
}

/// Settles an image that costs less than a trial by rendering it; false: it is none, or would take more.
bool replicate(Decision& out, render::Renderer& renderer, const scene::Simulation& simulation,
               const scene::Instrument& instrument, const plan::Plan& plan) {
  const double left = left_of(simulation, out.plan_error);
  if (left <= 0 || !may_replicate(simulation, instrument, plan)) return false;
  Replicates replicates = render_replicates(renderer, simulation, instrument, plan, left);
  out.measured = std::move(replicates.measured);
  if (replicates.count == 0) return false;
  out.image = std::move(replicates.image);
  out.estimated = true;
  const auto& [samples, directions] = replicates.size;
  out.sampling = {scene::SamplerKind::lattice, samples, 1, directions, replicates.count, 0};
  if (!plan.sends_rays()) out.sampling.directions = simulation.sky_directions;
  count_cost(out, plan);
  out.total_error = std::hypot(out.plan_error, replicates.error.bound);
  out.within = out.total_error <= out.tolerance;
  out.trial_pixels = out.looked_at =
      static_cast<std::size_t>(instrument.pixels) * static_cast<std::size_t>(instrument.lines);
  out.trial_rays = static_cast<std::uint64_t>(out.counts.rays() * static_cast<double>(out.trial_pixels));
  return true;
}

}  // namespace

void count_cost(Decision& decision, const plan::Plan& plan) {
  const Sampling& s = decision.sampling;
  PixelCounts& counts = decision.counts;
  counts = pixel_counts(plan, static_cast<double>(s.samples_u) * s.samples_v, s.directions, s.paths_per_two);
  for (double* count : {&counts.samples, &counts.sun_rays, &counts.sky_rays, &counts.lamp_rays, &counts.lamps,
                        &counts.paths, &counts.path_surfaces, &counts.terms})
    *count *= s.replicates;
  decision.s_per_megapixel = 1e6 * CostModel().seconds(counts);
  // A small image, which is soon rendered, is dear by no pixel.
  decision.dear = decision.sampling.replicates == 1 && decision.s_per_megapixel > kDear_s_per_megapixel;
}

Decision as_given(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan) {
  Decision out;
  out.sampling = {instrument.sampler,      instrument.samples_u, instrument.samples_v, simulation.sky_directions, 1,
                  instrument.first_samples};
  out.samples_given = instrument.samples_given, out.directions_given = simulation.sky_directions_given;
  if (out.directions_given) out.sampling.paths_per_two = simulation.paths_per_two;
  out.tolerance = simulation.tolerance, out.measure = simulation.tolerance_of;
  out.plan_error = out.plan_estimate = plan.report.total_error;
  count_cost(out, plan);
  return out;
}

Decision decide(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument,
                const plan::Plan& plan, const atmos::RenderTable& table, bool estimate_given, int threads,
                TrialProgress progress, const Decision* held) {
  Decision out = as_given(simulation, instrument, plan);
  if (held)
    take_held(out, *held);
  else
    hold_tolerance(out, simulation, instrument, plan, table, threads);
  const bool sky = plan.sends_rays(), rms = out.measure.figure == scene::ErrorFigure::rms;
  const bool all_given = out.samples_given && (out.directions_given || !sky);
  if (all_given && !estimate_given) return out;
  if (replicate(out, renderer, simulation, instrument, plan)) return out;
  PixelTrial trial(renderer, simulation, instrument, plan, look_directions(out, simulation), std::move(progress));
  if (!out.directions_given) share_paths(out, trial);
  if (!trial.meets_listed())
    out.notes.push_back(
        fmt::format("{}: none of {} pixels that were looked at has any of tolerance_materials ({}): all "
                    "pixels count alike",
                    instrument.name, trial.looked_at(), fmt::join(simulation.tolerance_of.materials, ", ")));
  LevelSearch search(trial, simulation, instrument, plan, out);
  if (measuring_pays(out, search, plan, all_given)) measure_plan(out, simulation, instrument, plan, table, threads);
  Choice choice = search.settle();
  const SamplePattern& pattern = sample_pattern(instrument);
  double drawn = -1;
  // Without a reference draws do not tell percentiles of errors as edges make them, a point more or less.
  if ((trial.whole() || !rms) && !out.samples_given && instrument.box_pixels())
    drawn = hold_draw(trial, search, instrument, pattern, choice, out);
  take_levels(out, plan, choice, pattern);
  take_errors(out, choice, search.of_samples(), search.of_directions(), sky, pattern);
  if (drawn >= 0)
    out.total_error = together(out.measure.figure, out.plan_error, drawn),
    out.within = out.total_error <= out.tolerance;
  out.trial_pixels = trial.pixels(), out.looked_at = trial.looked_at(), out.trial_rays = trial.rays();
  note_tolerance(out, instrument.name);
  return out;
}

void add_small_objects(Decision& decision, const scene::Instrument& instrument, sensors::SmallObjectPixels small) {
  using scene::SmallObjects;
  scene::Instrument sampled = instrument;
  sampled.sampler = decision.sampling.sampler;
  sampled.samples_u = decision.sampling.samples_u, sampled.samples_v = decision.sampling.samples_v;
  sampled.replicates = decision.sampling.replicates;
  const bool on = instrument.small_objects == SmallObjects::on ||
                  (instrument.small_objects == SmallObjects::automatic && !decision.samples_given);
  decision.small = sensors::survey_small_objects(std::move(small), sampled, on);
  if (instrument.small_objects == SmallObjects::off || decision.small.missed.empty()) return;
  const std::string note = missed_objects_text(decision.small, sampled);
  if (std::find(decision.notes.begin(), decision.notes.end(), note) == decision.notes.end())
    decision.notes.push_back(note);  // a plan's file may have it
}

void apply(const Decision& decision, scene::Instrument& instrument, plan::Plan& plan) {
  instrument.sampler = decision.sampling.sampler;
  instrument.samples_u = decision.sampling.samples_u, instrument.samples_v = decision.sampling.samples_v;
  instrument.replicates = decision.sampling.replicates;
  instrument.small_objects = decision.small.on ? scene::SmallObjects::on : scene::SmallObjects::off;
  if (plan.sends_rays()) plan.sky.rays = decision.sampling.directions;
  plan.sky.paths_per_two = decision.sampling.paths_per_two;
}

}  // namespace raycube::planner
