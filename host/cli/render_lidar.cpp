#include "host/cli/render_lidar.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/base/error.h"
#include "host/base/memory.h"
#include "host/base/progress.h"
#include "host/cl/device.h"
#include "host/cli/lidar_job.h"
#include "host/cli/lidar_products.h"
#include "host/cli/lidar_run_light.h"
#include "host/cli/lidar_tables.h"
#include "host/cli/other_pulses.h"
#include "host/cli/simulation_job.h"
#include "host/lidar/apply_turbulence.h"
#include "host/lidar/image_blur.h"
#include "host/lidar/detection.h"
#include "host/plan/plan.h"
#include "host/planner/lidar_own_error.h"
#include "host/reference/double_trace.h"
#include "host/reference/embree_scene.h"
#include "host/reference/parallel.h"
#include "host/render/lidar_renderer.h"
#include "scene_compiler/ground.h"

namespace raycube::cli {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::size_t bytes_of_rows(const lidar::LidarPlan& plan) {
  const auto& transport = plan.lidar.transport;
  const std::size_t kinds = 1 + (transport.max_bounces > 1) + transport.air_return;
  const std::size_t samples =
      static_cast<std::size_t>(transport.subrays) *
      (transport.sampling == scene::LidarSampling::receiver ? static_cast<std::size_t>(plan.pixels()) : 1u);
  // Expectations, and as much again for the record made of them; first hits.
  return samples * sizeof(lidar::FirstHit) + 2 * kinds * static_cast<std::size_t>(plan.pixels()) *
                                                 static_cast<std::size_t>(plan.lines()) *
                                                 static_cast<std::size_t>(plan.lidar.gate.bins) * sizeof(float);
}

std::int64_t batch_of(const lidar::LidarPlan& plan, std::size_t memory_bytes) {
  return std::clamp<std::int64_t>(
      static_cast<std::int64_t>(memory_bytes / 4 / std::max<std::size_t>(1, bytes_of_rows(plan))), 1, 4096);
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
  return folder + (lidar.products.las ? "/returns.las" : lidar.products.cube ? "/waveforms.img" : "/run.json");
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
/// not kept. A run that is whole is not lost because its error cannot be told.
void add_error(render::LidarRenderer& renderer, const LidarJob& job, products::RunRecord& record, Context& context) {
  for (const auto& note : job.decision.notes) record.warnings.push_back(note);
  planner::LidarOwnError error;
  error.tolerance = job.decision.tolerance;
  try {
    error = planner::own_error(renderer, job.plan, job.decision);
  } catch (const base::Error& failure) {
    if (failure.fault() == base::Fault::interrupted) throw;
    error.from = failure.what();
  } catch (const std::bad_alloc&) {
    error.from = "there is not enough memory for a trial";
  }
  const std::string text = job.lidar->name + ": " + planner::own_error_text(error);
  record.more_json.emplace_back("error", planner::own_error_json(error));
  if (error.kept() || !error.known() || job.decision.estimated) {  // what a trial found is among the plan's notes
    context.log.info(text);
    return;
  }
  context.log.warning(text);
  record.warnings.push_back(text);
}

}  // namespace

nlohmann::json render_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, const std::string& folder,
                            double load_s, Context& context, const Planning& planning) {
  const auto settings = render_options(context.common);
  render::LidarRenderer renderer(simulation.scene, settings);
  LidarJob job = prepare_lidar(simulation, lidar, context,
                               {&renderer, planning.replay, planning.replay_path, planning.estimate_given});
  const WaysOfShots way(simulation, lidar);
  // The air of the first pulse fired lengthens them all: femtoseconds, but for the worst of paths.
  if (lidar.turbulence.profile != scene::TurbulenceProfile::none)
    if (const auto shots = lidar::make_shots(lidar, 0, std::min<std::int64_t>(lidar.pulses, 4096), simulation.seed);
        !shots.empty())
      lidar::broaden_pulse(job.plan,
                           lidar::turbulence_statistics(job.plan, way(shots.front()), shots.front()).broadening_s2);
  const lidar::LidarPlan& plan = job.plan;
  require_memory(plan, settings.memory_bytes);
  const auto start = std::chrono::steady_clock::now();
  LidarProducts output(folder, context.common.overwrite ? base::IfExists::replace : base::IfExists::refuse, simulation,
                       plan);
  std::optional<LidarBackground> background;
  if (has_background(simulation, lidar)) background.emplace(simulation, plan, settings, context);
  const OtherPulses others(simulation, plan);
  std::optional<nlohmann::json> turbulence;
  std::optional<lidar::PixelBlur> blur;  // of an array's image, as the first pulse's air makes it
  base::Progress progress(context.log, "lidar " + lidar.name, static_cast<std::uint64_t>(lidar.pulses), "pulses");
  std::map<std::string, double> stage_s;
  const auto timed = [&](const char* stage, const auto& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    stage_s[stage] += seconds_since(begin);
  };
  std::uint64_t rays = 0, echoes = 0;
  double worst_ledger = 0;
  LidarRunLight light_of_run(plan);
  const std::int64_t batch = batch_of(plan, settings.memory_bytes);
  // Shots and background light come for many batches at once: a passive plan costs a second, whatever the number of
  // views.
  const std::int64_t chunk = std::max<std::int64_t>(batch, 65536 / std::max(1, plan.pixels()));
  for (std::int64_t first = 0; first < lidar.pulses; first += chunk) {
    const auto shots = lidar::make_shots(lidar, first, std::min(chunk, lidar.pulses - first), simulation.seed);
    std::vector<lidar::Shot> fired = shots;
    for (auto& shot : fired) {
      const auto truth = lidar::apply_turbulence(plan, way(shot), shot);
      if (!blur) blur.emplace(lidar, truth.fried_m);
      if (turbulence || lidar.turbulence.profile == scene::TurbulenceProfile::none) continue;
      turbulence = turbulence_json(lidar, truth);
      for (const auto& warning : truth.warnings) context.log.warning(lidar.name + ": " + warning);
    }
    std::vector<std::vector<double>> light;
    if (background && !shots.empty()) timed("background", [&] { light = background->rates(shots); });
    for (std::size_t begin = 0; begin < fired.size(); begin += static_cast<std::size_t>(batch)) {
      const std::size_t end = std::min(fired.size(), begin + static_cast<std::size_t>(batch));
      const std::vector<lidar::Shot> now(fired.begin() + static_cast<std::ptrdiff_t>(begin),
                                         fired.begin() + static_cast<std::ptrdiff_t>(end));
      std::vector<lidar::ShotResult> results;
      timed("pulses", [&] {
        renderer.render(
            plan, now, [&](lidar::ShotResult&& result) { results.push_back(std::move(result)); }, true);
        others.add_to(results, renderer, [&](lidar::Shot& shot) { lidar::apply_turbulence(plan, way(shot), shot); });
      });
      std::vector<std::vector<lidar::Detection>> records(results.size());
      timed("detection", [&] {
        reference::for_each_index(results.size(), context.common.threads, [&](std::size_t i) {
          if (blur) blur->apply(plan, results[i]);
          if (!light.empty()) results[i].background_hz = light[begin + i];
          records[i] = lidar::detect(plan, results[i]);
        });
      });
      timed("products", [&] {
        for (std::size_t i = 0; i < results.size(); ++i) {
          output.add(results[i], records[i]);
          light_of_run.add(results[i], records[i]);
          rays += static_cast<std::uint64_t>(results[i].rays);
          for (const auto& record : records[i]) echoes += record.echoes.size();
          for (const auto& ledger : results[i].ledger)
            worst_ledger = std::max(worst_ledger, std::abs(ledger.emitted_error()));
        }
      });
      progress.advance(end - begin);
    }
  }
  const double render_s = seconds_since(start);

  const auto device = cl::find_device(settings.device).info();
  products::RunRecord record;
  record.command = context.command_line;
  record.instrument = lidar.name;
  record.scene_hash = simulation.scene.content_hash;
  record.seed = simulation.seed;
  record.platform = device.platform, record.device = device.name, record.driver = device.driver;
  record.opencl_version = device.version;
  record.compute_units = static_cast<int>(device.compute_units);
  record.threads = context.common.threads > 0 ? context.common.threads : static_cast<int>(device.compute_units);
  record.program_hash = renderer.program_hash();
  record.samples = lidar.gate.bins;
  record.lines = lidar.pulses * plan.pixels();
  record.bands = plan.lines();
  record.samples_per_pixel = plan.lidar.transport.subrays;
  record.stage_s = {{"load", load_s}, {"atmosphere", job.table_s}, {"plan", job.plan_s}};
  for (const auto& stage : stage_s) record.stage_s.push_back(stage);
  record.total_s = load_s + job.table_s + job.plan_s + render_s;
  record.rays_per_s = static_cast<double>(rays) / render_s;
  record.memory_budget_bytes = context.common.memory_bytes;
  record.peak_memory_bytes = base::peak_resident_bytes();
  record.device_memory_bytes = device.global_memory_bytes;
  record.configuration_json = simulation.resolved_json;
  record.plan_json = job.plan_json;
  const double pulses_per_s = static_cast<double>(lidar.pulses) / render_s;
  nlohmann::json more = {{"pulses", lidar.pulses},
                         {"echoes", echoes},
                         {"pulses_per_s", pulses_per_s},
                         {"worst_ledger_error", worst_ledger},
                         {"returns_of_matter_expected", light_of_run.returns_of_matter()}};
  if (turbulence) more["turbulence"] = *turbulence;
  record.warnings = light_notices(simulation, lidar);
  record.warnings.insert(record.warnings.end(), job.air_notices.begin(), job.air_notices.end());
  record.more_json = {{"survey", more.dump()}, {"launches", render::tuning_json(renderer.tuning())}};
  if (!job.air_json.empty()) record.more_json.emplace_back("atmosphere", job.air_json);
  if (const std::string warning = light_of_run.warning(); !warning.empty()) {
    record.warnings.push_back(warning);
    context.log.warning(warning);
  }
  add_error(renderer, job, record, context);
  output.publish(record);
  context.log.info(
      fmt::format("{}: {} pulses, {} returns, {:.3g} expected of surfaces and volumes, {:.1f} s, {:.3g} pulses/s, "
                  "energy ledger within {:.1e}, {}",
                  lidar.name, lidar.pulses, echoes, light_of_run.returns_of_matter(), render_s, pulses_per_s,
                  worst_ledger, folder));
  return {{"name", lidar.name},
          {"folder", folder},
          {"kind", "lidar"},
          {"digest", record.digest},
          {"pulses", lidar.pulses},
          {"returns", echoes},
          {"seconds", render_s},
          {"pulses_per_s", pulses_per_s},
          {"worst_ledger_error", worst_ledger},
          {"main", main_file(lidar, folder)}};
}

nlohmann::json dry_run_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, Context& context,
                             const Planning& planning) {
  std::optional<render::LidarRenderer> renderer;
  try {
    renderer.emplace(simulation.scene, render_options(context.common));
  } catch (const base::Error& error) {
    if (error.fault() != base::Fault::device) throw;
    context.log.warning(std::string("the error of the sub-rays cannot be estimated: ") + error.what());
  }
  const LidarJob job =
      prepare_lidar(simulation, lidar, context,
                    {renderer ? &*renderer : nullptr, planning.replay, planning.replay_path, planning.estimate_given});
  const auto& plan = job.plan;
  require_memory(plan, context.common.memory_bytes);
  const auto rows = static_cast<std::uint64_t>(lidar.pulses) * static_cast<std::uint64_t>(plan.pixels()) *
                    static_cast<std::uint64_t>(plan.lines());
  const std::uint64_t rays_per_pulse = job.decision.rays_per_pulse;
  return {{"name", lidar.name},
          {"kind", "lidar"},
          {"pulses", lidar.pulses},
          {"bins", lidar.gate.bins},
          {"pixels", plan.pixels()},
          {"lines", plan.lines()},
          {"rays", static_cast<std::uint64_t>(lidar.pulses) * rays_per_pulse},
          {"spectral_nodes", plan.nodes.size()},
          {"plan", nlohmann::json::parse(job.plan_json)},
          {"pulses_per_batch", batch_of(plan, context.common.memory_bytes)},
          {"waveform_bytes", rows * static_cast<std::uint64_t>(lidar.gate.bins) * sizeof(float)}};
}

std::string dry_run_lidar_text(const nlohmann::json& item) {
  return fmt::format(
      "{}: {} pulses, {} pixels x {} wavelengths x {} bins\n"
      "  rays      {:.3g} first rays, {} spectral nodes\n"
      "  memory    {} pulses at a time\n"
      "  products  waveforms {}\n",
      item["name"].get<std::string>(), item["pulses"].get<std::int64_t>(), item["pixels"].get<int>(),
      item["lines"].get<int>(), item["bins"].get<int>(), item["rays"].get<double>(), item["spectral_nodes"].get<int>(),
      item["pulses_per_batch"].get<std::int64_t>(), base::format_bytes(item["waveform_bytes"].get<std::uint64_t>()));
}

}  // namespace raycube::cli
