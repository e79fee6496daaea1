// The LIDAR reference in air, gas and cloud against closed forms.
#include <doctest/doctest.h>

#include <cmath>

#include "host/reference/lidar_path.h"
#include "tests/oracle/lidar_reference_kit.h"

using namespace raycube;
using namespace raycube::test;

namespace {

scene::Lidar sounder() {
  scene::Lidar lidar = topographic_lidar();
  lidar.transport.subrays = 1;
  lidar.transport.air_return = true;
  lidar.pulse.fwhm_s = 0;
  lidar.pulse.half_divergence_rad = 0;
  return lidar;
}

scene::Volume box_of(double ppm, const std::array<double, 3>& position, const std::array<double, 3>& size) {
  scene::Volume volume;
  volume.name = "box", volume.gas = "CH4";
  volume.position_m = position, volume.size_m = size;
  volume.concentration_ppm = ppm;
  return volume;
}

reference::Straight between(const glm::dvec3& from, const glm::dvec3& to) {
  const glm::dvec3 d = to - from;
  return {from, d / std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z), std::sqrt(d.x * d.x + d.y * d.y + d.z * d.z)};
}

}  // namespace

TEST_CASE("L-06: return of homogeneous air, bin by bin") {
  scene::CompiledScene scene = scene_of({0.3});
  scene::finish_top_tree(scene);
  auto lidar = sounder();
  lidar.pulse.lines = {{"green", 0.532, 0, 20e-3}};
  lidar.receiver.aperture_radius_m = 0.1, lidar.receiver.obscuration_radius_m = 0, lidar.receiver.efficiency = 0.4;
  // Bins of 15 m, the first at 1 km.
  lidar.gate = {2000 / kLightSpeed, 30 / kLightSpeed, 700};
  auto plan = hand_plan(lidar, scene);
  set_air(plan, 1.132845938e-4, 3.585731583e-6, 0, 20000);
  const auto result = shoot(scene, plan, shot_from(lidar, {0, 0, 5}, {1, 0, 0}));
  // Quantum efficiency 0.2; steps h of 2 m at R = 1 km: the midpoint rule is off by (h / R)^2 6 / 24.
  const auto pe = [&](int km) { return 0.2 * result.rows.air[static_cast<std::size_t>((km - 1) * 1000) / 15]; };
  CHECK(pe(1) == doctest::Approx(5109.970564).epsilon(2e-6));
  // Of the four ranges only 1 and 10 km lie on an edge of these bins.
  CHECK(pe(10) == doctest::Approx(6.739853574).epsilon(2e-6));
}

TEST_CASE("L-08: an optically thick cloud returns (1 - exp(-2 tau)) / (2 S)") {
  scene::CompiledScene scene = scene_of({0.3});
  scene::finish_top_tree(scene);
  scene::Volume cloud;
  cloud.name = "cloud";
  cloud.position_m = {100, 0, -50}, cloud.size_m = {80, 100, 100};
  cloud.extinction_per_m = 1.0 / 80, cloud.lidar_ratio_sr = 50;
  scene.volumes = {cloud};
  auto lidar = sounder();
  lidar.gate = {0, 1e-9, 3000};
  const auto plan = hand_plan(lidar, scene);
  const auto result = shoot(scene, plan, shot_from(lidar, {0, 0, 0}, {1, 0, 0}));
  // Attenuated backscatter: each bin times R^2, A_r and efficiency taken off.
  double sum = 0;
  for (std::size_t i = 0; i < 3000; ++i) {
    const double range = 0.5 * kLightSpeed * (static_cast<double>(i) + 0.5) * 1e-9;
    sum += result.rows.particles[i] * range * range;
  }
  sum /= plan.photons[0] * M_PI * (0.05 * 0.05 - 0.015 * 0.015) * 0.5;
  // R at bin centres: 0.15 m bins at 60 m, (dR / R)^2 / 4.
  CHECK(sum == doctest::Approx(0.008646647).epsilon(3e-6));
}

TEST_CASE("L-09: transmission of a gas is averaged over the line after the exponential") {
  scene::CompiledScene scene = scene_of({0.3});
  add_plane(scene, 0, {0, 0, 0}, 50);
  scene.volumes = {box_of(100, {0, 0, 10}, {40, 40, 10})};  // 1000 ppm m on the way down
  scene::finish_top_tree(scene);
  auto lidar = sounder();
  lidar.pulse.fwhm_s = 4e-9;
  auto plan = hand_plan(lidar, scene);
  const auto shot = shot_from(lidar, {0, 0, 1000}, {0, 0, -1});
  const double clear = row_sum(shoot(scene, plan, shot).rows.first);
  plan.cross_section_cm2 = {1.061032954e-18};
  CHECK(row_sum(shoot(scene, plan, shot).rows.first) / clear == doctest::Approx(5.188089e-3).epsilon(2e-7));
  plan.cross_section_cm2 = {1.694941e-21};
  CHECK(row_sum(shoot(scene, plan, shot).rows.first) / clear == doctest::Approx(0.991630).epsilon(1e-6));
  // Two equal nodes.
  plan.nodes = {{0, 1.064, 0.5}, {0, 1.065, 0.5}};
  plan.first_node = {0, 2};
  plan.cross_section_cm2 = {1.061032954e-18, 1.694941e-21};
  const auto result = shoot(scene, plan, shot);
  CHECK(row_sum(result.rows.first) / clear == doctest::Approx(0.5 * (5.188089e-3 + 0.991630)).epsilon(1e-6));
  CHECK(result.ledger[0].volumes ==
        doctest::Approx(1 - 0.5 * (std::sqrt(5.188089e-3) + std::sqrt(0.991630))).epsilon(1e-6));
  CHECK(std::abs(result.ledger[0].emitted_error()) < 1e-14);
}

TEST_CASE("L-11: columns of volumes") {
  scene::Volume plume;
  plume.shape = scene::Volume::Shape::plume, plume.name = "plume", plume.gas = "CH4";
  plume.position_m = {100, 50, 3}, plume.yaw_deg = 30, plume.source_g_s = 1, plume.wind_m_s = 3;
  plume.sigma_y_m = 10, plume.molar_mass_g = 16.0425;
  const glm::dvec3 down_wind{std::sin(M_PI / 6), std::cos(M_PI / 6), 0},
      across{std::cos(M_PI / 6), -std::sin(M_PI / 6), 0};
  for (const double sigma_z : {2.0, 15.0})
    for (const double height : {0.0, 5.0})
      for (const double y : {0.0, 12.0}) {
        plume.sigma_z_m = sigma_z, plume.release_height_m = height;
        const glm::dvec3 foot = glm::dvec3(100, 50, 3) + 80.0 * down_wind + y * across;
        const double column = reference::VolumePath(plume).column_cm2(between(foot + glm::dvec3(0, 0, 900), foot));
        CHECK(column == doctest::Approx(4.991920560e16 * std::exp(-0.5 * y * y / 100)).epsilon(1e-9));
      }
  // Crosswind through Briggs' widths at x: Q / (sqrt(2 pi) u sz) (e- + e+).
  plume.sigma_y_m = plume.sigma_z_m = 0, plume.release_height_m = 4;
  const double x = 3, sz = 0.06 * x / std::sqrt(1 + 1.5e-3 * x);
  const glm::dvec3 middle = glm::dvec3(100, 50, 3 + 4.1) + x * down_wind;
  const double line =
      reference::VolumePath(plume).column_cm2(between(middle + 5000.0 * across, middle - 700.0 * across));
  const double g_m2 = 1 / (std::sqrt(2 * M_PI) * 3 * sz) * std::exp(-0.5 * 0.1 * 0.1 / (sz * sz));
  CHECK(line == doctest::Approx(g_m2 / 16.0425 * 6.02214076e19).epsilon(1e-9));

  scene::Volume box = box_of(20, {10, 20, 1}, {4, 6, 8});
  box.yaw_deg = 37;
  const double along_z = reference::VolumePath(box).column_cm2(between({10.3, 20.2, 100}, {10.3, 20.2, 4}));
  CHECK(along_z == doctest::Approx(20 * 5 * 2.479371580e15).epsilon(1e-12));
  // A grid that is linear in x' is met exactly by its trilinear values, half cells at the border being flat.
  scene::Volume grid = box;
  grid.shape = scene::Volume::Shape::grid, grid.yaw_deg = 0, grid.concentration_ppm = 2, grid.cells = {4, 1, 1};
  grid.values = {1, 2, 3, 4};
  const double through = reference::VolumePath(grid).column_cm2(between({0, 20, 5}, {20, 20, 5}));
  CHECK(through == doctest::Approx(2 * (0.5 * 1 + 1.5 + 2.5 + 3.5 + 0.5 * 4) * 2.479371580e15).epsilon(1e-12));
}

TEST_CASE("air: depth of slanted, level and downward ways") {
  lidar::AirColumn air{100, 50, 4, {0, 0.5, 0.7, 0.8}, {}};
  const reference::AirPath path(air);
  const auto depth = [&](const glm::dvec3& from, const glm::dvec3& to) {
    std::vector<double> out(1, 0);
    path.add_depth(between(from, to), out);
    return out[0];
  };
  CHECK(depth({0, 0, 1000}, {0, 0, 100}) == doctest::Approx(0.8).epsilon(1e-14));
  CHECK(depth({0, 0, 100}, {300, 400, 250}) == doctest::Approx(0.8 / 150 * std::sqrt(250000.0 + 22500)).epsilon(1e-14));
  CHECK(depth({0, 0, 160}, {70, 0, 160}) == doctest::Approx(0.2 / 50 * 70).epsilon(1e-14));
  CHECK(depth({0, 0, 50}, {0, 0, 0}) == doctest::Approx(0.5).epsilon(1e-14));
  CHECK(depth({0, 0, 260}, {500, 0, 260}) == 0);
}
