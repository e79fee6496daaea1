// Light that air and particles send back on the way: closed forms of the specification (L-06, L-07, L-08), shadows of
// surfaces, overlap.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "host/lidar/overlap.h"
#include "tests/support/lidar_device.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;
using namespace raycube::test;

namespace {

constexpr double kExtinction = 1.132845938e-4, kBackscatter = 3.585731583e-6;

scene::Lidar air_lidar() {
  scene::Lidar lidar = topographic_lidar();
  lidar.pulse.lines = {{"green", 0.532, 0, 20e-3}};
  lidar.pulse.fwhm_s = 0;
  lidar.receiver.aperture_radius_m = 0.10;
  lidar.receiver.obscuration_radius_m = 0;
  lidar.receiver.efficiency = 0.4;
  lidar.receiver.quantum_efficiency = 0.2;
  lidar.transport.air_return = true;
  return lidar;
}

scene::CompiledScene nothing() {
  scene::CompiledScene scene = scene_of({0.3});
  scene::finish_top_tree(scene);
  return scene;
}

lidar::ShotResult one(const scene::Lidar& lidar, const scene::CompiledScene& scene, const lidar::Shot& shot,
                      double extinction = kExtinction, double backscatter = kBackscatter) {
  lidar::LidarPlan plan = hand_plan(lidar, scene);
  set_air(plan, extinction, backscatter, -20000, 20000);
  return render_shots(scene, plan, {shot}).at(0);
}

void gate(scene::Lidar& lidar, double from_m, double bin_m, int bins) {
  lidar.gate = {2 * from_m / kLightSpeed, 2 * bin_m / kLightSpeed, bins};
}

}  // namespace

TEST_CASE("L-06: a homogeneous atmosphere, expected photo-electrons by exponential integrals") {
  scene::Lidar lidar = air_lidar();
  const auto level = shot_from(lidar, {0, 0, 0}, {1, 0, 0});
  for (const auto& [from_m, bin_m, expected] : {std::array{1000.0, 15.0, 5109.970564},
                                                {3000.0, 15.0, 364.4835546},
                                                {5000.0, 15.0, 83.56984206},
                                                {10000.0, 15.0, 6.739853574}}) {
    gate(lidar, from_m, bin_m, 4);
    CHECK(one(lidar, nothing(), level).air[0] * 0.2 == doctest::Approx(expected).epsilon(3e-6));
  }
  gate(lidar, 1000, 150, 2);
  CHECK(one(lidar, nothing(), level).air[0] * 0.2 ==
        doctest::Approx(44453.43271).epsilon(2e-5));  // two Gauss cells of a 150 m bin: 120 h^4 / (16 4320 R^4)
}

TEST_CASE("L-07: the logarithm of N R^2 falls by twice the extinction, up and down as well") {
  scene::Lidar lidar = air_lidar();
  gate(lidar, 500, 15, 300);
  for (const lidar::Vec3& way : {lidar::Vec3{1, 0, 0}, {0.3, 0, 0.7}, {0, 0.1, -1}}) {
    const auto result = one(lidar, nothing(), shot_from(lidar, {0, 0, 1000}, way));
    const auto level = [&](int bin) {
      const double near = 500 + 15.0 * bin, far = near + 15;
      return std::log(result.air[static_cast<std::size_t>(bin)] / (1 / near - 1 / far));
    };
    CHECK((level(20) - level(280)) / (260 * 15.0) ==
          doctest::Approx(2 * kExtinction).epsilon(1e-4));  // curvature of exp within a bin
    const double bins = moments(result.air).sum;
    CHECK(bins / hand_plan(lidar, nothing()).photons[0] + result.ledger[0].early + result.ledger[0].late ==
          doctest::Approx(result.ledger[0].collected).epsilon(5e-6));
  }
}

TEST_CASE("L-08: a thick cloud's attenuated backscatter integrates to (1 - exp(-2 tau)) / 2S") {
  scene::CompiledScene scene = nothing();
  scene::Volume cloud;
  cloud.name = "cloud";
  cloud.position_m = {1050, 0, -50};
  cloud.size_m = {100, 100, 100};
  cloud.extinction_per_m = 0.01;
  cloud.lidar_ratio_sr = 50;
  scene.volumes.push_back(cloud);
  scene::Lidar lidar = air_lidar();
  lidar.transport.air_return = false;
  gate(lidar, 900, 1, 300);
  const auto result = render_shots(scene, hand_plan(lidar, scene), {shot_from(lidar, {0, 0, 0}, {1, 0, 0})}).at(0);
  REQUIRE(result.air.empty());
  double sum = 0;
  for (std::size_t i = 0; i < result.first.size(); ++i)
    sum += result.first[i] * std::pow(900 + static_cast<double>(i) + 0.5, 2);
  const double unit = hand_plan(lidar, scene).photons[0] * 0.4 * M_PI * 0.01;
  CHECK(sum / unit == doctest::Approx(0.008646647).epsilon(1e-5));
  CHECK(*std::max_element(result.first.begin(), result.first.begin() + 100) == 0.0f);
}

TEST_CASE("S30: air behind a surface is dark, a half target hides half") {
  scene::Lidar lidar = air_lidar();
  lidar.pulse.half_divergence_rad = 1e-3;
  lidar.transport.subrays = 1024;
  gate(lidar, 500, 15, 100);
  scene::CompiledScene wall = scene_of({0.3}), half = scene_of({0.3});
  add_rectangle(wall, 0, {1000, -50, -50}, {0, 100, 0}, {0, 0, 100});
  add_rectangle(half, 0, {1000, 0, -50}, {0, 50, 0}, {0, 0, 100});
  scene::finish_top_tree(wall);
  scene::finish_top_tree(half);
  const auto level = shot_from(lidar, {0, 0, 0}, {1, 0, 0});
  const auto open = one(lidar, nothing(), level), closed = one(lidar, wall, level), split = one(lidar, half, level);
  for (std::size_t i = 0; i < 100; ++i) {
    const double from_m = 500 + 15.0 * static_cast<double>(i);
    if (from_m + 15 < 999) CHECK(closed.air[i] == doctest::Approx(open.air[i]).epsilon(1e-6));
    if (from_m > 1001) CHECK(closed.air[i] <= 1e-4 * open.air[i]);
    if (from_m > 1001)
      CHECK(split.air[i] / open.air[i] == doctest::Approx(0.5).epsilon(4 * 0.00161));  // 1024 sub-rays, 2.1
  }
  const double part = (1000 - (500 + 15 * 33)) / 15.0;  // the wall stands in bin 33
  CHECK(closed.air[33] / open.air[33] == doctest::Approx(part).epsilon(2e-3));
}

TEST_CASE("S29: the air's return carries the beam's overlap with the field") {
  scene::Lidar lidar = air_lidar();
  lidar.receiver.half_fov_rad = 0.2e-3;
  lidar.pulse.half_divergence_rad = 0.1e-3;
  lidar.pulse.exit_radius_m = 0.010;
  lidar.transport.subrays = 1024;
  gate(lidar, 400, 5, 50);
  auto shot = shot_from(lidar, {0, 1.0, 0}, {500, -1.0, 0});
  place_pupil(shot, {0, 0, 0}, {1, 0, 0});
  lidar.transport.overlap = scene::LidarOverlap::exact;
  const auto seen = one(lidar, nothing(), shot);
  lidar.transport.overlap = scene::LidarOverlap::off;
  const auto all = one(lidar, nothing(), shot);
  const lidar::Stop stop{0.10, 0, 0.2e-3, 0};
  for (const std::size_t bin : {4u, 10u, 15u, 20u, 25u, 30u, 40u}) {
    const double range = 402.5 + 5.0 * static_cast<double>(bin), w = std::hypot(0.010, 0.1e-3 * range);
    const double expected = lidar::beam_overlap(stop, true, w, range, std::abs(1.0 - range / 500));
    CHECK(std::abs(seen.air[bin] / all.air[bin] - expected) <=
          4 * 0.00161);  // 1024 sub-rays against the integral: 0.16 % rms of an edge, two edges
  }
}

TEST_CASE("S30: samples of a pixel see the same air as sub-rays into it") {
  scene::Lidar lidar = air_lidar();
  lidar.receiver.columns = 2;
  lidar.receiver.pixel_pitch_rad = 2e-3;
  lidar.pulse.half_divergence_rad = 1e-3;
  lidar.transport.subrays = 1024;
  gate(lidar, 500, 15, 40);
  auto shot = shot_from(lidar, {0, 0, 0}, {1, 0.0005, 0});
  place_pupil(shot, {0, 0.2, 0}, {1, 0, 0});
  const auto rays = one(lidar, nothing(), shot);
  lidar.transport.sampling = scene::LidarSampling::receiver;
  const auto samples = one(lidar, nothing(), shot);
  for (std::size_t pixel = 0; pixel < 2; ++pixel) {
    const double a = moments({rays.air.begin() + pixel * 40, rays.air.begin() + pixel * 40 + 40}).sum;
    const double b = moments({samples.air.begin() + pixel * 40, samples.air.begin() + pixel * 40 + 40}).sum;
    CHECK(a > 0);
    CHECK(b == doctest::Approx(a).epsilon(0.02));  // 1024 sub-rays against the edges of the array
  }
}
