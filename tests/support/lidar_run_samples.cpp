// Products of two LIDAR runs, as `render` leaves them, for readers in Python: expectations by the reference, records
// made here without noise, so that every number can be foretold.
//   survey: oscillating mirror over a roof 10 m above a plane, in UTM; waveforms beside the LAS file; every tenth pulse
//           unseen; packed: the same with LAZ; packed_alone: with LAZ instead of LAS
//   flash:  8 x 8 Geiger pixels, two lines, orders apart, no coordinate system; waveforms inside the LAS file
#include <cmath>
#include <cstdio>
#include <cstring>

#include "host/run/lidar_products.h"
#include "host/reference/lidar_shot.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;

namespace {

constexpr double kLight_m_s = 299792458.0;

scene::Lidar survey_lidar() {
  scene::Lidar lidar = test::topographic_lidar();
  lidar.name = "survey";
  lidar.trajectory = {{0, 0, -30, 600, 0, 0, 0}, {1, 0, 30, 600, 0, 0, 0}};
  lidar.prf_hz = 2000;
  lidar.pulses = 2000;
  lidar.gps_start_s = 4.5e8;
  lidar.scan = {scene::ScanPattern::oscillating, 20, 4 * M_PI / 180, 1, 1, 0};
  lidar.gate = {3.9e-6, 1e-9, 200};
  lidar.transport.subrays = 16;
  return lidar;
}

scene::Lidar flash_lidar() {
  scene::Lidar lidar = test::topographic_lidar();
  lidar.name = "flash";
  lidar.trajectory = {{0, 0, 0, 600, 0, 0, 0}};
  lidar.pulses = 5;
  lidar.pulse.lines = {{"on", 1.6455, 0, 1e-3}, {"off", 1.6456, 0, 2e-3}};
  lidar.pulse.profile = scene::BeamProfile::uniform;
  lidar.pulse.half_divergence_rad = 0.03;
  lidar.receiver.columns = lidar.receiver.rows = 8;
  lidar.receiver.pixel_pitch_rad = 0.005;
  lidar.gate = {3.9e-6, 0.5e-9, 256};
  lidar.transport.sampling = scene::LidarSampling::receiver;
  lidar.transport.subrays = 4;
  lidar.detector.mode = scene::DetectorMode::geiger;
  lidar.products.orders = lidar.products.internal_waveforms = true;
  return lidar;
}

/// What a noiseless detector finds in a pixel's row: one echo for each run of bins above a thousandth of the highest.
lidar::Detection record(const lidar::LidarPlan& plan, const lidar::ShotResult& result, int pixel, int line) {
  const auto bins = static_cast<std::size_t>(plan.lidar.gate.bins);
  const float* row = result.first.data() + static_cast<std::size_t>(pixel * plan.lines() + line) * bins;
  lidar::Detection d;
  d.pulse = result.shot.pulse, d.pixel = pixel, d.line = line;
  d.gain = result.shot.pulse % 2 ? 1.0 : 2.0;  // two full scales: two descriptors
  d.offset = -4;
  float highest = 0;
  const bool unseen = result.shot.pulse % 10 == 9;
  for (std::size_t i = 0; i < bins; ++i) {
    const double pe = unseen ? 0 : plan.lidar.receiver.quantum_efficiency * row[i];
    d.samples.push_back(static_cast<std::uint16_t>(std::lround((pe - d.offset) / d.gain)));
    d.waveform_pe.push_back(static_cast<float>(d.offset + d.gain * d.samples.back()));
    highest = std::max(highest, d.waveform_pe.back());
  }
  d.truth.threshold_pe = 1e-3 * highest;
  for (std::size_t i = 0; i < bins && !unseen; ++i) {
    double sum = 0, moment = 0;
    lidar::Echo echo;
    for (; i < bins && row[i] > 1e-3f * highest; ++i) {
      const double pe = plan.lidar.receiver.quantum_efficiency * row[i];
      sum += pe, moment += pe * (static_cast<double>(i) + 0.5);
      echo.peak_pe = std::max(echo.peak_pe, static_cast<float>(pe));
    }
    if (sum == 0) continue;
    echo.time_s = plan.lidar.gate.start_s + plan.lidar.gate.bin_s * moment / sum;
    echo.range_m = echo.time_s * kLight_m_s / 2;
    echo.energy_pe = static_cast<float>(sum);
    echo.fwhm_s = 4e-9f;
    echo.detection_probability = 1;
    echo.number = static_cast<int>(d.echoes.size()) + 1;
    d.echoes.push_back(echo);
    d.tags.push_back({echo.time_s, 0});
  }
  for (auto& echo : d.echoes) echo.of = static_cast<int>(d.echoes.size());
  return d;
}

void write_run(const std::string& folder, const scene::Lidar& lidar, bool georeferenced) {
  scene::Simulation simulation;
  simulation.scene = test::scene_of({0.4, 0.2});
  simulation.scene.materials[0].name = "grass";
  simulation.scene.materials[1].name = "roof";
  test::add_plane(simulation.scene, 0, {0, 0, 0}, 200);
  test::add_plane(simulation.scene, 1, {5, 0, 10}, 10);
  scene::finish_top_tree(simulation.scene);
  if (georeferenced) simulation.scene.origin = {32618, 276000.0, 4753000.0, 180.0};
  const lidar::LidarPlan plan = test::hand_plan(lidar, simulation.scene);
  const reference::EmbreeScene embree(simulation.scene);
  run::LidarProducts products(folder, base::IfExists::refuse, simulation, plan);
  for (const auto& shot : lidar::make_shots(lidar, 0, lidar.pulses, 1)) {
    const auto expected = reference::reference_shot(simulation.scene, embree, plan, shot);
    lidar::ShotResult result;
    result.shot = shot;
    result.first.assign(expected.rows.first.begin(), expected.rows.first.end());
    if (lidar.products.orders)
      result.multiple.assign(result.first.size(), 0.25f), result.air.assign(result.first.size(), 0.125f);
    result.ledger = expected.ledger;
    for (const auto& hit : expected.hits) result.hits.push_back({hit.instance, hit.primitive});
    result.rays = static_cast<std::int64_t>(expected.hits.size());
    std::vector<lidar::Detection> detections;
    for (int pixel = 0; pixel < plan.pixels(); ++pixel)
      for (int line = 0; line < plan.lines(); ++line) detections.push_back(record(plan, result, pixel, line));
    std::vector<std::vector<lidar::ReturnTruth>> truth;
    products.truth(result, detections, truth);
    products.add(result, detections, truth);
  }
  products::RunRecord report;
  report.command = "lidar_run_samples";
  report.instrument = lidar.name;
  products.publish(report);
}

}  // namespace

int main(int count, char** arguments) {
  try {
    if (count == 3 && std::strcmp(arguments[1], "survey") == 0) return write_run(arguments[2], survey_lidar(), true), 0;
    if (count == 3 && std::strncmp(arguments[1], "packed", 6) == 0) {
      scene::Lidar lidar = survey_lidar();
      lidar.products.laz = true;
      lidar.products.las = std::strcmp(arguments[1], "packed") == 0;
      return write_run(arguments[2], lidar, true), 0;
    }
    if (count == 3 && std::strcmp(arguments[1], "flash") == 0) return write_run(arguments[2], flash_lidar(), false), 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "error: %s\n", error.what());
    return 1;
  }
  std::fprintf(stderr, "usage: lidar_run_samples survey|packed|packed_alone|flash FOLDER\n");
  return 2;
}
