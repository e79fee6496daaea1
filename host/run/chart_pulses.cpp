#include <algorithm>

#include "host/base/cache_folder.h"
#include "host/base/error.h"
#include "host/base/text.h"
#include "host/run/chart_point.h"
#include "host/run/check_lidar.h"
#include "host/run/lidar_job.h"
#include "host/run/camera_job.h"
#include "host/render/lidar_renderer.h"
#include "host/study/kept.h"
#include "host/study/lidar_converged.h"

namespace raycube::run {

namespace {

/// Of the reference. A field's samples are per pixel, and pixels are many.
constexpr int kBeamRays = 4096, kPixelRays = 1024, kBounces = 4, kLineNodes = 32;

lidar::LidarPlan reference_plan(const knobs::Subject& subject, Services& services) {
  const knobs::Settings keep(subject);
  scene::LidarTransport& transport = subject.lidar->transport;
  transport.subrays =
      std::max(transport.subrays, transport.sampling == scene::LidarSampling::receiver ? kPixelRays : kBeamRays);
  transport.max_bounces = std::max(transport.max_bounces, kBounces);
  transport.line_nodes = std::max(transport.line_nodes, kLineNodes);
  transport.overlap = scene::LidarOverlap::exact;
  transport.air_return = true;
  return prepare_lidar(subject.simulation, *subject.lidar, services).plan;
}

}  // namespace

Chart chart_pulses(scene::Simulation& simulation, std::size_t index, const ChartOptions& options,
                   const std::vector<std::string>& devices, const render::RenderOptions& given, Services& services) {
  scene::Lidar& lidar = simulation.lidars[index];
  const knobs::Subject subject{simulation, nullptr, &lidar};
  const auto chosen = chosen_knobs(subject, options.knobs);
  const LidarJob job = prepare_lidar(simulation, lidar, services);
  const std::vector<lidar::Shot> shots =
      pick_shots(lidar, simulation.seed, options.pulses > 0 ? options.pulses : default_pulses(job.plan));
  std::vector<std::int64_t> pulses;
  for (const lidar::Shot& shot : shots) pulses.push_back(shot.pulse);

  Chart chart;
  chart.name = lidar.name;
  chart.kind = "pulses";
  chart.tolerance = simulation.tolerance;
  chart.validated = shots.size();
  const lidar::LidarPlan finest = reference_plan(subject, services);
  study::Kept kept;
  const study::Converged found = study::kept_or(
      base::cache_folder("reference").string(), study::key_of(simulation, finest, pulses),
      [&] {
        const Step progress(services, "reference of " + lidar.name, pulses.size(), "pulses");
        study::ConvergedPulses rows = study::converge_pulses(simulation.scene, finest, pulses, services.threads,
                                                             [&](std::uint64_t more) { progress.advance(more); });
        return study::Converged{rows.bins, std::move(rows.photons), std::move(rows.half)};
      },
      &kept);
  if (!kept.warning.empty()) services.log.warning(kept.warning);
  const study::ConvergedPulses reference{found.bands, finest.lidar.gate.bin_s, found.radiance, found.half};
  chart.reference = "Embree and double, " + base::counted(2 * finest.footprint.a.size(), "sub-ray") + ", " +
                    std::to_string(finest.lidar.transport.max_bounces) + " bounces";
  chart.what_time =
      "the survey's " + base::counted(lidar.pulses, "pulse") + ": tracing and binning, without moving data";
  for (const std::string& number : devices) {
    render::RenderOptions where = given;
    where.device = number;
    render::LidarRenderer renderer(simulation.scene, where);
    chart.machines.push_back(renderer.device_name());
    for_each_setting(subject, chosen, [&](ChartPoint point) {
      point.device = renderer.device_name();
      services.log.set_status("chart " + lidar.name + ": " + point.knob + " " + point.label);
      const lidar::LidarPlan plan = prepare_lidar(simulation, lidar, services).plan;
      std::vector<float> photons;
      std::vector<double> seconds;
      double rays = 0;
      for (int repeat = 0; repeat <= options.repeats; ++repeat) {
        renderer.render(plan, shots, [&](lidar::ShotResult&& shot) {
          if (repeat > 0) return;
          rays += static_cast<double>(shot.rays);
          for (std::size_t i = 0; i < shot.first.size(); ++i)
            photons.push_back(shot.first[i] + (shot.multiple.empty() ? 0.0f : shot.multiple[i]) +
                              (shot.air.empty() ? 0.0f : shot.air[i]));
        });
        if (repeat > 0)
          seconds.push_back(renderer.launch_s() / static_cast<double>(shots.size()) *
                            static_cast<double>(lidar.pulses));
      }
      const study::PulseError error =
          study::pulse_error(reference, photons, static_cast<std::size_t>(plan.lidar.gate.bins), plan.lidar.gate.bin_s);
      chart.own_error = error.own;
      point.error = point.rms = error.rms, point.error_low = error.low, point.error_high = error.high,
      point.p95 = error.p95;
      std::sort(seconds.begin(), seconds.end());
      point.time_s = (seconds[(seconds.size() - 1) / 2] + seconds[seconds.size() / 2]) / 2;
      point.time_low_s = seconds.front(), point.time_high_s = seconds.back();
      point.rays = rays / static_cast<double>(shots.size());
      chart.points.push_back(std::move(point));
    });
  }
  services.log.set_status("");
  mark_front(chart);
  return chart;
}

}  // namespace raycube::run
