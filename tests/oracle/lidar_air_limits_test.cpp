// The air's return at its limits: next to the telescope, behind plates, 400 km away, in the pixels of an array.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "host/lidar/overlap.h"
#include "tests/oracle/lidar_reference_kit.h"
#include "tests/support/lidar_device.h"

using namespace raycube;
using namespace raycube::test;

namespace {

constexpr double kExtinction = 1e-6, kBackscatter = 3e-6;

scene::Lidar sounder() {
  scene::Lidar lidar = topographic_lidar();
  lidar.pulse.fwhm_s = 0;
  lidar.transport.air_return = true;
  return lidar;
}

void gate(scene::Lidar& lidar, double from_m, double bin_m, int bins) {
  lidar.gate = {2 * from_m / kLightSpeed, 2 * bin_m / kLightSpeed, bins};
}

lidar::LidarPlan plan_of(const scene::Lidar& lidar, const scene::CompiledScene& scene, double extinction = kExtinction,
                         double backscatter = kBackscatter) {
  lidar::LidarPlan plan = hand_plan(lidar, scene);
  set_air(plan, extinction, backscatter, -20000, 20000);
  return plan;
}

lidar::ShotResult one(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, const lidar::Shot& shot) {
  return render_shots(scene, plan, {shot}).at(0);
}

scene::CompiledScene nothing() {
  scene::CompiledScene scene = scene_of({0.3});
  scene::finish_top_tree(scene);
  return scene;
}

/// Photons times m2 / share, of a bin of constant air: the LIDAR equation without eta / R^2.
double level(const lidar::LidarPlan& plan) {
  const auto& receiver = plan.lidar.receiver;
  return plan.photons[0] * kBackscatter * M_PI *
         (std::pow(receiver.aperture_radius_m, 2) - std::pow(receiver.obscuration_radius_m, 2)) * receiver.efficiency;
}

/// Simpson's rule over 400 pieces.
double integral(double from, double to, const std::function<double(double)>& value) {
  double sum = value(from) + value(to);
  for (int i = 1; i < 400; ++i) sum += value(from + (to - from) * i / 400) * (i % 2 ? 4 : 2);
  return sum * (to - from) / 1200;
}

/// Rectangle across a level beam along x, from y_m to 50 m.
void add_screen(scene::CompiledScene& scene, double x_m, double y_m) {
  add_rectangle(scene, 0, {x_m, y_m, -50}, {0, 50 - y_m, 0}, {0, 0, 100});
}

scene::CompiledScene glass(double tau, const std::vector<double>& places_m, double y_m = -50) {
  scene::CompiledScene scene = scene_of({0.0});
  scene.materials[0].transmittance = {{0.3, 4.0}, {tau, tau}};
  scene.materials[0].behind.number = RC_SHAPE_plate;
  for (const double x_m : places_m) add_screen(scene, x_m, y_m);
  scene::finish_top_tree(scene);
  return scene;
}

}  // namespace

TEST_CASE("L-04, S29: air next to the telescope in a gate of 15 km") {
  scene::Lidar lidar = sounder();
  lidar.receiver.obscuration_radius_m = 0;
  lidar.transport.overlap = scene::LidarOverlap::exact;
  gate(lidar, 0, 1.5, 10000);
  const auto scene = nothing();
  const auto plan = plan_of(lidar, scene);
  const auto result = one(scene, plan, shot_from(lidar, {0, 0, 0}, {1, 0, 0}));
  const lidar::Stop stop{0.05, 0, 0.5e-3, 0};
  for (const std::size_t bin : {1u, 2u, 3u, 6u, 9u, 12u, 20u, 40u, 60u, 100u, 300u}) {
    const double from = 1.5 * static_cast<double>(bin);
    const double expected = level(plan) * integral(from, from + 1.5, [&](double range) {
                              return lidar::beam_overlap(stop, true, 0.25e-3 * range, range, 0) / (range * range) *
                                     std::exp(-2 * kExtinction * range);
                            });
    CAPTURE(bin);
    CHECK(result.air[bin] ==
          doctest::Approx(expected).epsilon(
              bin < 20 ? 2e-4 : 2e-3));  // posts 1 % apart, eta as R^2; farther: 256 sub-rays at the field's edge
    if (from < 20) CHECK(result.air[bin] / (1.5 * level(plan)) == doctest::Approx(1e-4).epsilon(1e-3));  // (phi / r)^2
  }
}

TEST_CASE("L-04: nothing comes from the blind zone of an obscured pupil, in a gate of 60 km") {
  scene::Lidar lidar = sounder();
  lidar.transport.overlap = scene::LidarOverlap::exact;
  lidar.pulse.half_divergence_rad = 0;
  lidar.transport.subrays = 1;
  gate(lidar, 0, 6, 10000);
  const auto scene = nothing();
  const auto plan = plan_of(lidar, scene);
  const auto result = one(scene, plan, shot_from(lidar, {0, 0, 0}, {1, 0, 0}));
  const lidar::Stop stop{0.05, 0.015, 0.5e-3, 0};
  for (std::size_t bin = 0; bin < 5; ++bin) CHECK(result.air[bin] == 0.0f);  // up to r_o / phi = 30 m
  for (const std::size_t bin : {8u, 10u, 12u, 15u, 20u, 30u, 1000u}) {
    const double from = 6.0 * static_cast<double>(bin);
    const double expected =
        level(plan) * integral(from, from + 6, [&](double range) {
          return lidar::vignetting(stop, range, 0) / (range * range) * std::exp(-2 * kExtinction * range);
        });
    CAPTURE(bin);
    CHECK(result.air[bin] == doctest::Approx(expected).epsilon(1e-3));  // two Gauss points in 6 m at 50 m
  }
}

TEST_CASE("S30: air behind plates has passed each of them twice") {
  scene::Lidar lidar = sounder();
  lidar.pulse.half_divergence_rad = 1e-3;
  lidar.transport.subrays = 1024;
  gate(lidar, 500, 15, 100);
  const auto shot = shot_from(lidar, {0, 0, 0}, {1, 0, 0});
  const auto open = one(nothing(), plan_of(lidar, nothing()), shot);
  constexpr double tau = 0.45;
  const auto whole = glass(tau, {1000}), two = glass(tau, {1000, 1400}), half = glass(tau, {1000}, 0);
  const auto behind_one = one(whole, plan_of(lidar, whole), shot), behind_two = one(two, plan_of(lidar, two), shot),
             beside = one(half, plan_of(lidar, half), shot);
  const auto reference = shoot(two, plan_of(lidar, two), shot).rows.air;
  for (std::size_t bin = 0; bin < 100; ++bin) {
    const double from = 500 + 15.0 * static_cast<double>(bin), to = from + 15;
    if (to < 999) CHECK(behind_two.air[bin] == doctest::Approx(open.air[bin]).epsilon(1e-6));
    if (from > 1001)
      CHECK(behind_one.air[bin] ==
            doctest::Approx(tau * tau * open.air[bin]).epsilon(1e-4));  // 1024 shares added up in float
    if (from > 1401) CHECK(behind_two.air[bin] == doctest::Approx(std::pow(tau, 4) * open.air[bin]).epsilon(1e-4));
    if (from > 1001)
      CHECK(beside.air[bin] ==
            doctest::Approx((0.5 + 0.5 * tau * tau) * open.air[bin]).epsilon(4 * 0.00161));  // 1024 sub-rays, 2.1
    if (to < 999 || (from > 1001 && to < 1399) || from > 1401)
      CHECK(behind_two.air[bin] == doctest::Approx(reference[bin]).epsilon(1e-4));
  }
}

TEST_CASE("L-06, L-08: bins of 0.1 ns at 400 km, air and cloud") {
  scene::Lidar lidar = sounder();
  lidar.pulse.half_divergence_rad = 0;
  lidar.transport.subrays = 1;
  constexpr double kBin_m = 0.5e-10 * kLightSpeed;
  lidar.gate = {2 * 399900.0 / kLightSpeed, 1e-10, 20000};
  for (const lidar::Vec3& way : {lidar::Vec3{1, 0, 0}, {0, 0, -1}, {0.1, 0.05, -0.99}}) {
    const auto plan = plan_of(lidar, nothing());
    const lidar::Vec3 at{0, 0, way[2] < 0 ? 400000.0 : 0.0};
    const auto result = one(nothing(), plan, shot_from(lidar, at, way));
    const double per_height = std::hypot(way[0], way[1], way[2]) / std::abs(way[2]);
    double sum = 0, expected_sum = 0, worst = 0;
    for (std::size_t bin = 0; bin < 20000; ++bin) {
      const double range = 399900 + (static_cast<double>(bin) + 0.5) * kBin_m;
      const double top = way[2] < 0 ? (400000 - 20000) * per_height : 0;  // the air ends at 20 km
      const double expected = level(plan) * kBin_m / (range * range) * std::exp(-2 * kExtinction * (range - top));
      sum += result.air[bin], expected_sum += expected;
      worst = std::max(worst, std::abs(result.air[bin] / expected - 1));
    }
    CHECK(worst <= 1e-5);
    CHECK(sum == doctest::Approx(expected_sum).epsilon(1e-5));
  }
  scene::CompiledScene scene = nothing();
  scene::Volume cloud;
  cloud.name = "cloud";
  cloud.position_m = {0, 0, 0}, cloud.size_m = {1000, 1000, 100};
  cloud.extinction_per_m = 0.01, cloud.lidar_ratio_sr = 50;
  scene.volumes.push_back(cloud);
  lidar.transport.air_return = false;
  const auto plan = hand_plan(lidar, scene);
  const auto result = one(scene, plan, shot_from(lidar, {0, 0, 400000}, {0, 0, -1}));
  double sum = 0, worst = 0, all = 0;
  for (std::size_t bin = 0; bin < 20000; ++bin) {
    const double range = 399900 + (static_cast<double>(bin) + 0.5) * kBin_m, in = range - 399900;
    sum += result.first[bin] * range * range;
    if (bin == 0 || in + kBin_m > 100) continue;  // the cloud's edge is a float: 8 um of a bin's 15 mm
    const double cell = 0.01 * kBin_m,
                 expected = level(plan) / kBackscatter / 50 / (range * range) * std::exp(-0.02 * in) * std::sinh(cell);
    worst = std::max(worst, std::abs(result.first[bin] / expected - 1));
    all += result.first[bin];
  }
  CHECK(all > 0);
  CHECK(worst <= 1e-4);
  CHECK(sum / (level(plan) / kBackscatter) == doctest::Approx((1 - std::exp(-2.0)) / 100).epsilon(2e-5));
}

TEST_CASE("S30: air that is only met on the way is not among the light collected") {
  scene::CompiledScene scene = nothing();
  scene::Volume cloud;
  cloud.name = "cloud";
  cloud.position_m = {1050, 0, -50}, cloud.size_m = {100, 100, 100};
  cloud.extinction_per_m = 0.01, cloud.lidar_ratio_sr = 50;
  scene.volumes.push_back(cloud);
  scene::Lidar lidar = sounder();
  for (const bool returns : {false, true}) {
    lidar.transport.air_return = returns;
    gate(lidar, 900, 1, 150);  // ends within the cloud
    const auto plan = plan_of(lidar, scene, 1e-4, 3e-5);
    const auto result = one(scene, plan, shot_from(lidar, {0, 0, 0}, {1, 0, 0}));
    const auto& ledger = result.ledger[0];
    double bins = 0;
    for (const float x : result.first) bins += x;
    CHECK(bins > 0);
    for (const float x : result.air) bins += x;
    CHECK(result.air.empty() == !returns);
    CHECK(bins / plan.photons[0] + ledger.early + ledger.late + ledger.near ==
          doctest::Approx(ledger.collected).epsilon(5e-6));
  }
}

TEST_CASE("S30, S30: a surface before one pixel darkens the air of that pixel alone") {
  scene::Lidar lidar = sounder();
  lidar.receiver.half_fov_rad = 0;
  lidar.receiver.columns = 4, lidar.receiver.rows = 2;
  lidar.receiver.pixel_pitch_rad = 0.5e-3;
  lidar.pulse.profile = scene::BeamProfile::uniform;
  lidar.pulse.half_divergence_rad = 1e-3;
  lidar.transport.subrays = 1024;
  gate(lidar, 500, 15, 60);
  const auto shot = shot_from(lidar, {0, 0, 0}, {1, 0, 0});
  scene::CompiledScene wall = scene_of({0.3});
  add_screen(wall, 1000, 0.5);  // y > 0.5 mrad: half a field's columns or rows, whichever lie along y
  scene::finish_top_tree(wall);
  const auto open = one(nothing(), plan_of(lidar, nothing()), shot), closed = one(wall, plan_of(lidar, wall), shot);
  int dark = 0, lit = 0;
  for (std::size_t pixel = 0; pixel < 8; ++pixel)
    for (std::size_t bin = 34; bin < 60; ++bin) {
      const float seen = closed.air[pixel * 60 + bin], whole = open.air[pixel * 60 + bin];
      if (seen <= 1e-5f * whole)
        ++dark;
      else if (std::abs(seen / whole - 1) <= 1e-5)
        ++lit;
      CHECK(whole > 0);
    }
  CHECK(dark == 2 * 26);  // one column of two pixels
  CHECK(lit == 6 * 26);
}
