// Device against the LIDAR reference, bin by bin, over a small zoo: every bin within 1e-5 of the pulse's peak bin where
// both follow the same rays.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "host/run/check_lidar.h"
#include "host/lidar/pulse_taps.h"
#include "tests/support/lidar_kit.h"
#include "tests/support/test_scenes.h"

using namespace raycube;
using namespace raycube::test;

namespace {

struct Zoo {
  scene::CompiledScene scene;
  lidar::LidarPlan plan;
  std::vector<lidar::Shot> shots;
};

reference::LidarReport compare(const Zoo& zoo, int replicas = 16) {
  render::LidarRenderer renderer(zoo.scene, {});
  reference::LidarCompareOptions options;
  options.replicas = replicas;
  reference::LidarComparison comparison(zoo.scene, zoo.plan, options);
  std::vector<lidar::ShotResult> results;
  renderer.render(
      zoo.plan, zoo.shots, [&](lidar::ShotResult&& shot) { results.push_back(std::move(shot)); }, true);
  comparison.add(results);
  const reference::LidarReport report = comparison.report();
  MESSAGE(report.text());
  return report;
}

/// Photons that the reference gets from surfaces in the first shot.
double shoot_sum(const Zoo& zoo) {
  const reference::EmbreeScene embree(zoo.scene);
  double sum = 0;
  for (const double bin : reference::reference_shot(zoo.scene, embree, zoo.plan, zoo.shots[0]).rows.first) sum += bin;
  return sum;
}

/// Shots from `at`, spread over directions about a middle one, each with a turn of its footprint.
std::vector<lidar::Shot> fan(const scene::Lidar& lidar, const lidar::Vec3& at, const lidar::Vec3& towards, int count,
                             double spread) {
  std::vector<lidar::Shot> shots;
  for (int i = 0; i < count; ++i) {
    const double x = spread * (2 * unit_random(5, static_cast<std::uint32_t>(i), 0) - 1),
                 y = spread * (2 * unit_random(5, static_cast<std::uint32_t>(i), 1) - 1);
    const lidar::Vec3 place{at[0] + 3 * unit_random(5, static_cast<std::uint32_t>(i), 2), at[1],
                            at[2] + unit_random(5, static_cast<std::uint32_t>(i), 3)};
    shots.push_back(shot_from(lidar, place, {towards[0] + x, towards[1] + y, towards[2]}, i));
  }
  return shots;
}

void holds(const reference::LidarReport& report) {
  for (const std::string& failure : report.failures()) FAIL_CHECK(failure);
  CHECK(report.compared_pulses > 0.8 * static_cast<double>(report.pulses));
}

Zoo over(scene::CompiledScene scene, const scene::Lidar& lidar, int shots, double spread = 0.01) {
  scene::finish_top_tree(scene);
  Zoo zoo{std::move(scene), {}, fan(lidar, {0, 0, 1000}, {0, 0, -1}, shots, spread)};
  zoo.plan = hand_plan(lidar, zoo.scene);
  return zoo;
}

scene::CompiledScene plane(double tilt_rad = 0.3) {
  scene::CompiledScene scene = scene_of({0.3});
  add_plane(scene, 0, {0, 0, 0}, 60, tilt_rad);
  return scene;
}

}  // namespace

TEST_CASE("I8: a tilted plane") { holds(compare(over(plane(), topographic_lidar(), 40))); }

TEST_CASE("I8: a tilted plane, rectangular pulse and vignetting by a narrow field, with air on the way") {
  auto lidar = topographic_lidar();
  lidar.pulse.shape = scene::PulseShape::rectangular;
  lidar.transport.overlap = scene::LidarOverlap::exact;
  lidar.receiver.half_fov_rad = 0.2e-3;
  Zoo zoo = over(plane(), lidar, 40);
  set_air(zoo.plan, 2e-4, 0, -50, 1500);
  holds(compare(zoo));
}

TEST_CASE("I8: the plan's own taps: a tabulated pulse with a tail, a Gaussian as short as a bin") {
  auto lidar = topographic_lidar();
  lidar.pulse.shape = scene::PulseShape::tabulated;
  lidar.pulse.shape_time_s = {-3e-9, -1e-9, 0, 2e-9, 5e-9, 12e-9};
  lidar.pulse.shape_power = {0, 0.6e8, 1.9e8, 1.2e8, 0.3e8, 0};
  double area = 0;
  for (std::size_t i = 1; i < 6; ++i)
    area += 0.5 * (lidar.pulse.shape_power[i] + lidar.pulse.shape_power[i - 1]) *
            (lidar.pulse.shape_time_s[i] - lidar.pulse.shape_time_s[i - 1]);
  for (double& power : lidar.pulse.shape_power) power /= area;
  for (const bool table : {true, false}) {
    if (!table) lidar.pulse.shape = scene::PulseShape::gaussian, lidar.pulse.fwhm_s = lidar.gate.bin_s;
    Zoo zoo = over(plane(), lidar, 20);
    zoo.plan.taps = lidar::make_taps(lidar.pulse, lidar.gate.bin_s);
    const auto report = compare(zoo);
    holds(report);
    CHECK(report.worst < 3e-5);  // with what rounding of paths does to the short one
  }
}

TEST_CASE("I8: terrain") {
  scene::CompiledScene scene = scene_of({0.25});
  scene::append_instance(scene, scene::append_mesh(scene, "terrain", terrain(64, 120)), kIdentity, 0);
  holds(compare(over(std::move(scene), topographic_lidar(), 40, 0.03)));
}

TEST_CASE("I8: a crown of leaves, placed five times, over the ground") {
  scene::CompiledScene scene = scene_of({0.45, 0.2});
  scene.materials[0].transmittance = {{0.3, 4.0}, {0.4, 0.4}};
  const auto crown_mesh = scene::append_mesh(scene, "crown", crown(400, 0.2, 2, 3));
  for (std::uint32_t i = 0; i < 5; ++i)
    scene::append_instance(scene, crown_mesh, placement(i, 0.1 * i, 1 + 0.1 * i, 3.0 * i - 6, 1.0 * i, 4), i);
  add_plane(scene, 1, {0, 0, 0}, 60);
  auto lidar = topographic_lidar();
  lidar.pulse.half_divergence_rad = 1e-3;
  Zoo zoo = over(std::move(scene), lidar, 60, 0.006);
  const auto report = compare(zoo);
  for (const std::string& failure : report.failures()) FAIL_CHECK(failure);
  CHECK(report.compared_pulses > 30);
}

TEST_CASE("I8: plates over the ground") {
  scene::CompiledScene scene = scene_of({0.4, 0.2});
  scene.materials[0].transmittance = {{0.3, 4.0}, {0.5, 0.5}};
  scene.materials[0].behind.number = RC_SHAPE_plate;
  for (int i = 0; i < 6; ++i) add_rectangle(scene, 0, {-20.0 + 7 * i, -30, 2.0 + i}, {12, 0, 0.5}, {0, 60, 0});
  add_plane(scene, 1, {0, 0, 0}, 60);
  holds(compare(over(std::move(scene), topographic_lidar(), 40, 0.02)));
}

TEST_CASE("I8: gloss, seen from another place") {
  scene::CompiledScene scene = plane(0);
  scene.materials[0].gloss = {RC_SHAPE_gloss, {0.3, 0.04}};
  add_plane(scene, 0, {4, 0, 5}, 1);
  Zoo zoo = over(std::move(scene), topographic_lidar(), 40);
  for (lidar::Shot& shot : zoo.shots) place_pupil(shot, {200, 30, 950}, {-200, -30, -950});
  holds(compare(zoo));
}

TEST_CASE("I8: an array lit by one beam, from both ends") {
  auto lidar = topographic_lidar();
  lidar.receiver.half_fov_rad = 0;
  lidar.receiver.columns = 5, lidar.receiver.rows = 3;  // odd: the beam's axis lies on no edge
  lidar.receiver.pixel_pitch_rad = 0.15e-3;
  holds(compare(over(plane(), lidar, 30)));
  lidar.transport.sampling = scene::LidarSampling::receiver;
  lidar.transport.subrays = 16;
  holds(compare(over(plane(), lidar, 30)));
  lidar.pulse.profile = scene::BeamProfile::uniform;
  lidar.pulse.half_divergence_rad = 8e-3;
  holds(compare(over(plane(), lidar, 30)));
}

TEST_CASE("I8: two lines of several nodes") {
  auto lidar = topographic_lidar();
  lidar.pulse.lines = {{"on", 1.064, 0, 100e-6}, {"off", 1.07, 0, 50e-6}};
  Zoo zoo = over(plane(), lidar, 20);
  zoo.plan.nodes = {{0, 1.063, 0.25}, {0, 1.064, 0.5}, {0, 1.065, 0.25}, {1, 1.07, 1}};
  zoo.plan.first_node = {0, 3, 4};
  set_air(zoo.plan, 1e-4, 0, -50, 800);
  for (std::size_t node = 0; node < 4; ++node)
    for (std::size_t i = 0; i < 33; ++i) zoo.plan.air.depth[node * 33 + i] *= 1 + 2.0 * static_cast<double>(node == 1);
  holds(compare(zoo));
}

namespace {

scene::Volume gas(scene::Volume::Shape shape) {
  scene::Volume volume;
  volume.shape = shape, volume.name = volume.gas = "CH4";
  volume.position_m = {0, 0, 5}, volume.size_m = {12, 14, 9}, volume.yaw_deg = 25;
  volume.concentration_ppm = 50;
  volume.cells = {3, 4, 5};
  for (std::uint32_t i = 0; i < 60; ++i) volume.values.push_back(static_cast<float>(2 * unit_random(9, i, 0)));
  if (shape == scene::Volume::Shape::plume) {
    volume.position_m = {2, -40, 0}, volume.yaw_deg = 3;
    volume.source_g_s = 2, volume.wind_m_s = 2, volume.release_height_m = 3;
  }
  return volume;
}

}  // namespace

TEST_CASE("I8: gas on the way: box, grid and plume") {
  for (const auto shape : {scene::Volume::Shape::box, scene::Volume::Shape::grid, scene::Volume::Shape::plume}) {
    scene::CompiledScene scene = plane();
    scene.volumes = {gas(shape)};
    auto lidar = topographic_lidar();
    lidar.transport.subrays = 64;
    Zoo zoo = over(std::move(scene), lidar, 20, 0.006);
    zoo.plan.cross_section_cm2 = {1.06e-18};
    const auto clear = [&] {
      Zoo without = zoo;
      without.plan.cross_section_cm2 = {0};
      return shoot_sum(without);
    }();
    CHECK(shoot_sum(zoo) < 0.9 * clear);  // there is something to be right about
    for (const bool apart : {false, true}) {
      if (apart)
        for (lidar::Shot& shot : zoo.shots)
          place_pupil(shot, {shot.pupil_m[0] + 0.3, shot.pupil_m[1], shot.pupil_m[2]}, shot.pupil_axis);
      holds(compare(zoo));
    }
  }
}

TEST_CASE("I8: air and a cloud of particles send light back") {
  scene::CompiledScene scene = plane(0);
  scene::Volume cloud = gas(scene::Volume::Shape::box);
  cloud.gas.clear(), cloud.concentration_ppm = 0;
  cloud.extinction_per_m = 0.02, cloud.lidar_ratio_sr = 20;
  cloud.position_m = {0, 0, 20};
  scene.volumes = {cloud};
  auto lidar = topographic_lidar();
  lidar.transport.subrays = 32;
  lidar.transport.air_return = true;
  Zoo zoo = over(std::move(scene), lidar, 3, 0.002);
  set_air(zoo.plan, 1e-4, 2e-6, -50, 1500);
  const auto report = compare(zoo);
  holds(report);
  CHECK(report.has_air);
}

TEST_CASE("I8: many bounces in a corner, on the same draws and on others") {
  scene::CompiledScene scene = scene_of({0.5, 0.4});
  add_corner(scene, 0, 1, 20, 20, 20);
  auto lidar = topographic_lidar();
  lidar.pulse.half_divergence_rad = 2e-3;
  lidar.transport.max_bounces = 4;
  lidar.transport.subrays = 512;
  scene::finish_top_tree(scene);
  Zoo zoo{std::move(scene), {}, fan(lidar, {715, 0, 707}, {-1, 0, -1}, 30, 0.002)};
  zoo.plan = hand_plan(lidar, zoo.scene);
  const auto report = compare(zoo);
  holds(report);
  CHECK(report.has_scattered);
  CHECK(report.scattered.same_draws > 0.8 * static_cast<double>(report.pulses));
  CHECK(report.scattered.groups > 3);
}

TEST_CASE("I8: scattered light among leaves and plates, two lines, on the same draws") {
  scene::CompiledScene scene = scene_of({0.45, 0.3, 0.2});
  scene.materials[0].transmittance = {{1.0, 1.2}, {0.4, 0.2}};
  scene.materials[1].transmittance = {{0.3, 4.0}, {0.5, 0.5}};
  scene.materials[1].behind.number = RC_SHAPE_plate;
  const auto crown_mesh = scene::append_mesh(scene, "crown", crown(300, 0.3, 2, 3));
  for (std::uint32_t i = 0; i < 4; ++i)
    scene::append_instance(scene, crown_mesh, placement(i, 0.1 * i, 1 + 0.1 * i, 3.0 * i - 5, 1.0 * i, 5), i);
  add_rectangle(scene, 1, {-20, -20, 2}, {40, 0, 0.5}, {0, 40, 0});
  add_plane(scene, 2, {0, 0, 0}, 60);
  auto lidar = topographic_lidar();
  lidar.pulse.lines = {{"a", 1.064, 0, 100e-6}, {"b", 1.15, 0, 100e-6}};
  lidar.pulse.half_divergence_rad = 2e-3;
  lidar.transport.max_bounces = 5;
  lidar.transport.subrays = 128;
  Zoo zoo = over(std::move(scene), lidar, 24, 0.004);
  set_air(zoo.plan, 1e-4, 0, -50, 1500);
  const auto report = compare(zoo);
  for (const std::string& failure : report.failures()) FAIL_CHECK(failure);
  CHECK(report.compared_pulses > 12);
  // Paths of five bounces meet thousands of small leaves; one that passes an edge on the other side changes its pulse's
  // bins.
  CHECK(report.scattered.same_draws > 0.5 * static_cast<double>(report.pulses));
  CHECK(report.scattered.groups > 3);
}

TEST_CASE("L-29: terrain from 400 km, bins of 0.1 ns, and from 20 km with an exit of its own size") {
  for (const double range_m : {400e3, 20e3}) {
    scene::CompiledScene scene = scene_of({0.25});
    scene::append_instance(scene, scene::append_mesh(scene, "terrain", terrain(64, 120)), kIdentity, 0);
    auto lidar = topographic_lidar();
    lidar.pulse.half_divergence_rad = 10 / range_m;
    lidar.pulse.fwhm_s = 2e-9;
    lidar.gate = {2 * (range_m - 20) / kLightSpeed, 0.1e-9, 3000};
    if (range_m < 1e5) lidar.pulse.exit_radius_m = 2;
    scene::finish_top_tree(scene);
    Zoo zoo{std::move(scene), {}, fan(lidar, {0, 0, range_m}, {0, 0, -1}, 15, 20 / range_m)};
    zoo.plan = hand_plan(lidar, zoo.scene);
    CHECK(zoo.plan.footprint.exit_a.empty() == (range_m > 1e5));
    holds(compare(zoo));
  }
}

TEST_CASE("I8: the comparison finds what it is for") {
  scene::CompiledScene scene = scene_of({0.5, 0.4});
  add_corner(scene, 0, 1, 20, 20, 20);
  auto lidar = topographic_lidar();
  lidar.pulse.half_divergence_rad = 2e-3;
  lidar.transport.max_bounces = 2;
  scene::finish_top_tree(scene);
  Zoo zoo{std::move(scene), {}, fan(lidar, {715, 0, 707}, {-1, 0, -1}, 10, 0.002)};
  zoo.plan = hand_plan(lidar, zoo.scene);
  render::LidarRenderer renderer(zoo.scene, {});
  std::vector<lidar::ShotResult> good;
  renderer.render(
      zoo.plan, zoo.shots, [&](lidar::ShotResult&& shot) { good.push_back(std::move(shot)); }, true);
  const auto failures = [&](const std::function<void(std::vector<lidar::ShotResult>&)>& spoil) {
    std::vector<lidar::ShotResult> results = good;
    spoil(results);
    reference::LidarComparison comparison(zoo.scene, zoo.plan, {});
    comparison.add(results);
    std::string all;
    for (const auto& failure : comparison.report().failures()) all += failure + "\n";
    return all;
  };
  CHECK(failures([](auto&) {}).empty());
  CHECK(failures([](auto& r) {
          *std::max_element(r[3].first.begin(), r[3].first.end()) *= 1.00003f;
        }).find("1 pulse differs by more than 1e-05") == 0);
  CHECK(failures([](auto& r) {
          r[2].hits[40].primitive ^= 1;
        }).find("first hits differ without explanation, the first in pulse 2, ray 40") != std::string::npos);
  CHECK(failures([](auto& r) { r[0].ledger[0].absorbed += 2e-6; }).find("from closed") != std::string::npos);
  CHECK(failures([](auto& r) {
          for (auto& shot : r)
            for (float& bin : shot.multiple) bin *= 1.5f;
        }).find("light scattered more than once is 1.") != std::string::npos);
  CHECK(failures([](auto& r) { r.clear(); }).find("no pulse was compared") == 0);
}
