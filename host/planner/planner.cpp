#include "host/planner/planner.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/planner/model_trial.h"
#include "host/planner/plan_lines.h"

namespace raycube::planner {

namespace {

constexpr int kFirstSide = 4;          ///< of the samples' trial, and the smallest grid of the sky's
constexpr int kLargestTriedSide = 32;  ///< beyond, the law holds: 1024 samples a pixel tell less than they cost
constexpr int kMostTriedDirections = 256;
constexpr int kSkyLevels[] = {4, 16, 64};
constexpr int kMostRounds = 16;
constexpr double kWorthATry = 0.85;  ///< of the cost
constexpr int kFineDirections =
    1024;  ///< of a plan that would not hold its tolerance by fewer; as many as `check` looks in
constexpr double kWorthMeasuring = 0.3;  ///< of the tolerance: less takes 5 % of what is left for samples and sky

double squared(double x) { return x * x; }

/// Level before `level` of a list, or 0.
int before(const std::vector<int>& levels, int level) {
  const auto at = std::lower_bound(levels.begin(), levels.end(), level);
  return at == levels.begin() ? 0 : *std::prev(at);
}

}  // namespace

const std::vector<int>& side_levels() {
  static const std::vector<int> all = [] {
    std::vector<int> levels;
    for (int side = 1; side <= 32; ++side) levels.push_back(side);
    for (const int side : {36, 40, 45, 50, 56, 64, 72, 80, 90, 100, 112, 128, 144, 160, 180, 200, 225, 256})
      levels.push_back(side);
    return levels;
  }();
  return all;
}

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

Choice choose(const LevelErrors& side, const LevelErrors& direction, double budget, const PixelCost& cost_s,
              const std::vector<int>& sides, const std::vector<int>& directions) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const std::vector<BandSquares> of_side = squares_of(side, sides), of_direction = squares_of(direction, directions);
  struct Pair {
    double cost_s;
    std::size_t side, direction;
  };
  std::vector<Pair> pairs;
  for (std::size_t n = 0; n < sides.size(); ++n)
    for (std::size_t k = 0; k < directions.size(); ++k) pairs.push_back({cost_s(sides[n], directions[k]), n, k});
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.cost_s < b.cost_s; });
  std::size_t band = 0;  // in which the pair before erred too much: likely this one does there too
  const auto error = [&](const Pair& p, double enough) {
    return of_side[p.side].with(of_direction[p.direction], enough, band);
  };
  const auto chosen = [&](const Pair& p, bool within) {
    return Choice{sides[p.side], directions[p.direction], within};
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

/// Puts what is measured in place of the estimate.
void measure_plan(Decision& out, const scene::Simulation& simulation, const scene::Instrument& instrument,
                  const plan::Plan& plan, const atmos::RenderTable& table, int threads) {
  ModelError error = model_error(simulation, instrument, plan, table, threads);
  if (error.total.bound > simulation.tolerance)
    error = model_error(simulation, instrument, plan, table, threads, kFineDirections);
  out.plan_error = error.total.bound;
  out.model_pixels = error.pixels;
  out.measured.push_back(fmt::format(
      "nodes and components: {:.2g} %, at most {:.2g} % (sun {:.2g}, sky {:.2g}, path {:.2g}, ground around {:.2g}, "
      "emission {:.2g}), {} pixels against the whole tables",
      100 * error.total.estimate, 100 * error.total.bound, 100 * error.sun.estimate, 100 * error.sky.estimate,
      100 * error.path.estimate, 100 * error.environment.estimate, 100 * error.emission.estimate, error.pixels));
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
        sky_(plan.components() > 0),
        budget_(std::sqrt(std::max(0.0, squared(kUse * simulation.tolerance) - squared(out.plan_error)))),
        direction_(kDirectionLaw),
        sides_(out.samples_given ? std::vector<int>{1} : side_levels()),
        directions_(direction_levels()) {
    if (out.directions_given) directions_ = {simulation.sky_directions};
    if (!sky_) directions_ = {1};
  }

  /// The first levels of directions.
  void try_sky() {
    if (!sky_) {
      add(direction_, 1, {0, 0, {{0}, {0}}}, "directions");
    } else if (out_.directions_given) {
      try_directions(simulation_.sky_directions);
    } else {
      for (const int level : kSkyLevels) try_directions(level);
    }
  }

  /// The cheapest levels with one sampler; `side` holds what was measured of it.
  Choice settle(scene::SamplerKind sampler, ErrorLaw& side) {
    try_first_side(sampler, side);
    const LevelErrors known = [&](int n) { return side.errors(n); };
    const LevelErrors hoped = [&](int n) { return n <= kLargestTriedSide ? side.hoped(n) : side.errors(n); };
    const LevelErrors sky = [&](int k) { return sky_errors(k); };
    const PixelCost cost = [&](int n, int k) { return cost_s(n, k); };
    Choice choice;
    for (int round = 0; round < kMostRounds; ++round) {
      choice = choose(hoped, sky, budget_, cost, sides_, directions_);
      // A level that only might do is worth a try where it saves much.
      const Choice safe = choose(known, sky, budget_, cost, sides_, directions_);
      if (safe.within && cost_s(choice.side, choice.directions) > kWorthATry * cost_s(safe.side, safe.directions))
        choice = safe;
      bool changed = false;
      if (!out_.samples_given && !side.has(choice.side) && choice.side <= kLargestTriedSide) {
        try_side(sampler, choice.side, side);
        changed = true;
      }
      if (!changed && sky_ && choice.directions <= kMostTriedDirections && !out_.directions_given &&
          !direction_.has(choice.directions)) {
        try_directions(choice.directions);
        changed = true;
      }
      if (!changed) break;
    }
    // Rounds spent: what was measured counts, the rest is the law's.
    return choose(known, sky, budget_, cost, sides_, directions_);
  }

  double cost_s(int side, int directions) const {
    const double given = static_cast<double>(instrument_.samples_u) * instrument_.samples_v;
    const double samples = out_.samples_given ? given : static_cast<double>(side) * side;
    return CostModel().seconds(pixel_counts(plan_, samples, directions));
  }

  const ErrorLaw& direction() const { return direction_; }

 private:
  void add(ErrorLaw& law, int level, const TrialError& error, const char* what) {
    law.measured(level, error.bands);
    out_.measured.push_back(
        fmt::format("{} {}: {:.2g} %, at most {:.2g} %", what, level, 100 * error.estimate, 100 * error.bound));
  }

  /// With at least as many samples as rays, as most renders have: then no two rays share a sample.
  void try_directions(int level) {
    int u = std::max(kFirstSide, static_cast<int>(std::ceil(std::sqrt(level)))), v = u;
    if (out_.samples_given) u = instrument_.samples_u, v = instrument_.samples_v;
    add(direction_, level, trial_.sky_error(level, u, v), "directions");
    sky_errors_.clear();
  }

  /// Of the law as it is: most choices differ by what was measured of the sides.
  const BandErrors& sky_errors(int level) {
    const auto [at, fresh] = sky_errors_.try_emplace(level);
    if (fresh) at->second = direction_.errors(level);
    return at->second;
  }

  void try_side(scene::SamplerKind sampler, int level, ErrorLaw& side) {
    add(side, level, trial_.sampling_error(sampler, level, level),
        sampler == scene::SamplerKind::lattice ? "lattice, side" : "grid, side");
  }

  /// Level 1 stands for samples that are given.
  void try_first_side(scene::SamplerKind sampler, ErrorLaw& side) {
    if (out_.samples_given)
      add(side, 1, trial_.sampling_error(sampler, instrument_.samples_u, instrument_.samples_v), "samples given, as");
    else
      try_side(sampler, kFirstSide, side);
  }

  PixelTrial& trial_;
  const scene::Simulation& simulation_;
  const scene::Instrument& instrument_;
  const plan::Plan& plan_;
  Decision& out_;
  bool sky_;
  double budget_;  ///< what nodes and components leave of the tolerance
  ErrorLaw direction_;
  std::map<int, BandErrors> sky_errors_;
  std::vector<int> sides_, directions_;  ///< levels to choose from
};

/// The settings of the levels chosen, where the file does not give them.
void take_levels(Decision& out, const plan::Plan& plan, const Choice& choice, scene::SamplerKind sampler) {
  out.estimated = true;
  if (!out.samples_given) out.sampling.sampler = sampler, out.sampling.samples_u = out.sampling.samples_v = choice.side;
  if (!out.directions_given) out.sampling.directions = choice.directions;
  out.counts =
      pixel_counts(plan, static_cast<double>(out.sampling.samples_u) * out.sampling.samples_v, out.sampling.directions);
  out.s_per_megapixel = 1e6 * CostModel().seconds(out.counts);
  out.dear = out.s_per_megapixel > kDear_s_per_megapixel;
}

/// The errors of the levels chosen, and of those before them.
void take_errors(Decision& out, const Choice& choice, const ErrorLaw& side, const ErrorLaw& direction, bool sky) {
  out.samples_error = side.bound(choice.side);
  out.sky_error = sky ? direction.bound(choice.directions) : 0;
  if (const int less = before(side_levels(), choice.side); less > 0 && !out.samples_given)
    out.samples_less_error = side.estimate(less);
  if (const int less = before(direction_levels(), choice.directions); less > 0 && sky && !out.directions_given)
    out.sky_less_error = direction.estimate(less);
  out.total_error =
      std::hypot(out.plan_error, bound_together(side.errors(choice.side), direction.errors(choice.directions)));
  out.within = out.total_error <= out.tolerance;
}

/// Notes a tolerance that is not kept, or that is dear.
void note_tolerance(Decision& out, const std::string& name) {
  if (!out.within)
    out.notes.push_back(fmt::format(
        "{}: the tolerance of {:.3g} % is not kept: estimated error {:.3g} % (nodes and components {:.3g} %, samples "
        "{:.3g} %, sky directions {:.3g} %, each of its own worst band){}; raise the tolerance{}",
        name, 100 * out.tolerance, 100 * out.total_error, 100 * out.plan_error, 100 * out.samples_error,
        100 * out.sky_error,
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

}  // namespace

Decision as_given(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan) {
  Decision out;
  out.sampling = {instrument.sampler, instrument.samples_u, instrument.samples_v, simulation.sky_directions,
                  instrument.first_samples};
  out.samples_given = instrument.samples_given, out.directions_given = simulation.sky_directions_given;
  out.tolerance = simulation.tolerance;
  out.plan_error = out.plan_estimate = plan.report.total_error;
  out.counts =
      pixel_counts(plan, static_cast<double>(instrument.samples_u) * instrument.samples_v, simulation.sky_directions);
  out.s_per_megapixel = 1e6 * CostModel().seconds(out.counts);
  return out;
}

void hold_tolerance(Decision& decision, const scene::Simulation& simulation, const scene::Instrument& instrument,
                    const plan::Plan& plan, const atmos::RenderTable& table, int threads) {
  if (plan.refusal.empty()) return;
  measure_plan(decision, simulation, instrument, plan, table, threads);
  if (decision.plan_error > simulation.tolerance)
    throw base::Error(base::Fault::input, fmt::format("{}; measured on {} pixels of this scene: {:.3g}; raise the "
                                                      "tolerance, narrow the field of view or split the scene's relief",
                                                      plan.refusal, decision.model_pixels, decision.plan_error));
}

Decision decide(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument,
                const plan::Plan& plan, const atmos::RenderTable& table, bool estimate_given, int threads) {
  Decision out = as_given(simulation, instrument, plan);
  hold_tolerance(out, simulation, instrument, plan, table, threads);
  const bool sky = plan.components() > 0;
  if (out.samples_given && (out.directions_given || !sky) && !estimate_given) return out;
  if (out.model_pixels == 0 && out.plan_estimate > kWorthMeasuring * simulation.tolerance)
    measure_plan(out, simulation, instrument, plan, table, threads);

  PixelTrial trial(renderer, simulation, instrument, plan);
  LevelSearch search(trial, simulation, instrument, plan, out);
  search.try_sky();
  scene::SamplerKind sampler = out.samples_given ? instrument.sampler : scene::SamplerKind::grid;
  ErrorLaw side(kSideLaw);
  Choice choice = search.settle(sampler, side);
  // No edge runs along a lattice, so it may do with fewer samples; few tell nothing either way.
  if (!out.samples_given && choice.side > kFirstSide) {
    ErrorLaw other(kSideLaw);
    const Choice lattice = search.settle(scene::SamplerKind::lattice, other);
    const double ours = search.cost_s(lattice.side, lattice.directions),
                 theirs = search.cost_s(choice.side, choice.directions);
    if (lattice.within != choice.within ? lattice.within : ours < theirs)
      choice = lattice, side = other, sampler = scene::SamplerKind::lattice;
  }

  take_levels(out, plan, choice, sampler);
  take_errors(out, choice, side, search.direction(), sky);
  out.trial_pixels = trial.pixels(), out.looked_at = trial.looked_at(), out.trial_rays = trial.rays();
  note_tolerance(out, instrument.name);
  return out;
}

void add_small_objects(Decision& decision, const scene::Instrument& instrument, sensors::SmallObjectPixels small) {
  using scene::SmallObjects;
  scene::Instrument sampled = instrument;
  sampled.sampler = decision.sampling.sampler;
  sampled.samples_u = decision.sampling.samples_u, sampled.samples_v = decision.sampling.samples_v;
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
  instrument.small_objects = decision.small.on ? scene::SmallObjects::on : scene::SmallObjects::off;
  if (plan.components() > 0) plan.sky.rays = decision.sampling.directions;
}

}  // namespace raycube::planner
