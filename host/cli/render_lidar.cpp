#include "host/cli/render_lidar.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/base/memory.h"
#include "host/base/progress.h"
#include "host/cl/device.h"
#include "host/cli/lidar_job.h"
#include "host/cli/lidar_products.h"
#include "host/cli/simulation_job.h"
#include "host/lidar/apply_turbulence.h"
#include "host/lidar/image_blur.h"
#include "host/lidar/detection.h"
#include "host/reference/parallel.h"
#include "host/render/lidar_renderer.h"

namespace raycube::cli {

namespace {

constexpr double kLight_m_s = 299792458.0;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

std::size_t bytes_of_rows(const lidar::LidarPlan& plan) {
  const auto& transport = plan.lidar.transport;
  const std::size_t kinds = 1 + (transport.max_bounces > 1) + transport.air_return;
  // Expectations, and as much again for the record made of them.
  return 2 * kinds * static_cast<std::size_t>(plan.pixels()) * static_cast<std::size_t>(plan.lines()) *
         static_cast<std::size_t>(plan.lidar.gate.bins) * sizeof(float);
}

std::int64_t batch_of(const lidar::LidarPlan& plan, std::size_t memory_bytes) {
  return std::clamp<std::int64_t>(static_cast<std::int64_t>(memory_bytes / 4 / std::max<std::size_t>(1, bytes_of_rows(plan))), 1, 4096);
}

/// Farthest corner of the scene from any place of the platform, m.
double farthest_m(const scene::CompiledScene& scene, const scene::Lidar& lidar) {
  double farthest = 0;
  for (const auto& pose : lidar.trajectory)
    for (int corner = 0; corner < 8; ++corner)
      farthest = std::max(farthest, std::hypot((corner & 1 ? scene.hi[0] : scene.lo[0]) - pose.x_m, (corner & 2 ? scene.hi[1] : scene.lo[1]) - pose.y_m,
                                               (corner & 4 ? scene.hi[2] : scene.lo[2]) - pose.z_m));
  return farthest;
}

/// What turbulence did to the survey's first shot, in words for the record; its own draws are left out.
nlohmann::json turbulence_json(const lidar::TurbulenceTruth& t) {
  return {{"path_m", t.path_m}, {"rytov_variance_spherical", t.rytov_spherical}, {"fried_m", t.fried_m}, {"beam_radius_m", t.beam_radius_m},
          {"short_term_radius_m", t.short_term_m}, {"long_term_radius_m", t.long_term_m}, {"wander_sigma_m", t.wander_sigma_m},
          {"tilt_sigma_rad", t.tilt_sigma_rad}, {"blur_fwhm_rad", t.blur_fwhm_rad}, {"scintillation_index", t.index_total},
          {"distribution", t.gamma_gamma ? "gamma-gamma" : "log-normal"}, {"broadening_s2", t.broadening_s2}, {"correlation_s", t.correlation_s}, {"warnings", t.warnings}};
}

std::string main_file(const scene::Lidar& lidar, const std::string& folder) {
  return folder + (lidar.products.las ? "/returns.las" : lidar.products.cube ? "/waveforms.img" : "/run.json");
}

/// Light of pulses fired earlier that arrives while a gate is open: the same shots again with the gate later by whole periods.
class EarlierPulses {
 public:
  EarlierPulses(const scene::Simulation& simulation, const lidar::LidarPlan& plan, double ground_m) : seed_(simulation.seed), ground_m_(ground_m) {
    if (!plan.lidar.fold_ambiguous) return;
    const double last_s = 2 * farthest_m(simulation.scene, plan.lidar) * plan.lidar.transport.group_index / kLight_m_s;
    for (int back = 1; plan.lidar.gate.start_s + back / plan.lidar.prf_hz < last_s; ++back) {
      plans_.push_back(plan);
      plans_.back().lidar.gate.start_s += back / plan.lidar.prf_hz;
    }
  }

  void add_to(std::vector<lidar::ShotResult>& results, render::LidarRenderer& renderer) const {
    for (std::size_t back = 1; back <= plans_.size() && !results.empty(); ++back) {
      std::map<std::int64_t, lidar::ShotResult*> open;
      for (auto& result : results) open[result.shot.pulse - static_cast<std::int64_t>(back)] = &result;
      const std::int64_t first = std::max<std::int64_t>(0, open.begin()->first), last = open.rbegin()->first;
      if (last < 0) continue;
      auto shots = lidar::make_shots(plans_[back - 1].lidar, first, last - first + 1, seed_);
      for (auto& shot : shots) lidar::apply_turbulence(plans_[back - 1], ground_m_, shot);
      std::erase_if(shots, [&](const lidar::Shot& shot) { return open.count(shot.pulse) == 0; });
      renderer.render(plans_[back - 1], shots, [&](lidar::ShotResult&& earlier) {
        lidar::ShotResult& result = *open[earlier.shot.pulse];
        const auto add = [](std::vector<float>& to, const std::vector<float>& from) {
          for (std::size_t i = 0; i < std::min(to.size(), from.size()); ++i) to[i] += from[i];
        };
        add(result.first, earlier.first), add(result.multiple, earlier.multiple), add(result.air, earlier.air);
        result.rays += earlier.rays;
      });
    }
  }

 private:
  std::uint64_t seed_;
  double ground_m_;
  std::vector<lidar::LidarPlan> plans_;
};

}  // namespace

nlohmann::json render_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, const std::string& folder, double load_s,
                            Context& context) {
  const auto settings = render_options(context.common);
  LidarJob job = prepare_lidar(simulation, lidar, context);
  const lidar::LidarPlan& plan = job.plan;
  const auto start = std::chrono::steady_clock::now();
  LidarProducts output(folder, context.common.overwrite ? base::IfExists::replace : base::IfExists::refuse, simulation, plan);
  render::LidarRenderer renderer(simulation.scene, settings);
  std::optional<LidarBackground> background;
  if (lidar.detector.solar_background && simulation.sun.zenith_deg < 90) background.emplace(simulation, plan, settings, context);
  const double ground_m = simulation.scene.instances.empty() ? 0.0 : simulation.scene.lo[2];
  const EarlierPulses earlier(simulation, plan, ground_m);
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
  const std::int64_t batch = batch_of(plan, settings.memory_bytes);
  // Shots and background light come for many batches at once: a passive plan costs a second, whatever the number of views.
  const std::int64_t chunk = std::max<std::int64_t>(batch, 65536 / std::max(1, plan.pixels()));
  for (std::int64_t first = 0; first < lidar.pulses; first += chunk) {
    const auto shots = lidar::make_shots(lidar, first, std::min(chunk, lidar.pulses - first), simulation.seed);
    std::vector<lidar::Shot> fired = shots;
    for (auto& shot : fired) {
      const auto truth = lidar::apply_turbulence(plan, ground_m, shot);
      if (!blur) blur.emplace(lidar, truth.fried_m);
      if (turbulence || lidar.turbulence.profile == scene::TurbulenceProfile::none) continue;
      turbulence = turbulence_json(truth);
      for (const auto& warning : truth.warnings) context.log.warning(lidar.name + ": " + warning);
    }
    std::vector<std::vector<double>> light;
    if (background && !shots.empty()) timed("background", [&] { light = background->rates(shots); });
    for (std::size_t begin = 0; begin < fired.size(); begin += static_cast<std::size_t>(batch)) {
      const std::size_t end = std::min(fired.size(), begin + static_cast<std::size_t>(batch));
      const std::vector<lidar::Shot> now(fired.begin() + static_cast<std::ptrdiff_t>(begin), fired.begin() + static_cast<std::ptrdiff_t>(end));
      std::vector<lidar::ShotResult> results;
      timed("pulses", [&] {
        renderer.render(plan, now, [&](lidar::ShotResult&& result) { results.push_back(std::move(result)); }, true);
        earlier.add_to(results, renderer);
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
          rays += static_cast<std::uint64_t>(results[i].rays);
          for (const auto& record : records[i]) echoes += record.echoes.size();
          for (const auto& ledger : results[i].ledger) worst_ledger = std::max(worst_ledger, std::abs(ledger.emitted_error()));
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
  record.samples_per_pixel = lidar.transport.subrays;
  record.stage_s = {{"load", load_s}, {"atmosphere", job.table_s}, {"plan", job.plan_s}};
  for (const auto& stage : stage_s) record.stage_s.push_back(stage);
  record.total_s = load_s + job.table_s + job.plan_s + render_s;
  record.rays = rays;
  record.rays_per_s = static_cast<double>(rays) / render_s;
  record.memory_budget_bytes = context.common.memory_bytes;
  record.peak_memory_bytes = base::peak_resident_bytes();
  record.device_memory_bytes = device.global_memory_bytes;
  record.configuration_json = simulation.resolved_json;
  const double pulses_per_s = static_cast<double>(lidar.pulses) / render_s;
  nlohmann::json more = {{"pulses", lidar.pulses}, {"echoes", echoes}, {"pulses_per_s", pulses_per_s}, {"worst_ledger_error", worst_ledger}};
  if (turbulence) more["turbulence"] = *turbulence;
  record.more_json = {{"survey", more.dump()}};
  output.publish(record);
  context.log.info(fmt::format("{}: {} pulses, {} returns, {:.1f} s, {:.3g} pulses/s, energy ledger within {:.1e}, {}", lidar.name, lidar.pulses,
                               echoes, render_s, pulses_per_s, worst_ledger, folder));
  return {{"name", lidar.name},   {"folder", folder},     {"kind", "lidar"},  {"digest", record.digest},
          {"pulses", lidar.pulses}, {"returns", echoes}, {"seconds", render_s}, {"pulses_per_s", pulses_per_s},
          {"worst_ledger_error", worst_ledger}, {"main", main_file(lidar, folder)}};
}

nlohmann::json dry_run_lidar(const scene::Simulation& simulation, const scene::Lidar& lidar, Context& context) {
  const LidarJob job = prepare_lidar(simulation, lidar, context);
  const auto& plan = job.plan;
  const auto rows = static_cast<std::uint64_t>(lidar.pulses) * static_cast<std::uint64_t>(plan.pixels()) * static_cast<std::uint64_t>(plan.lines());
  const std::uint64_t rays_per_pulse = static_cast<std::uint64_t>(lidar.transport.subrays) *
                                       (lidar.transport.sampling == scene::LidarSampling::receiver ? static_cast<std::uint64_t>(plan.pixels()) : 1u);
  return {{"name", lidar.name},
          {"kind", "lidar"},
          {"pulses", lidar.pulses},
          {"bins", lidar.gate.bins},
          {"pixels", plan.pixels()},
          {"lines", plan.lines()},
          {"rays", static_cast<std::uint64_t>(lidar.pulses) * rays_per_pulse},
          {"spectral_nodes", plan.nodes.size()},
          {"pulses_per_batch", batch_of(plan, context.common.memory_bytes)},
          {"waveform_bytes", rows * static_cast<std::uint64_t>(lidar.gate.bins) * sizeof(float)}};
}

std::string dry_run_lidar_text(const nlohmann::json& item) {
  return fmt::format("{}: {} pulses, {} pixels x {} wavelengths x {} bins\n"
                     "  rays      {:.3g} first rays, {} spectral nodes\n"
                     "  memory    {} pulses at a time\n"
                     "  products  waveforms {}\n",
                     item["name"].get<std::string>(), item["pulses"].get<std::int64_t>(), item["pixels"].get<int>(), item["lines"].get<int>(),
                     item["bins"].get<int>(), item["rays"].get<double>(), item["spectral_nodes"].get<int>(),
                     item["pulses_per_batch"].get<std::int64_t>(), base::format_bytes(item["waveform_bytes"].get<std::uint64_t>()));
}

}  // namespace raycube::cli
