// A LIDAR: sub-rays. Error of all waveforms together, as host/planner/lidar_trial.h has it; air left out, which no
// sub-ray changes.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <set>

#include <fmt/format.h>

#include "bench/planner_study.h"
#include "host/base/timing.h"
#include "host/run/lidar_job.h"
#include "host/run/camera_job.h"
#include "host/planner/lidar_trial.h"
#include "host/render/lidar_renderer.h"
#include "kernels/sampling/sampler.h"

namespace raycube::bench {

namespace {

constexpr std::uint64_t kPulses = 2000,
                        kWholeSurvey =
                            16384;  ///< rows of a pulse and pixel that are judged; a survey of so many is judged whole
constexpr double kReferenceRays = 3e8;  ///< both halves
constexpr int kMostReference = 65536, kLargestSwept = 2048;
constexpr rc_u32 kPulseDimension = 53;  ///< of the hash: not the trial's

class LidarStudy {
 public:
  LidarStudy(scene::Simulation& simulation, std::size_t index, const PlannerStudySettings& settings,
             run::Services& services)
      : simulation_(simulation),
        lidar_(simulation.lidars[index]),
        settings_(settings),
        services_(services),
        renderer_(simulation.scene, study_options()) {
    lidar_.transport.subrays_given = false;
    plan_ = run::prepare_lidar(simulation_, lidar_, services_).plan;
    pick_pulses();
  }

  PlannerStudy run(const std::string& name) {
    const auto start = std::chrono::steady_clock::now();
    PlannerStudy out;
    out.scene = name, out.instrument = lidar_.name, out.kind = "pulses", out.device = renderer_.device_name();
    make_reference();
    out.pixels = rows_;
    out.reference = fmt::format("2 x {} sub-rays of {} pulses", reference_subrays_, pulses_.size());
    out.own = own_;
    for (const int subrays : planner::subray_levels())
      if (subrays <= std::min(kLargestSwept, reference_subrays_ / 4)) {
        const double error = error_of(fire(subrays, plan_.seed));
        out.points.push_back(
            {{scene::SamplerKind::grid, subrays, -1}, error, low_of(error), error, static_cast<double>(subrays)});
      }
    out.sweep = fmt::format("{} .. {} sub-rays, every level the planner knows", planner::subray_levels().front(),
                            out.points.back().setting.samples);
    for (const double tolerance : settings_.tolerances) {
      out.rows.push_back(row(tolerance, out.points));
      const PlannerRow& r = out.rows.back();
      services_.log.info(
          fmt::format("{} {}: {:.3g} %: {} claims {:.3g} % achieves {:.3g} % (own {:.2g}){}; best {} {:.3g} %, cost "
                      "{:.2f} x, time {:.2f} x; planned in {:.1f} s",
                      name, lidar_.name, 100 * tolerance, r.chosen.text(), 100 * r.claimed, 100 * r.achieved,
                      100 * r.own, r.within ? "" : " NOT KEPT", r.best_known ? r.best.setting.text() : "-",
                      100 * r.best.error, r.cost_over_best, r.time_over_best.median, r.plan_s));
    }
    out.seconds = base::seconds_since(start);
    return out;
  }

 private:
  void pick_pulses() {
    const auto all = static_cast<std::uint64_t>(std::max<std::int64_t>(lidar_.pulses, 1));
    const auto rows = static_cast<std::uint64_t>(plan_.pixels()) * static_cast<std::uint64_t>(plan_.lines());
    const std::uint64_t wanted = all * rows <= kWholeSurvey ? all : std::min(all, (kPulses + rows - 1) / rows);
    std::set<std::uint64_t> picked;
    for (rc_u32 i = 0; picked.size() < wanted; ++i)
      picked.insert(all <= wanted ? i
                                  : rc_hash(static_cast<rc_u32>(plan_.seed), i, static_cast<rc_u32>(plan_.seed >> 32),
                                            kPulseDimension) %
                                        all);
    for (const std::uint64_t pulse : picked) pulses_.push_back(static_cast<std::int64_t>(pulse));
  }

  std::vector<lidar::Shot> shots(const lidar::LidarPlan& plan, std::uint64_t seed) const {
    std::vector<lidar::Shot> out;
    for (const std::int64_t pulse : pulses_)
      for (auto& shot : lidar::make_shots(plan.lidar, pulse, 1, seed)) out.push_back(std::move(shot));
    return out;
  }

  lidar::LidarPlan plan_with(int subrays, std::uint64_t seed) const {
    lidar::LidarPlan plan = plan_;
    planner::set_subrays(plan, subrays);
    plan.seed = seed;
    plan.lidar.transport.air_return = false;
    return plan;
  }

  std::vector<float> fire(int subrays, std::uint64_t seed) {
    const lidar::LidarPlan plan = plan_with(subrays, seed);
    std::vector<float> out;
    renderer_.render(plan, shots(plan, seed), [&](lidar::ShotResult&& shot) {
      for (std::size_t i = 0; i < shot.first.size(); ++i)
        out.push_back(shot.first[i] + (shot.multiple.empty() ? 0.0f : shot.multiple[i]));
    });
    return out;
  }

  void make_reference() {
    const auto fans = static_cast<double>(planner::rays_of_pulse(plan_, 1)) * static_cast<double>(pulses_.size());
    reference_subrays_ = std::clamp(static_cast<int>(kReferenceRays / 2 / fans), 256, kMostReference);
    // A receiver's samples do not move with the seed: another number of them tells what the reference is off.
    const bool fixed = plan_.lidar.transport.sampling == scene::LidarSampling::receiver;
    const auto one = fire(reference_subrays_, plan_.seed + 2 * kPulseDimension),
               two = fire(fixed ? reference_subrays_ * 3 / 4 : reference_subrays_, plan_.seed + 3 * kPulseDimension);
    double squares = 0;
    for (std::size_t i = 0; i < one.size(); ++i) {
      mean_.push_back(0.5 * (static_cast<double>(one[i]) + two[i]));
      const double half = 0.5 * (static_cast<double>(one[i]) - two[i]);
      squares += half * half, whole_ += mean_.back() * mean_.back();
    }
    own_ = std::sqrt(squares / whole_);
    rows_ = one.size() / static_cast<std::size_t>(plan_.lidar.gate.bins);
  }

  double error_of(const std::vector<float>& found) const {
    double squares = 0;
    for (std::size_t i = 0; i < found.size(); ++i) squares += (found[i] - mean_[i]) * (found[i] - mean_[i]);
    return std::sqrt(squares / whole_);
  }
  double low_of(double error) const { return std::sqrt(std::max(0.0, error * error - own_ * own_)); }

  PlannerRow row(double tolerance, const std::vector<SweepPoint>& points) {
    PlannerRow out;
    out.tolerance = simulation_.tolerance = tolerance;
    const auto start = std::chrono::steady_clock::now();
    const auto job = run::prepare_lidar(simulation_, lidar_, services_, {&renderer_, nullptr, "", false});
    out.plan_s = base::seconds_since(start);
    const int subrays = job.decision.subrays;
    out.chosen = {scene::SamplerKind::grid, subrays, -1};
    out.claimed = job.decision.error, out.within = job.decision.within;
    out.s_per_megapixel = subrays;
    out.own = own_;
    if (subrays <= reference_subrays_) {
      out.tried = true;
      out.achieved = out.high = error_of(fire(subrays, plan_.seed));
      out.low = low_of(out.achieved);
      out.judged = own_ <= kFifth * tolerance;
    }
    if (const SweepPoint* best = cheapest(points, tolerance)) {
      out.best_known = true;
      out.best = *best;
      out.cost_over_best = out.s_per_megapixel / best->s_per_megapixel;
      out.time_over_best = time_ratio(subrays, best->setting.samples);
    }
    return out;
  }

  double seconds(int subrays) {
    const lidar::LidarPlan plan = plan_with(subrays, plan_.seed);
    renderer_.render(plan, shots(plan, plan.seed), [](lidar::ShotResult&&) {});
    return renderer_.launch_s();
  }

  Spread time_ratio(int chosen, int best) {
    if (chosen == best) return {1, 1, 1, settings_.timings};
    std::vector<double> ratios;
    for (int i = -1; i < settings_.timings; ++i) {
      const double a = seconds(chosen), b = seconds(best);
      if (i >= 0) ratios.push_back(a / b);
    }
    return spread_of(ratios);
  }

  scene::Simulation& simulation_;
  scene::Lidar& lidar_;
  const PlannerStudySettings& settings_;
  run::Services& services_;
  render::LidarRenderer renderer_;
  lidar::LidarPlan plan_;
  std::vector<std::int64_t> pulses_;
  int reference_subrays_ = 0;
  std::vector<double> mean_;
  double whole_ = 0, own_ = 0;
  std::size_t rows_ = 0;
};

}  // namespace

PlannerStudy study_lidar(scene::Simulation& simulation, std::size_t index, const std::string& name,
                         const PlannerStudySettings& settings, run::Services& services) {
  return LidarStudy(simulation, index, settings, services).run(name);
}

}  // namespace raycube::bench
