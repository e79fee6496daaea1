#include "host/run/render_lidar.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <functional>
#include <future>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>

#include "host/base/error.h"
#include "host/base/memory.h"
#include "host/base/timing.h"
#include "host/cl/device.h"
#include "host/run/lidar_background.h"
#include "host/run/lidar_job.h"
#include "host/run/lidar_products.h"
#include "host/run/lidar_run_light.h"
#include "host/run/lidar_csv.h"
#include "host/run/other_pulses.h"
#include "host/run/load_job.h"
#include "host/lidar/apply_turbulence.h"
#include "host/lidar/image_blur.h"
#include "host/lidar/detection.h"
#include "host/lidar/echoes.h"
#include "host/plan/plan.h"
#include "host/planner/lidar_own_error.h"
#include "host/reference/double_trace.h"
#include "host/reference/embree_scene.h"
#include "host/base/parallel.h"
#include "host/base/text.h"
#include "host/render/lidar_renderer.h"
#include "scene_compiler/ground.h"

namespace raycube::run {

namespace {

std::size_t bytes_of_rows(const lidar::LidarPlan& plan) {
  const auto& transport = plan.lidar.transport;
  const std::size_t kinds = 1 + (transport.max_bounces > 1) + transport.air_return + !plan.cross_section_cm2.empty();
  const std::size_t samples =
      static_cast<std::size_t>(transport.subrays) *
      (transport.sampling == scene::LidarSampling::receiver ? static_cast<std::size_t>(plan.pixels()) : 1u);
  // Expectations, and as much again for the record made of them; first hits.
  return samples * sizeof(lidar::FirstHit) + 2 * kinds * static_cast<std::size_t>(plan.pixels()) *
                                                 static_cast<std::size_t>(plan.lines()) *
                                                 static_cast<std::size_t>(plan.lidar.gate.bins) * sizeof(float);
}

constexpr std::int64_t kMostPulses = 4096;  ///< of a batch: more gain no time

std::int64_t batch_of(const lidar::LidarPlan& plan, std::size_t memory_bytes) {
  return std::clamp<std::int64_t>(
      static_cast<std::int64_t>(memory_bytes / 4 / std::max<std::size_t>(1, bytes_of_rows(plan))), 1, kMostPulses);
}

/// Rows of one pulse are held at once whatever --memory says: it is refused when it cannot hold them.
void require_memory(const lidar::LidarPlan& plan, std::size_t memory_bytes) {
  if (bytes_of_rows(plan) <= memory_bytes) return;
  throw base::Error(base::Fault::input,
                    fmt::format("LIDAR '{}': --memory is too small for the rows of one pulse: need {} bytes, "
                                "found {}; raise --memory, or give fewer "
                                "pixels, bins or sub-rays",
                                plan.lidar.name, bytes_of_rows(plan), memory_bytes));
}

/// What turbulence does to the survey's first shot, in words for the record; its own draws are left out.
/// Everything is of the first line, but what `lines` has.
nlohmann::json turbulence_json(const scene::Lidar& lidar, const lidar::TurbulenceTruth& t) {
  nlohmann::json lines = nlohmann::json::array();
  for (std::size_t i = 0; i < t.lines.size(); ++i) {
    const auto& line = t.lines[i];
    lines.push_back({{"name", line_name(lidar, static_cast<int>(i))},
                     {"rytov_variance_plane", line.rytov_plane},
                     {"rytov_variance_spherical", line.rytov_spherical},
                     {"scintillation_index_one_way_down", line.index_down},
                     {"scintillation_index_one_way_up", line.index_up},
                     {"scintillation_index_two_way", (1 + line.index_down) * (1 + line.index_up) - 1},
                     {"distribution", line.gamma_gamma ? "gamma-gamma" : "log-normal"}});
  }
  return {{"path_m", t.path_m},
          {"start_height_m", t.start_height_m},
          {"end_height_m", t.end_height_m},
          {"rytov_variance_plane", t.rytov_plane},
          {"rytov_variance_spherical", t.rytov_spherical},
          {"fried_m", t.fried_m},
          {"fried_plane_m", t.fried_plane_m},
          {"isoplanatic_angle_rad", t.isoplanatic_rad},
          {"beam_radius_m", t.beam_radius_m},
          {"short_term_radius_m", t.short_term_m},
          {"long_term_radius_m", t.long_term_m},
          {"wander_sigma_m", t.wander_sigma_m},
          {"tilt_sigma_rad", t.tilt_sigma_rad},
          {"blur_fwhm_rad", t.blur_fwhm_rad},
          {"scintillation_index_one_way_down", t.index_down},
          {"scintillation_index_one_way_up", t.index_up},
          {"scintillation_index_two_way", t.index_total},
          {"distribution", t.gamma_gamma ? "gamma-gamma" : "log-normal"},
          {"distribution_because", fmt::format("rytov_variance_plane {:.4g} is {} {}", t.rytov_plane,
                                               t.gamma_gamma ? "not below" : "below", lidar::kGammaGammaFrom)},
          {"lines", lines},
          {"broadening_s2", t.broadening_s2},
          {"correlation_s", t.correlation_s},
          {"warnings", t.warnings}};
}

std::string main_file(const scene::Lidar& lidar, const std::string& folder) {
  for (const char* name : {"/returns.las", "/returns.laz"})
    if ((lidar.products.las || lidar.products.laz) && std::filesystem::exists(folder + name)) return folder + name;
  return folder + (lidar.products.cube ? "/waveforms.img" : "/run.json");
}

/// What turbulence needs to know of a shot's way: the ground below it, and the range of the surface that its
/// axis meets.
class WaysOfShots {
 public:
  WaysOfShots(const scene::Simulation& simulation, const scene::Lidar& lidar) : scene_(simulation.scene) {
    if (lidar.turbulence.profile == scene::TurbulenceProfile::none) return;
    if (!scene_.instances.empty()) embree_.emplace(scene_);
    flat_z_m_ = lidar.turbulence.ground_z_m.value_or(0.0);
    if (simulation.ground && !lidar.turbulence.ground_z_m)
      ground_ = [ground = simulation.ground](double x_m, double y_m) { return ground->z_m(x_m, y_m); };
  }
  lidar::ShotSurroundings operator()(const lidar::Shot& shot) const {
    lidar::ShotSurroundings around(ground_, surface_range_m(shot));
    around.flat_z_m = flat_z_m_;
    return around;
  }

 private:
  double surface_range_m(const lidar::Shot& shot) const {
    if (!embree_) return 0;
    reference::Ray ray;
    for (std::size_t i = 0; i < 3; ++i) {
      ray.origin[i] = static_cast<float>(shot.exit_m[i]);
      ray.direction[i] = static_cast<float>(shot.exit_axis[i]);
    }
    const auto hit = embree_->intersect(ray);
    if (hit.miss()) return 0;
    const auto at = reference::hit_point(scene_, ray, hit);
    return std::hypot(at.x - shot.exit_m[0], at.y - shot.exit_m[1], at.z - shot.exit_m[2]);
  }

  const scene::CompiledScene& scene_;
  std::optional<reference::EmbreeScene> embree_;
  std::function<double(double, double)> ground_;
  double flat_z_m_ = 0;
};

/// What is known of the error: one line in the log, a member of the record, a warning where the tolerance is
/// not kept.
void add_error(const LidarJob& job, products::RunRecord& record, Services& services) {
  for (const auto& note : job.decision.notes) record.warnings.push_back(note);
  const planner::LidarOwnError& error = job.error;
  const std::string text = job.lidar->name + ": " + planner::own_error_text(error);
  record.more_json.emplace_back("error", planner::own_error_json(error));
  if (error.kept() || !error.known() || job.decision.estimated) {  // what a trial found is among the plan's notes
    services.log.info(text);
    return;
  }
  services.log.warning(text);
  record.warnings.push_back(text);
}

/// A survey under way: shots, turbulence, background light, expectations, detection, products; and its sums.
class Survey {
 public:
  Survey(const scene::Simulation& simulation, LidarJob& job, const render::RenderOptions& options, Services& services)
      : light(job.plan),
        simulation_(simulation),
        lidar_(*job.lidar),
        plan_(job.plan),
        services_(services),
        way_(simulation, lidar_),
        memory_bytes_(options.memory_bytes) {
    broaden(job.plan);
    require_memory(plan_, memory_bytes_);
    // Made of the plan as it is now.
    for (std::size_t t = base::thread_count(services.threads); t > 0; --t) detecting_.emplace_back(plan_);
    for (const char* stage : {"pulses", "detection", "products"}) stage_s[stage] = 0;
  }

  /// The light of the scene behind the echoes, and that of other pulses, where there are any.
  void prepare(const render::RenderOptions& options) {
    if (has_background(simulation_, lidar_)) {
      background_.emplace(simulation_, plan_, options, services_);
      stage_s["background"] = 0;
    }
    others_.emplace(simulation_, plan_);
  }

  /// Every pulse, batch by batch: while one is traced and detected, the one before is written. Where there is
  /// background light, shots come for many batches at once: a passive plan costs a second, whatever the number of
  /// views.
  void fire(render::LidarRenderer& renderer, LidarProducts& output) {
    const Step step(services_, "lidar " + lidar_.name, static_cast<std::uint64_t>(lidar_.pulses), "pulses");
    const std::int64_t batch = batch_of(plan_, memory_bytes_);
    const std::int64_t chunk = background_ ? std::max<std::int64_t>(batch, 65536 / std::max(1, plan_.pixels())) : batch;
    // A batch takes a quarter of the memory, or is one pulse that takes more: then there is one at a time.
    const bool two_batches = bytes_of_rows(plan_) <= memory_bytes_ / 4;
    std::future<void> writing;
    const Written written{writing};
    for (std::int64_t first = 0; first < lidar_.pulses; first += chunk) {
      const auto shots = through_turbulence(
          lidar::make_shots(lidar_, first, std::min(chunk, lidar_.pulses - first), simulation_.seed));
      std::vector<std::vector<double>> behind;
      if (background_ && !shots.empty()) timed("background", [&] { behind = background_->rates(shots); });
      for (std::size_t begin = 0; begin < shots.size(); begin += static_cast<std::size_t>(batch)) {
        const std::size_t end = std::min(shots.size(), begin + static_cast<std::size_t>(batch));
        fire_batch(std::span(shots).subspan(begin, end - begin),
                   behind.empty() ? std::span<std::vector<double>>() : std::span(behind).subspan(begin, end - begin),
                   renderer, output);
        if (writing.valid()) writing.get();
        std::swap(fired_, whole_);
        if (two_batches) {
          writing = base::beside(services_.threads, [&] { write(output); });
        } else {
          write(output);
          whole_ = {};
        }
        step.advance(end - begin);
      }
    }
    if (writing.valid()) writing.get();
  }

  /// All that there are, before threads add to them; products are written beside the others, so that the sum may be
  /// more than what the run took.
  std::map<std::string, double> stage_s;
  std::uint64_t rays = 0, echoes = 0, cut = 0;
  double worst_ledger = 0;
  std::optional<nlohmann::json> turbulence;  ///< what it does to the first shot; empty: there is none
  LidarRunLight light;                       ///< where the run's light went

 private:
  /// The air of the first pulse fired lengthens them all: femtoseconds, but for the worst of paths.
  void broaden(lidar::LidarPlan& plan) const {
    if (lidar_.turbulence.profile == scene::TurbulenceProfile::none) return;
    const auto shots = lidar::make_shots(lidar_, 0, std::min<std::int64_t>(lidar_.pulses, 4096), simulation_.seed);
    if (shots.empty()) return;
    lidar::broaden_pulse(plan, lidar::turbulence_statistics(plan, way_(shots.front()), shots.front()).broadening_s2);
  }

  std::vector<lidar::Shot> through_turbulence(std::vector<lidar::Shot> shots) {
    for (auto& shot : shots) {
      const auto truth = lidar::apply_turbulence(plan_, way_(shot), shot);
      if (!blur_) blur_.emplace(lidar_, truth.fried_m);
      if (turbulence || lidar_.turbulence.profile == scene::TurbulenceProfile::none) continue;
      turbulence = turbulence_json(lidar_, truth);
      for (const auto& warning : truth.warnings) services_.log.warning(lidar_.name + ": " + warning);
    }
    return shots;
  }

  /// Expectations and records of a batch, into fired_. behind: photons / s of the background, [shot][pixel and line];
  /// empty: none.
  void fire_batch(std::span<const lidar::Shot> shots, std::span<std::vector<double>> behind,
                  render::LidarRenderer& renderer, const LidarProducts& output) {
    fired_.results.resize(shots.size());
    timed("pulses", [&] {
      auto next = fired_.results.begin();
      renderer.render(
          plan_, {shots.begin(), shots.end()}, [&](lidar::ShotResult&& result) { std::swap(*next++, result); },
          output.wants_truth());
      others_->add_to(
          fired_.results, renderer, [&](lidar::Shot& shot) { lidar::apply_turbulence(plan_, way_(shot), shot); },
          output.wants_truth());
    });
    const std::size_t count = fired_.results.size();
    fired_.records.resize(count), fired_.truth.resize(count);
    timed("detection", [&] {
      base::for_each_index_with(detecting_, count, [&](lidar::Detecting& detecting, std::size_t i) {
        auto& result = fired_.results[i];
        if (blur_) blur_->apply(plan_, result);
        if (!behind.empty()) result.background_hz = behind[i];
        detecting.detect(result, fired_.records[i]);
        output.truth(result, fired_.records[i], fired_.truth[i]);
      });
    });
  }

  /// Products of whole_.
  void write(LidarProducts& output) {
    timed("products", [&] {
      for (std::size_t i = 0; i < whole_.results.size(); ++i) {
        output.add(whole_.results[i], whole_.records[i], whole_.truth[i]);
        add(whole_.results[i], whole_.records[i]);
      }
    });
  }

  void add(const lidar::ShotResult& result, const std::vector<lidar::Detection>& records) {
    light.add(result, records);
    rays += static_cast<std::uint64_t>(result.rays);
    for (const auto& record : records) {
      echoes += record.echoes.size();
      for (const auto& echo : record.echoes) cut += echo.cut;
    }
    for (const auto& ledger : result.ledger) worst_ledger = std::max(worst_ledger, std::abs(ledger.emitted_error()));
  }

  template <class Work>
  void timed(const char* stage, const Work& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    stage_s.at(stage) += base::seconds_since(begin);
  }

  /// A batch: of each shot expectations, records, and what stands behind their returns.
  struct Batch {
    std::vector<lidar::ShotResult> results;
    std::vector<std::vector<lidar::Detection>> records;
    std::vector<std::vector<std::vector<lidar::ReturnTruth>>> truth;
  };
  /// Waits, after a failure elsewhere, for what is being written: what it reads would go. What would be written only
  /// when it is asked for (one thread) is left.
  struct Written {
    std::future<void>& writing;
    ~Written() {
      if (writing.valid() && writing.wait_for(std::chrono::seconds(0)) != std::future_status::deferred) writing.wait();
    }
  };

  const scene::Simulation& simulation_;
  const scene::Lidar& lidar_;
  const lidar::LidarPlan& plan_;
  Services& services_;
  Batch fired_, whole_;
  std::vector<lidar::Detecting> detecting_;  ///< of each thread
  WaysOfShots way_;
  std::size_t memory_bytes_;
  std::optional<LidarBackground> background_;
  std::optional<OtherPulses> others_;
  std::optional<lidar::PixelBlur> blur_;  ///< of an array's image, as the first pulse's air makes it
};

/// How it came about: device, sizes, times, plan, air, sums of the survey.
products::RunRecord record_of(const scene::Simulation& simulation, const LidarJob& job,
                              const render::LidarRenderer& renderer, const render::RenderOptions& options,
                              const Destination& destination, const Survey& survey, double render_s, int threads) {
  const scene::Lidar& lidar = *job.lidar;
  const auto device = cl::find_device(options.device).info();
  products::RunRecord record;
  record.command = destination.command;
  record.instrument = lidar.name;
  record.scene_hash = simulation.scene.content_hash;
  record.seed = simulation.seed;
  record.platform = device.platform, record.device = device.name, record.driver = device.driver;
  record.opencl_version = device.version;
  record.compute_units = static_cast<int>(device.compute_units);
  record.threads = threads > 0 ? threads : static_cast<int>(device.compute_units);
  record.program_hash = renderer.program_hash();
  record.samples = lidar.gate.bins;
  record.lines = lidar.pulses * job.plan.pixels();
  record.bands = job.plan.lines();
  record.samples_per_pixel = job.plan.lidar.transport.subrays;
  record.stage_s = {{"load", destination.load_s}, {"atmosphere", job.table_s}, {"plan", job.plan_s}};
  for (const auto& stage : survey.stage_s) record.stage_s.push_back(stage);
  record.total_s = destination.load_s + job.table_s + job.plan_s + render_s;
  record.rays_per_s = static_cast<double>(survey.rays) / render_s;
  record.memory_budget_bytes = options.memory_bytes;
  record.peak_memory_bytes = base::peak_resident_bytes();
  record.device_memory_bytes = device.global_memory_bytes;
  record.configuration_json = simulation.resolved_json;
  record.plan_json = plan_json(job).dump();
  lidar::EchoFinder finder(job.plan.lidar, job.plan.waveform_error);
  const bool waveforms = lidar.detector.mode != scene::DetectorMode::geiger;
  nlohmann::json more = {{"pulses", lidar.pulses},
                         {"echoes", survey.echoes},
                         {"pulses_per_s", static_cast<double>(lidar.pulses) / render_s},
                         {"returns_cut_by_gate", survey.cut},
                         {"worst_ledger_error", survey.worst_ledger},
                         {"returns_of_matter_expected", survey.light.returns_of_matter()}};
  if (waveforms)
    more["echo_finder"] = {{"waveform_error", job.plan.waveform_error},
                           {"pulse_late_ns", 1e9 * finder.pulse_late_s()},
                           {"pulse_shape_error", finder.pulse_shape_error()}};
  if (survey.turbulence) more["turbulence"] = *survey.turbulence;
  record.warnings = light_notices(simulation, lidar);
  record.warnings.insert(record.warnings.end(), job.air_notices.begin(), job.air_notices.end());
  record.more_json = {{"survey", more.dump()}, {"launches", render::tuning_json(renderer.tuning())}};
  if (!job.air_json.empty()) record.more_json.emplace_back("atmosphere", job.air_json);
  return record;
}

}  // namespace

LidarRun render_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar,
                      const render::RenderOptions& options, const Destination& destination, Services& services,
                      const Planning& planning) {
  render::LidarRenderer renderer(simulation.scene, options);
  LidarJob job = prepare_lidar(simulation, lidar, services,
                               {&renderer, planning.replay, planning.replay_path, planning.estimate_given, true});
  Survey survey(simulation, job, options, services);
  const auto start = std::chrono::steady_clock::now();
  LidarProducts output(destination.folder, destination.if_exists, simulation, job.plan);
  survey.prepare(options);
  survey.fire(renderer, output);
  const double render_s = base::seconds_since(start);

  products::RunRecord record =
      record_of(simulation, job, renderer, options, destination, survey, render_s, services.threads);
  if (const std::string warning = survey.light.warning(); !warning.empty()) {
    record.warnings.push_back(warning);
    services.log.warning(warning);
  }
  if (100 * survey.cut > survey.echoes) {
    record.warnings.push_back(fmt::format(
        "{}: {} of {} within half a pulse of the gate's ends, where their ranges are but bounds "
        "(cut_by_gate in returns.csv, withheld in LAS); see start_range_m and stop_range_m",
        lidar.name, survey.cut, survey.echoes == 1 ? "1 return lies" : fmt::format("{} returns lie", survey.echoes)));
    services.log.warning(record.warnings.back());
  }
  add_error(job, record, services);
  const std::size_t told = record.warnings.size();
  output.publish(record);
  for (std::size_t i = told; i < record.warnings.size(); ++i)
    services.log.warning(lidar.name + ": " + record.warnings[i]);
  const double pulses_per_s = static_cast<double>(lidar.pulses) / render_s;
  services.log.info(
      fmt::format("{}: {}, {}, {:.3g} expected of surfaces and volumes, {:.1f} s, {:.3g} pulses/s, "
                  "energy ledger within {:.1e}, {}",
                  lidar.name, base::counted(static_cast<std::size_t>(lidar.pulses), "pulse"),
                  base::counted(survey.echoes, "return"), survey.light.returns_of_matter(), render_s, pulses_per_s,
                  survey.worst_ledger, destination.folder));
  return {lidar.name,         destination.folder, record.digest, main_file(lidar, destination.folder),
          lidar.pulses,       survey.echoes,      render_s,      pulses_per_s,
          survey.worst_ledger};
}

LidarForecast forecast_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar,
                             const render::RenderOptions& options, Services& services, const Planning& planning) {
  std::optional<render::LidarRenderer> renderer;
  try {
    renderer.emplace(simulation.scene, options);
  } catch (const base::Error& error) {
    if (error.fault() != base::Fault::device) throw;
    services.log.warning(std::string("the error of the sub-rays cannot be estimated: ") + error.what());
  }
  LidarForecast forecast;
  forecast.job =
      prepare_lidar(simulation, lidar, services,
                    {renderer ? &*renderer : nullptr, planning.replay, planning.replay_path, planning.estimate_given});
  const auto& plan = forecast.job.plan;
  require_memory(plan, options.memory_bytes);
  const auto rows = static_cast<std::uint64_t>(lidar.pulses) * static_cast<std::uint64_t>(plan.pixels()) *
                    static_cast<std::uint64_t>(plan.lines());
  forecast.rays = static_cast<std::uint64_t>(lidar.pulses) * forecast.job.decision.rays_per_pulse;
  forecast.pulses_per_batch = batch_of(plan, options.memory_bytes);
  forecast.waveform_bytes = rows * static_cast<std::uint64_t>(lidar.gate.bins) * sizeof(float);
  return forecast;
}

}  // namespace raycube::run
