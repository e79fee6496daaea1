// What stands behind a return: closed forms over a plane whose hits are given.
#include <doctest/doctest.h>

#include <cmath>

#include "host/lidar/make_lidar_plan.h"
#include "host/lidar/return_truth.h"
#include "tests/support/lidar_kit.h"

using namespace raycube;

namespace {

lidar::ShotResult hits_everywhere(const lidar::LidarPlan& plan, const lidar::Shot& shot) {
  lidar::ShotResult result;
  result.shot = shot;
  result.hits.assign(plan.footprint.a.size() * static_cast<std::size_t>(plan.pixels()), {0, 0});
  return result;
}

std::vector<lidar::ReturnTruth> truth_of(const scene::CompiledScene& scene, const lidar::LidarPlan& plan,
                                         const lidar::ShotResult& result, int pixel, int line,
                                         const std::vector<lidar::Echo>& echoes) {
  return lidar::return_truth(scene, lidar::flatten_volumes(scene.volumes), plan, result, pixel, line, echoes);
}

lidar::Echo echo_at(double range_m) {
  lidar::Echo echo;
  echo.range_m = range_m;
  return echo;
}

scene::CompiledScene plane_of(double reflectance, double tilt_rad) {
  scene::CompiledScene scene = test::scene_of({reflectance});
  test::add_plane(scene, 0, {0, 0, 0}, 50, tilt_rad);
  scene::finish_top_tree(scene);
  return scene;
}

}  // namespace

TEST_CASE("L-01: truth of a return from a plane: range, photo-electrons, incidence, transmission") {
  scene::CompiledScene scene = test::scene_of({0.3});
  const double tilt = M_PI / 6;
  test::add_plane(scene, 0, {0, 0, 0}, 50, tilt);
  scene::finish_top_tree(scene);
  scene::Lidar spec = test::topographic_lidar();
  spec.receiver.quantum_efficiency = 0.3;
  auto plan = test::hand_plan(spec, scene);
  test::set_air(plan, 1e-4, 0, -100, 1100);
  const auto shot = test::shot_from(spec, {0, 0, 1000}, {0, 0, -1});
  lidar::Echo near, far;
  near.range_m = 1000.2, far.range_m = 1010;
  const auto truth = truth_of(scene, plan, hits_everywhere(plan, shot), 0, 0, {near, far});
  // A sub-ray counts only within the pulse of the echo; here all do, at half a footprint of 0.25 m times tan 30
  // degrees.
  CHECK(truth[0].subray_share == doctest::Approx(1));
  CHECK(truth[0].range_m == doctest::Approx(1000).epsilon(2e-6));
  CHECK(truth[0].expected_pe ==
        doctest::Approx(34992.34561).epsilon(2e-5));  // finite footprint: order (0.25 m / 1 km)^2 and its slope
  CHECK(truth[0].incidence_deg == doctest::Approx(30).epsilon(1e-3));
  CHECK(truth[0].transmission_2way == doctest::Approx(0.8187307531).epsilon(2e-6));
  CHECK(truth[0].order == 1);
  CHECK(truth[0].material == 0);
  CHECK(truth[1].order == 0);
  CHECK(std::isnan(truth[1].range_m));
}

TEST_CASE("L-02: truth of a pixel's samples comes from the beam's fluence, not from what was measured") {
  const auto scene = plane_of(0.10, 0);
  scene::Lidar spec = test::flash_lidar();
  lidar::Echo measured = echo_at(2000);
  measured.energy_pe = 123;
  for (const bool tangent : {false, true}) {
    spec.receiver.tangent_aperture = tangent;
    const auto plan = test::hand_plan(spec, scene);
    const auto shot = test::shot_from(spec, {0, 0, 2000}, {0, 0, -1});
    for (int pixel = 0; pixel < 9; ++pixel) {
      const auto truth = truth_of(scene, plan, hits_everywhere(plan, shot), pixel, 0, {measured});
      CHECK(truth[0].expected_pe == doctest::Approx(tangent ? 7.345289 : 7.804369).epsilon(2e-6));
      CHECK(truth[0].subray_share == 1);
      CHECK(truth[0].order == 1);
    }
  }
}

TEST_CASE("S34: truth of sub-rays into an array is the pixel's own and agrees with samples of its pixels") {
  const auto scene = plane_of(0.10, 0.2);
  scene::Lidar spec = test::flash_lidar();
  spec.receiver.columns = 4, spec.receiver.rows = 2, spec.receiver.pixel_pitch_rad = 2e-3;
  spec.pulse.profile = scene::BeamProfile::gaussian;
  spec.transport.subrays = 4096;
  const auto shot = test::shot_from(spec, {0, 0, 2000}, {0, 0, -1});
  std::vector<double> samples, rays;
  double share = 0;
  for (const auto sampling : {scene::LidarSampling::receiver, scene::LidarSampling::transmitter}) {
    spec.transport.sampling = sampling;
    const auto plan = test::hand_plan(spec, scene);
    for (int pixel = 0; pixel < 8; ++pixel) {
      // Pixels see the tilted plane at ranges of their own, over half a metre each: echoes every 0.1 m take all
      // sub-rays.
      std::vector<lidar::Echo> echoes;
      for (int i = -40; i <= 40; ++i) echoes.push_back(echo_at(2000 + 0.1 * i));
      double sum = 0;
      for (const auto& truth : truth_of(scene, plan, hits_everywhere(plan, shot), pixel, 0, echoes)) {
        sum += static_cast<double>(truth.expected_pe);
        if (sampling == scene::LidarSampling::transmitter) share += static_cast<double>(truth.subray_share);
      }
      (sampling == scene::LidarSampling::receiver ? samples : rays).push_back(sum);
    }
  }
  // Beyond the array: 1 - erf(sqrt 2 4/8) erf(sqrt 2 2/8) of a Gaussian of 1/e2 half angle 8 mrad.
  CHECK(share == doctest::Approx(std::erf(std::sqrt(2.0) / 2) * std::erf(std::sqrt(2.0) / 4)).epsilon(5e-3));
  // Sub-rays on the pixels' rims: 4096 x 3 % of the beam a pixel, a spiral's discrepancy.
  for (std::size_t pixel = 0; pixel < 8; ++pixel) CHECK(rays[pixel] == doctest::Approx(samples[pixel]).epsilon(0.03));
}

TEST_CASE("L-09: truth's transmission is averaged over the line after the exponential, gas included") {
  for (const auto& [fwhm_cm, on] : {std::pair{0.0, 5.188089e-3}, {0.05, 1.061674e-2}, {0.10, 3.897977e-2}}) {
    scene::CompiledScene scene = plane_of(0.3, 0);
    scene::Volume gas;
    gas.name = "gas", gas.gas = "synthetic";
    gas.position_m = {0, 0, 100}, gas.size_m = {50, 50, 10};
    gas.concentration_ppm = 100;  // 1000 ppm m down, and again up
    scene.volumes.push_back(gas);
    const double centre_cm = 1e4 / 3.3, strength = 2.0e-19, half_width_cm = 0.06, centre_um = 1e4 / centre_cm;
    scene::Lidar spec = test::topographic_lidar();
    spec.pulse.half_divergence_rad = 1e-6, spec.transport.subrays = 1, spec.transport.line_nodes = 64;
    spec.pulse.lines = {{"on", centre_um, fwhm_cm * centre_um * centre_um / 1e4, 1e-4}};
    auto plan = test::hand_plan(spec, scene);
    plan.nodes = lidar::make_nodes(spec);
    plan.first_node = {0, static_cast<int>(plan.nodes.size())};
    plan.cross_section_cm2.clear();
    for (const auto& node : plan.nodes) {
      const double away_cm = 1e4 / node.wavelength_um - centre_cm;
      plan.cross_section_cm2.push_back(strength * half_width_cm /
                                       (M_PI * (away_cm * away_cm + half_width_cm * half_width_cm)));
    }
    const auto shot = test::shot_from(spec, {0, 0, 1000}, {0, 0, -1});
    // The specification's table (6.3); the column in single precision, depth 5.3 (2e-6); even in wavelength, not in
    // wavenumber (2e-5).
    CHECK(truth_of(scene, plan, hits_everywhere(plan, shot), 0, 0, {echo_at(1000)})[0].transmission_2way ==
          doctest::Approx(on).epsilon(2e-5));
  }
}

TEST_CASE("truth of a tabulated pulse: an echo stands where its power's centroid does") {
  const auto scene = plane_of(0.3, 0);
  scene::Lidar spec = test::topographic_lidar();
  spec.pulse.shape = scene::PulseShape::tabulated, spec.pulse.fwhm_s = 0;
  spec.pulse.shape_time_s = {1e-9, 2e-9, 4e-9},
  spec.pulse.shape_power = {0, 2 / 3e-9, 0};  // centroid 7/3 ns, standard deviation 0.62 ns
  auto plan = test::hand_plan(test::topographic_lidar(), scene);
  plan.lidar = spec;
  const auto shot = test::shot_from(spec, {0, 0, 1000}, {0, 0, -1});
  const double centre_m = 1000 + 0.5 * test::kLightSpeed * 7e-9 / 3;
  const auto found = [&](double range_m) {
    return truth_of(scene, plan, hits_everywhere(plan, shot), 0, 0, {echo_at(range_m)})[0].order;
  };
  // Window: c / 2 (2.355 x 0.6236 ns + 1 ns) = 0.370 m.
  for (const double off : {-0.36, 0.0, 0.36}) CHECK(found(centre_m + off) == 1);
  for (const double off : {-0.38, 0.38}) CHECK(found(centre_m + off) == 0);
}

TEST_CASE(
    "a strong return fires a Geiger cell before its power has come: the event is the surface's, dark counts there are "
    "not") {
  const auto scene = plane_of(0.3, 0);
  scene::Lidar spec = test::topographic_lidar();
  spec.detector.mode = scene::DetectorMode::geiger;
  spec.detector.dark_rate_hz = 1e6;
  const auto plan = test::hand_plan(spec, scene);
  const auto shot = test::shot_from(spec, {0, 0, 1000}, {0, 0, -1});
  auto result = hits_everywhere(plan, shot);
  const double arrives_s = 2000 / test::kLightSpeed,
               early_s = -4 * spec.pulse.fwhm_s / 2.3548;  // four standard deviations
  const auto bin = static_cast<std::size_t>((arrives_s + early_s - spec.gate.start_s) / spec.gate.bin_s);
  REQUIRE(bin < static_cast<std::size_t>(spec.gate.bins));
  result.first.assign(static_cast<std::size_t>(spec.gate.bins), 0.0f);
  lidar::Echo echo = echo_at(1000 + 0.5 * test::kLightSpeed * early_s);
  echo.time_s = arrives_s + early_s;
  const auto order = [&](float photons) {
    result.first[bin] = photons;
    return truth_of(scene, plan, result, 0, 0, {echo})[0].order;
  };
  // Dark counts in three bins: 3e-3 for a bin of 1 ns.
  const double dark = 3 * spec.detector.dark_rate_hz * spec.gate.bin_s / spec.receiver.quantum_efficiency;
  CHECK(order(static_cast<float>(1.01 * dark)) == 1);
  CHECK(order(static_cast<float>(0.99 * dark)) == 0);
}

TEST_CASE("range is half the path: the apparent point of a bistatic return lies on the beam, its two legs add up") {
  scene::Lidar spec = test::topographic_lidar();
  scene::CompiledScene scene = test::scene_of({0.3});
  const auto plan = test::hand_plan(spec, scene);
  auto shot = test::shot_from(spec, {3, 4, 500}, {0.1, 0.2, -1});
  test::place_pupil(shot, {60, -20, 480}, {0, 0, -1});
  for (const double range : {100.0, 510.0, 4000.0}) {
    const auto p = lidar::apparent_point(plan, shot, 0, range);
    double there = 0, home = 0, along = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      there += std::pow(p[i] - shot.exit_m[i], 2), home += std::pow(p[i] - shot.pupil_m[i], 2);
      along += (p[i] - shot.exit_m[i]) * shot.exit_axis[i];
    }
    CHECK(std::sqrt(there) + std::sqrt(home) == doctest::Approx(2 * range).epsilon(1e-12));
    CHECK(std::sqrt(there) == doctest::Approx(along).epsilon(1e-12));
  }
}
