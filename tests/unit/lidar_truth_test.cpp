// What stands behind a return: closed forms over a plane whose hits are given.
#include <doctest/doctest.h>

#include <cmath>

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
  const auto truth = lidar::return_truth(scene, plan, hits_everywhere(plan, shot), 0, 0, {near, far});
  // A sub-ray counts only within the pulse of the echo; here all do, at half a footprint of 0.25 m times tan 30 degrees.
  CHECK(truth[0].subray_share == doctest::Approx(1));
  CHECK(truth[0].range_m == doctest::Approx(1000).epsilon(2e-6));
  CHECK(truth[0].expected_pe == doctest::Approx(34992.34561).epsilon(2e-5));  // finite footprint: order (0.25 m / 1 km)^2 and its slope
  CHECK(truth[0].incidence_deg == doctest::Approx(30).epsilon(1e-3));
  CHECK(truth[0].transmission_2way == doctest::Approx(0.8187307531).epsilon(2e-6));
  CHECK(truth[0].order == 1);
  CHECK(truth[0].material == 0);
  CHECK(truth[1].order == 0);
  CHECK(std::isnan(truth[1].range_m));
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
