// An instrument: samples and sky directions.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "bench/planner_study.h"
#include "host/base/cache_folder.h"
#include "host/base/error.h"
#include "host/base/timing.h"
#include "host/run/camera_job.h"
#include "host/planner/model_trial.h"
#include "host/planner/planner.h"
#include "host/planner/pixel_trial.h"
#include "host/planner/trial_pixels.h"
#include "host/study/kept.h"
#include "host/study/device_timing.h"
#include "kernels/sampling/sampler.h"

namespace raycube::bench {

namespace {

using planner::CostModel;
using planner::pixel_counts;

constexpr std::uint64_t kOtherPixels =
    0x9E3779B9u;            ///< added to the seed: pixels and draws that the planner's trial does not have
constexpr int kRuns = 256;  ///< of 8 pixels
constexpr std::size_t kWholeImage = 8192;   ///< pixels of an image that is judged whole
constexpr int kReferenceSide = 128;         ///< of the reference's samples
constexpr int kReferenceDirections = 1024;  ///< of its skies
constexpr int kModelSide = 3;               ///< of what the whole tables add to the reference's nodes
constexpr int kMostRounds = 32;
constexpr double kSweep_s_per_megapixel = 60;    ///< twice what is dear: costlier settings are left out of the sweep
constexpr double kTried_s_per_megapixel = 2000;  ///< a costlier decision is not rendered
constexpr double kTimed_s = 0.15;                ///< nominal, of one timed run
const std::vector<int> kSides = {1, 2, 3, 4, 6, 8, 11, 16};
const std::vector<int> kDirections = {4, 8, 16, 24, 32, 48, 64, 96, 128, 192, 256, 512};

std::vector<render::Tile> judged_tiles(const scene::Instrument& instrument, std::uint64_t seed) {
  const std::size_t all = static_cast<std::size_t>(instrument.pixels) * static_cast<std::size_t>(instrument.lines);
  if (all <= kWholeImage) return {{0, instrument.lines, 0, instrument.pixels}};
  return planner::trial_tiles(instrument, seed + kOtherPixels, kRuns);
}

double s_per_megapixel(const plan::Plan& plan, const PlannerSetting& setting) {
  return 1e6 * setting.replicates * CostModel().seconds(pixel_counts(plan, setting.samples, setting.directions));
}

/// The instrument with a setting's samples: a grid of a square number of them, or a lattice.
scene::Instrument sampled(const scene::Instrument& instrument, const PlannerSetting& setting) {
  scene::Instrument out = instrument;
  out.sampler = setting.sampler, out.samples_u = setting.samples, out.samples_v = 1;
  out.replicates = setting.replicates;
  if (setting.sampler != scene::SamplerKind::lattice)
    out.samples_u = out.samples_v = static_cast<int>(std::lround(std::sqrt(setting.samples)));
  return out;
}

class CubeStudy {
 public:
  CubeStudy(scene::Simulation& simulation, std::size_t index, const PlannerStudySettings& settings,
            run::Services& services)
      : simulation_(simulation),
        instrument_(simulation.instruments[index]),
        settings_(settings),
        services_(services),
        renderer_(simulation.scene, study_options()),
        tiles_(judged_tiles(instrument_, simulation.seed)) {
    simulation_.plan = {};
    make_finest();
  }

  PlannerStudy run(const std::string& name) {
    const auto start = std::chrono::steady_clock::now();
    PlannerStudy out;
    out.scene = name, out.instrument = instrument_.name, out.kind = "cube", out.device = renderer_.device_name();
    out.pixels = render::pixels_of(tiles_);
    make_reference();
    correct_nodes();
    out.reference = reference_text_;
    out.own = study::own_error(reference_);
    services_.log.info(fmt::format("{} {}: reference's own error {:.2g} %, {:.1f} s", name, instrument_.name,
                                   100 * out.own, base::seconds_since(start)));
    sweep();
    out.points = points_;
    std::string sides, directions;
    for (const int n : kSides) sides += (sides.empty() ? "" : ", ") + std::to_string(n);
    for (const int k : kDirections) directions += (directions.empty() ? "" : ", ") + std::to_string(k);
    out.sweep =
        fmt::format("grid and lattice of n x n samples, n = {}; {} sky directions; up to {:.0f} s per megapixel", sides,
                    sky_ ? directions : "no", kSweep_s_per_megapixel);
    services_.log.info(fmt::format("{} {}: sweep of {} settings, {:.1f} s", name, instrument_.name, points_.size(),
                                   base::seconds_since(start)));
    for (const double tolerance : settings_.tolerances) {
      out.rows.push_back(row(tolerance));
      const PlannerRow& r = out.rows.back();
      services_.log.info(fmt::format(
          "{} {}: {:.3g} %: {} claims {:.3g} % (nodes {:.3g}, samples {:.3g}, sky {:.3g}) achieves {:.3g} % ({:.3g} .. "
          "{:.3g}, own {:.2g}){}{}; {:.3g} s/Mpx, best {} {:.3g} %, cost {:.2f} x, time {:.2f} x; planned in {:.1f} s, "
          "plan and render {:.2f} s, "
          "best render {:.2f} s",
          name, instrument_.name, 100 * tolerance, r.chosen.text(), 100 * r.claimed, 100 * r.plan_error,
          100 * r.samples_error, 100 * r.sky_error, 100 * r.achieved, 100 * r.low, 100 * r.high, 100 * r.own,
          r.judged ? "" : " not judged",
          r.dear     ? " DEAR"
          : r.within ? ""
                     : " NOT KEPT",
          r.s_per_megapixel, r.best_known ? r.best.setting.text() : "-", 100 * r.best.error, r.cost_over_best,
          r.time_over_best.median, r.plan_s, r.together_s, r.best_s));
    }
    out.seconds = base::seconds_since(start);
    return out;
  }

 private:
  void open() { instrument_.samples_given = false, simulation_.sky_directions_given = false; }

  /// The plan with the smallest tolerance that its nodes can keep.
  void make_finest() {
    instrument_.samples_given = simulation_.sky_directions_given = true;  // no trial
    const double keep = simulation_.tolerance;
    for (const double tolerance : {1e-4, 2e-4, 5e-4, 1e-3, 3e-3, 1e-2}) {
      simulation_.tolerance = tolerance;
      try {
        auto job = run::prepare_camera(simulation_, instrument_, services_);
        finest_ = std::move(job.plan), table_ = std::move(job.table);
        break;
      } catch (const base::Error& refused) {
        if (refused.fault() != base::Fault::input || tolerance == 1e-2) throw;
      }
    }
    simulation_.tolerance = keep;
    sky_ = finest_.components() > 0;
    open();
  }

  std::vector<float> render(const PlannerSetting& setting, const plan::Plan& plan, std::uint64_t seed) {
    return study::device_radiance(renderer_, sampled(instrument_, setting), plan, simulation_.sun, seed, tiles_);
  }

  /// The plan with a setting's directions.
  plan::Plan with_directions(const plan::Plan& from, const PlannerSetting& setting) {
    plan::Plan plan = from;
    if (sky_) plan.sky.rays = setting.directions;
    return plan;
  }

  /// Two independent halves, each without bias: many samples and many directions.
  void make_reference() {
    const double pixels = static_cast<double>(render::pixels_of(tiles_));
    const PlannerSetting fine{scene::SamplerKind::jittered, kReferenceSide, sky_ ? kReferenceDirections : 0};
    const int rounds = std::clamp(
        static_cast<int>(settings_.reference_s / 2 / (s_per_megapixel(finest_, fine) * 1e-6 * pixels)), 1, kMostRounds);
    reference_text_ = fmt::format("2 x {} renders of {} x {} jittered samples", rounds, kReferenceSide, kReferenceSide);
    if (sky_) reference_text_ += fmt::format(" and {} sky directions", kReferenceDirections);
    const std::string key =
        study::key_of(simulation_, instrument_, finest_, table_, tiles_, {kReferenceSide, rounds, 0, 0});
    reference_ = study::kept_or(base::cache_folder("reference").string(), key.empty() ? key : key + "-device", [&] {
      const plan::Plan many = with_directions(finest_, fine);
      std::vector<double> half[2];
      for (rc_u32 draw = 0; draw < 2 * static_cast<rc_u32>(rounds); ++draw) {
        const auto drawn = render(fine, many, rc_hash(static_cast<rc_u32>(simulation_.seed), draw, 0, 53));
        std::vector<double>& to = half[draw % 2];
        to.resize(drawn.size());
        for (std::size_t k = 0; k < drawn.size(); ++k) to[k] += static_cast<double>(drawn[k]) / rounds;
      }
      study::Converged out;
      out.bands = finest_.bands.size();
      for (std::size_t k = 0; k < half[0].size(); ++k) {
        out.radiance.push_back((half[0][k] + half[1][k]) / 2);
        out.half.push_back((half[0][k] - half[1][k]) / 2);
      }
      return out;
    });
  }

  /// Adds what the whole tables say of each pixel beyond the finest plan: by few samples, since it hardly varies inside
  /// a pixel, and in each half by its own samples and directions.
  void correct_nodes() {
    std::vector<double> half[2];
    for (const int to : {0, 1}) {
      planner::ModelSettings settings;
      settings.side = kModelSide;
      settings.turn_rad = to * reference::SkyShare::kHalfStep_rad;
      settings.seed = rc_hash(static_cast<rc_u32>(simulation_.seed), static_cast<rc_u32>(to), 0, 54);
      const auto [planned, whole] =
          planner::compare_models(simulation_, instrument_, finest_, table_, tiles_, settings);
      for (std::size_t p = 0; p < planned.size(); ++p)
        for (std::size_t b = 0; b < finest_.bands.size(); ++b)
          half[to].push_back((whole[p].total(b) - whole[p].surroundings[b]) -
                             (planned[p].total(b) - planned[p].surroundings[b]));
    }
    for (std::size_t k = 0; k < reference_.radiance.size(); ++k) {
      reference_.radiance[k] += (half[0][k] + half[1][k]) / 2;
      reference_.half[k] += (half[0][k] - half[1][k]) / 2;
    }
    reference_text_ += fmt::format(", whole tables against its nodes at 2 x {} x {} samples under {} directions",
                                   kModelSide, kModelSide, planner::ModelSettings().directions);
  }

  void sweep() {
    for (const auto sampler : {scene::SamplerKind::grid, scene::SamplerKind::lattice})
      for (const int side : kSides) {
        if (sampler == scene::SamplerKind::lattice && side == 1) continue;
        for (const int directions : sky_ ? kDirections : std::vector<int>{0}) {
          const PlannerSetting setting{sampler, side * side, directions};
          const double cost = s_per_megapixel(finest_, setting);
          if (cost > kSweep_s_per_megapixel) continue;
          const auto error =
              study::error_of(reference_, render(setting, with_directions(finest_, setting), simulation_.seed));
          points_.push_back({setting, error.worst, error.low, error.high, cost});
        }
      }
  }

  PlannerRow row(double tolerance) {
    PlannerRow out;
    out.tolerance = simulation_.tolerance = tolerance;
    run::Planning planning;
    planning.renderer = &renderer_;
    auto start = std::chrono::steady_clock::now();
    run::CameraJob job;
    try {
      run::prepare_camera(simulation_, instrument_, services_, planning);  // compiles what the timed one takes
      start = std::chrono::steady_clock::now();
      job = run::prepare_camera(simulation_, instrument_, services_, planning);
    } catch (const base::Error& refused) {  // nodes that no 32 channels hold: the plan says so and renders nothing
      if (refused.fault() != base::Fault::input) throw;
      out.within = false;
      return out;
    }
    out.plan_s = base::seconds_since(start);
    const planner::Decision& d = job.decision;
    out.chosen = {d.sampling.sampler, d.sampling.samples_u * d.sampling.samples_v, sky_ ? d.sampling.directions : 0,
                  d.sampling.replicates};
    out.claimed = d.total_error, out.within = d.within, out.dear = d.dear;
    out.plan_error = d.plan_error, out.samples_error = d.samples_error, out.sky_error = d.sky_error;
    out.s_per_megapixel = d.s_per_megapixel;
    for (const auto& line : d.measured) services_.log.info("  trial: " + line);
    if (out.s_per_megapixel <= kTried_s_per_megapixel) {
      const auto error = study::error_of(reference_, render(out.chosen, job.plan, simulation_.seed));
      out.tried = true;
      out.achieved = error.worst, out.low = error.low, out.high = error.high, out.own = error.own;
      out.judged = out.own <= kFifth * tolerance;
    }
    find_best(out, job.plan);
    if (out.best_known && out.within && !out.dear) {
      out.time_over_best = time_ratio(out.chosen, out.best.setting, job.plan);
      out.best_s = image_s(out.best.setting, job.plan);
      out.together_s = job.plan_s + (d.image ? d.image->render_s : image_s(out.chosen, job.plan));
    }
    return out;
  }

  /// The cheapest setting of the sweep that is inside the tolerance with the tolerance's own nodes too, the planner's
  /// own choice among them.
  void find_best(PlannerRow& out, const plan::Plan& plan) {
    std::vector<SweepPoint> points = points_;
    if (out.tried && !out.dear) points.push_back({out.chosen, out.achieved, out.low, out.high, 0});
    for (SweepPoint& point : points) point.s_per_megapixel = s_per_megapixel(plan, point.setting);
    std::stable_sort(points.begin(), points.end(),
                     [](const auto& a, const auto& b) { return a.s_per_megapixel < b.s_per_megapixel; });
    for (SweepPoint& point : points) {
      if (point.error > out.tolerance) continue;
      const auto error =
          study::error_of(reference_, render(point.setting, with_directions(plan, point.setting), simulation_.seed));
      if (error.worst > out.tolerance) continue;
      point.error = error.worst, point.low = error.low, point.high = error.high;
      out.best_known = true, out.best = point;
      out.cost_over_best = out.s_per_megapixel / point.s_per_megapixel;
      return;
    }
  }

  /// Seconds of the stages of a strip, rows' baking apart: it is paid once for an image.
  double seconds(const PlannerSetting& setting, const plan::Plan& plan, const std::vector<render::Tile>& tiles) {
    double sum = 0;
    for (const auto& [stage, s] :
         renderer_.probe(sampled(instrument_, setting), plan, simulation_.sun, simulation_.seed, tiles, {}).stage_s)
      if (stage != "bake") sum += s;
    return sum;
  }

  /// Seconds of a whole image, from a part of a large one.
  double image_s(const PlannerSetting& setting, const plan::Plan& from) {
    const plan::Plan plan = with_directions(from, setting);
    const double image = static_cast<double>(instrument_.pixels) * instrument_.lines,
                 pixels = kTimed_s / (1e-6 * s_per_megapixel(plan, setting));
    const auto tiles = render::timing_tiles(
        instrument_, static_cast<std::uint64_t>(std::clamp(pixels, 2048.0, std::min(image, 65536.0))));
    std::vector<double> took;
    for (int i = 0; i < settings_.timings; ++i) took.push_back(seconds(setting, plan, tiles));
    return spread_of(took).median * image / static_cast<double>(render::pixels_of(tiles));
  }

  Spread time_ratio(const PlannerSetting& chosen, const PlannerSetting& best, const plan::Plan& from) {
    if (chosen == best) return {1, 1, 1, settings_.timings};
    const plan::Plan ours = with_directions(from, chosen), theirs = with_directions(from, best);
    const double pixels = kTimed_s / (1e-6 * std::max(s_per_megapixel(ours, chosen), s_per_megapixel(theirs, best)));
    const double image = static_cast<double>(instrument_.pixels) * instrument_.lines;
    const auto tiles = render::timing_tiles(
        instrument_, static_cast<std::uint64_t>(std::clamp(pixels, 2048.0, std::min(image, 65536.0))));
    std::vector<double> ratios;
    for (int i = -1; i < settings_.timings; ++i) {
      const double a = seconds(chosen, ours, tiles), b = seconds(best, theirs, tiles);
      if (i >= 0) ratios.push_back(a / b);
    }
    return spread_of(ratios);
  }

  scene::Simulation& simulation_;
  scene::Instrument& instrument_;
  const PlannerStudySettings& settings_;
  run::Services& services_;
  render::Renderer renderer_;
  std::vector<render::Tile> tiles_;
  plan::Plan finest_;
  atmos::RenderTable table_;
  bool sky_ = true;
  study::Converged reference_;
  std::string reference_text_;
  std::vector<SweepPoint> points_;
};

}  // namespace

std::string PlannerSetting::text() const {
  if (directions < 0) return fmt::format("{} sub-rays", samples);
  const char* kind = sampler == scene::SamplerKind::grid      ? "grid"
                     : sampler == scene::SamplerKind::lattice ? "lattice"
                                                              : "jittered";
  const std::string each = fmt::format("{} {}, {} directions", kind, samples, directions);
  return replicates > 1 ? fmt::format("{} x ({})", replicates, each) : each;
}

const SweepPoint* cheapest(const std::vector<SweepPoint>& points, double tolerance) {
  const SweepPoint* best = nullptr;
  for (const SweepPoint& point : points)
    if (point.error <= tolerance && (!best || point.s_per_megapixel < best->s_per_megapixel)) best = &point;
  return best;
}

PlannerStudy study_instrument(scene::Simulation& simulation, std::size_t index, const std::string& name,
                              const PlannerStudySettings& settings, run::Services& services) {
  return CubeStudy(simulation, index, settings, services).run(name);
}

}  // namespace raycube::bench
