// Where LIDARs fail (REQUIREMENTS section 4, LIDAR and Volumes), on every device found. Oracles: the link budget L-01
// of lidar_link_test, Beer's law, times of flight, linearity.
#include <doctest/doctest.h>

#include <cmath>

#include "host/lidar/detection.h"
#include "host/lidar/volumes.h"
#include "tests/support/chance_checks.h"
#include "tests/support/devices.h"
#include "tests/support/lidar_device.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;
using namespace raycube::test;

namespace {

constexpr double kUnit =
    134685.6010 / 0.8187307530779818;  // L-01 without its air, exp(-0.2): photons back from rho 0.3 at 1000 m

scene::CompiledScene ground(double z_m = 0) {
  scene::CompiledScene scene = scene_of({0.3});
  add_plane(scene, 0, {0, 0, z_m}, 40);
  scene::finish_top_tree(scene);
  return scene;
}

void sound(const lidar::ShotResult& result) {
  for (const auto* row : {&result.first, &result.multiple, &result.air})
    for (const float bin : *row) REQUIRE((std::isfinite(bin) && bin >= 0));
  for (const auto& ledger : result.ledger) CHECK(std::abs(ledger.emitted_error()) <= 1e-6);
}

lidar::ShotResult down(const std::string& device, const scene::CompiledScene& scene, const lidar::LidarPlan& plan,
                       double z_m = 1000) {
  const auto result =
      render_shots(scene, plan, {shot_from(plan.lidar, {0, 0, z_m}, {0, 0, -1})}, {.device = device}).at(0);
  sound(result);
  return result;
}

}  // namespace

TEST_CASE("stability: zero divergence, equal ranges: every sub-ray of 1 to 4096 is kept") {
  const auto scene = ground();
  for (const auto& device : device_numbers())
    for (const int subrays : {1, 250, 4096}) {
      scene::Lidar lidar = pencil_lidar();
      lidar.transport.subrays = subrays;
      // One rounding of 2^-24 for each sub-ray added.
      CHECK(moments(down(device, scene, hand_plan(lidar, scene)).first).sum ==
            doctest::Approx(kUnit).epsilon(2e-6 + 6e-8 * subrays));
    }
}

TEST_CASE(
    "stability: no photons, a fraction of one, 1e9 and 1e20: bins are proportional, counts are drawn without "
    "overflow") {
  const auto scene = ground();
  for (const auto& device : device_numbers())
    for (const double photons : {0.0, 1e-6, 1e9, 1e20}) {
      CAPTURE(photons);
      scene::Lidar lidar = pencil_lidar();
      lidar.receiver.quantum_efficiency = 1;
      lidar.pulse.lines[0].energy_J *= photons / kUnit;
      const lidar::LidarPlan plan = hand_plan(lidar, scene);
      const auto result = down(device, scene, plan);
      const double sum = moments(result.first).sum;
      CHECK(sum == doctest::Approx(photons).epsilon(2e-6));
      for (const auto& record : lidar::detect(plan, result)) {
        double counts = 0;
        for (const float bin : record.waveform_pe) {
          REQUIRE(std::isfinite(bin));
          counts += bin;
        }
        // Poisson: five standard deviations, and the rounding of floats above 2^24.
        CHECK_WITHIN(counts - sum, 5 * std::sqrt(sum) + 1e-6 * sum);
      }
    }
}

TEST_CASE("stability: 600 m, 20 km and 400 km at bins of 0.1 ns: time of flight, energy by 1 / R^2") {
  for (const auto& device : device_numbers())
    for (const double range_m : {600.0, 20000.0, 400000.0}) {
      CAPTURE(range_m);
      const auto scene = ground(3);
      scene::Lidar lidar = pencil_lidar();
      lidar.gate = {2 * range_m / kLightSpeed - 20.05e-9, 0.1e-9, 400};
      const auto result = down(device, scene, hand_plan(lidar, scene), range_m + 3);
      const Moments m = moments(result.first);
      // Position: fp32 relative to a place near the scene, 2.7e-3 bins (40 um) as L-29 of lidar_surfaces.
      CHECK(std::abs(m.mean_bin - 200.5) < 2.7e-3);
      CHECK(m.sum == doctest::Approx(kUnit * 1e6 / (range_m * range_m)).epsilon(1e-5));
    }
}

TEST_CASE(
    "stability: bins a hundred times narrower and wider than the pulse, returns at a bin's edge and beyond the gate") {
  const auto scene = ground();
  const double time_s = 2000 / kLightSpeed;
  for (const auto& device : device_numbers()) {
    for (const double bin_s : {0.08e-9, 1e-9, 4e-9, 400e-9}) {
      CAPTURE(bin_s);
      scene::Lidar lidar = pencil_lidar();
      lidar.gate = {0, bin_s, static_cast<int>(std::ceil(8e-6 / bin_s))};
      if (bin_s < 1e-9) lidar.gate = {time_s - 20e-9, bin_s, 500};
      const Moments m = moments(down(device, scene, hand_plan(lidar, scene)).first);
      CHECK(m.sum == doctest::Approx(kUnit).epsilon(2e-6));
      if (bin_s < 4e-9)  // 1e-5 of the position in bins, and the taps' linear phases
        CHECK(std::abs(lidar.gate.start_s + m.mean_bin * bin_s - time_s) < 1e-3 * std::max(bin_s, 1e-9));
    }
    for (const double late_bins :
         {-300.0, -100.0, 0.0, 50.0, 100.0, 300.0}) {  // where the return stands against the gate of 100 bins
      CAPTURE(late_bins);
      scene::Lidar lidar = pencil_lidar();
      lidar.gate = {time_s - late_bins * 1e-9, 1e-9, 100};
      const auto plan = hand_plan(lidar, scene);
      const auto result = down(device, scene, plan);
      const auto& ledger = result.ledger[0];
      const double inside = moments(result.first).sum / plan.photons[0];
      CHECK(inside + ledger.early + ledger.late == doctest::Approx(ledger.collected).epsilon(5e-6));
      const double expected = late_bins < 0 || late_bins > 100 ? 0
                              : late_bins == 50                ? 1
                                                               : 0.5;  // a symmetric pulse on the gate's end
      CHECK(inside / ledger.collected == doctest::Approx(expected).epsilon(1e-3));
    }
  }
}

TEST_CASE("stability: air of optical depth 0, 1e-6, 1, 20 and 700 follows Beer's law to the last photon") {
  const auto scene = ground();
  for (const auto& device : device_numbers())
    for (const double depth : {0.0, 1e-6, 1.0, 20.0, 700.0}) {
      CAPTURE(depth);
      lidar::LidarPlan plan = hand_plan(pencil_lidar(), scene);
      if (depth > 0) set_air(plan, depth / 1000, 0, 0, 2000);
      const auto result = down(device, scene, plan);
      const double expected = kUnit * std::exp(-2 * depth);
      // fp32: the exponent of -40 carries 40 x 2^-24 relative for each of its few roundings. exp(-1400) is 0 in any
      // float.
      CHECK(moments(result.first).sum == doctest::Approx(expected).epsilon(1e-5 + 1e-6 * depth));
      CHECK(result.ledger[0].air == doctest::Approx(1 - std::exp(-depth)).epsilon(1e-6));
    }
}

TEST_CASE("stability: gas in a box of optical depth 0, 1e-6, 1, 20 and 700 follows Beer's law") {
  for (const auto& device : device_numbers())
    for (const double depth : {0.0, 1e-6, 1.0, 20.0, 700.0}) {
      CAPTURE(depth);
      scene::CompiledScene scene = ground();
      scene::Volume gas;
      gas.name = "gas", gas.gas = "synthetic";
      gas.position_m = {0, 0, 100}, gas.size_m = {50, 50, 10};
      gas.concentration_ppm = 100;
      scene.volumes.push_back(gas);
      lidar::LidarPlan plan = hand_plan(pencil_lidar(), scene);
      plan.cross_section_cm2 = {depth / (1000 * lidar::kMoleculesPerPpmM)};
      CHECK(moments(down(device, scene, plan).first).sum ==
            doctest::Approx(kUnit * std::exp(-2 * depth)).epsilon(1e-5 + 2e-6 * depth));
    }
}

TEST_CASE(
    "stability: a pulse through the edge and the vertex of plates passes each plate once each way; coincident plates "
    "are one") {
  const double tau = 0.6;
  for (const auto& device : device_numbers())
    for (const double apart_m :
         {-1.0, 0.0, 1e-3}) {  // one layer; two in one plane, which are one surface; two 1 mm apart
      CAPTURE(apart_m);
      scene::CompiledScene scene = scene_of({0.3, 0.1});
      scene.materials[1].transmittance = {{0.3, 4.0}, {static_cast<float>(tau), static_cast<float>(tau)}};
      scene.materials[1].behind.number = RC_SHAPE_plate;
      add_plane(scene, 0, {0, 0, 0}, 40);
      // Four squares that meet on the axis, each of two triangles: their common vertex and edges.
      for (int layer = 0; layer < (apart_m < 0 ? 1 : 2); ++layer)
        for (const double x : {-1.0, 0.0})
          for (const double y : {-1.0, 0.0})
            add_rectangle(scene, 1, {x, y, 500 + layer * apart_m}, {1, 0, 0}, {0, 1, 0});
      scene::finish_top_tree(scene);
      for (const auto& [x, y] : {std::pair{0.0, 0.0},
                                 {0.5, 0.0},
                                 {0.0, -0.25},
                                 {0.5, 0.5},
                                 {-0.3, -0.7}}) {  // vertex, edges, diagonal, inside
        CAPTURE(x);
        CAPTURE(y);
        scene::Lidar lidar = pencil_lidar();
        lidar.gate = {6600e-9, 1e-9, 200};
        const lidar::LidarPlan plan = hand_plan(lidar, scene);
        const auto result =
            render_shots(scene, plan, {shot_from(lidar, {x, y, 1000}, {0, 0, -1})}, {.device = device}).at(0);
        sound(result);
        CHECK(moments(result.first).sum == doctest::Approx(kUnit * std::pow(tau, apart_m > 0 ? 4 : 2)).epsilon(2e-5));
      }
    }
}

TEST_CASE("stability: near field: a coaxial obscured receiver is blind up to r_o / phi and whole beyond r / phi") {
  for (const auto& device : device_numbers()) {
    scene::Lidar lidar = pencil_lidar();
    lidar.receiver.aperture_radius_m = 0.10, lidar.receiver.obscuration_radius_m = 0.04,
    lidar.receiver.half_fov_rad = 0.5e-3;
    lidar.gate = {0, 2e-9, 1000};
    const auto scene = ground();
    for (const double range_m : {0.05, 10.0, 79.9, 200.1, 250.0}) {
      CAPTURE(range_m);
      lidar.transport.overlap = scene::LidarOverlap::off;
      const double all = down(device, scene, hand_plan(lidar, scene), range_m).ledger[0].collected;
      lidar.transport.overlap = scene::LidarOverlap::exact;
      CHECK(down(device, scene, hand_plan(lidar, scene), range_m).ledger[0].collected ==
            doctest::Approx(range_m > 100 ? all : 0).epsilon(1e-6));
    }
  }
}

TEST_CASE("stability: the axis misses the scene and the footprint's edge hits it") {
  for (const auto& device : device_numbers()) {
    scene::CompiledScene scene = scene_of({0.3});
    add_rectangle(scene, 0, {0.05, -20, 0}, {20, 0, 0}, {0, 40, 0});  // beyond x = 0.05 m; 1/e2 radius 0.25 m
    scene::finish_top_tree(scene);
    scene::Lidar lidar = topographic_lidar();
    lidar.transport.subrays = 4096;
    const double share = 0.5 * std::erfc(0.05 / 0.25 * std::sqrt(2.0));
    CHECK(moments(down(device, scene, hand_plan(lidar, scene)).first).sum / kUnit ==
          doctest::Approx(share).epsilon(0.02));  // 4096 equal sub-rays
    CHECK(moments(down(device, scene, hand_plan(pencil_lidar(), scene)).first).sum == 0);
  }
}
