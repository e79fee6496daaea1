// make_shots in closed form: clocks, flights, mounts, attitude signs and every scan pattern.
#include <doctest/doctest.h>

#include <cmath>

#include "host/lidar/shot.h"
#include "host/sensors/camera_frame.h"
#include "tests/support/chance_checks.h"

using namespace raycube;
using lidar::make_shots;
using lidar::Shot;
using lidar::Vec3;

namespace {

constexpr double kDeg = M_PI / 180, kTiny = 1e-12;  // double rounding of a few products of unit vectors

scene::Lidar at_rest() {
  scene::Lidar out;
  out.trajectory = {{0, 10, 20, 1000, 0, 0, 0}};
  out.prf_hz = 1000;
  out.pulses = 100000;
  out.pulse.half_divergence_rad = 1e-3;
  return out;
}

Shot one(const scene::Lidar& lidar, std::int64_t pulse = 0) {
  const auto shots = make_shots(lidar, pulse, 1, 1);
  REQUIRE(shots.size() == 1);
  return shots[0];
}

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double distance(const Vec3& a, const Vec3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }
#define CHECK_NEAR(a, ...) CHECK(distance(a, Vec3{__VA_ARGS__}) < kTiny)

/// Against v = axis x u: the nose of a level platform.
Vec3 minus_v(const Shot& shot) { return cross(shot.pupil_u, shot.pupil_axis); }

double across_deg(const Shot& shot) { return shot.scan_angle_rad / kDeg; }

}  // namespace

TEST_CASE("S27: a LIDAR at rest looks down; pulses are 1/prf apart") {
  const auto shots = make_shots(at_rest(), 3, 5, 1);
  REQUIRE(shots.size() == 5);
  for (std::size_t i = 0; i < shots.size(); ++i) {
    CHECK(shots[i].pulse == 3 + static_cast<std::int64_t>(i));
    CHECK(shots[i].time_s == doctest::Approx((3 + static_cast<double>(i)) / 1000).epsilon(1e-15));
    CHECK_NEAR(shots[i].exit_m, 10, 20, 1000);
    CHECK_NEAR(shots[i].pupil_m, 10, 20, 1000);
    CHECK_NEAR(shots[i].exit_axis, 0, 0, -1);
    CHECK_NEAR(shots[i].pupil_axis, 0, 0, -1);
    CHECK_NEAR(shots[i].pupil_u, 1, 0, 0);
    CHECK(shots[i].half_divergence_rad == 1e-3);
    CHECK(shots[i].gain == 1);
    CHECK(shots[i].scan_angle_rad == 0);
  }
}

TEST_CASE(
    "S27: a straight flight is where it is at each pulse, on a clock of its own, and stands still beyond its ends") {
  scene::Lidar lidar = at_rest();
  lidar.trajectory = {{100, 0, 0, 500, 0, 0, 90}, {110, 600, 0, 500, 0, 0, 90}};
  lidar.first_pulse_s = 101;
  const auto shots = make_shots(lidar, 0, 20000, 1);
  // 60 m/s east: 6 cm per pulse.
  CHECK_NEAR(shots[0].exit_m, 60, 0, 500);
  for (const std::size_t i : {1ul, 17ul, 8999ul})
    CHECK(distance(shots[i].exit_m, {60 + 0.06 * static_cast<double>(i), 0, 500}) < 1e-9);
  CHECK_NEAR(shots[15000].exit_m, 600, 0, 500);
  CHECK(shots[9].time_s - shots[8].time_s == doctest::Approx(1e-3).epsilon(1e-10));
  lidar.first_pulse_s = 0;
  CHECK_NEAR(one(lidar).exit_m, 0, 0, 500);
}

TEST_CASE("S27: headings turn the short way over north") {
  scene::Lidar lidar = at_rest();
  lidar.trajectory = {{0, 0, 0, 0, 0, 0, 350}, {1, 0, 0, 0, 0, 0, 20}};
  const Shot shot = one(lidar, 500);  // halfway: 5 degrees
  CHECK_NEAR(shot.pupil_u, std::cos(5 * kDeg), -std::sin(5 * kDeg), 0);
}

TEST_CASE("S27: roll, pitch and heading have the signs and the order of the instruments' poses") {
  for (const auto& [roll, pitch, heading] :
       {std::array{10.0, 0.0, 0.0}, {0.0, 10.0, 0.0}, {0.0, 0.0, 10.0}, {-25.0, 12.0, 200.0}, {170.0, -80.0, 359.0}}) {
    scene::Lidar lidar = at_rest();
    lidar.trajectory[0].roll_deg = roll, lidar.trajectory[0].pitch_deg = pitch,
    lidar.trajectory[0].heading_deg = heading;
    const Shot shot = one(lidar);
    const auto frame = sensors::frame_of({10, 20, 1000, roll, pitch, heading});
    CHECK_NEAR(shot.exit_axis, frame.boresight.x, frame.boresight.y, frame.boresight.z);
    CHECK_NEAR(shot.pupil_u, frame.right.x, frame.right.y, frame.right.z);
    CHECK_NEAR(minus_v(shot), frame.forward.x, frame.forward.y, frame.forward.z);
  }
  // In words: nose up looks forwards, right wing down looks to the left.
  scene::Lidar lidar = at_rest();
  lidar.trajectory[0].pitch_deg = 10;
  CHECK_NEAR(one(lidar).exit_axis, 0, std::sin(10 * kDeg), -std::cos(10 * kDeg));
  lidar.trajectory[0] = {0, 0, 0, 0, 10, 0, 0};
  CHECK_NEAR(one(lidar).exit_axis, -std::sin(10 * kDeg), 0, -std::cos(10 * kDeg));
  CHECK(across_deg(one(lidar)) == doctest::Approx(-10).epsilon(1e-12));
}

TEST_CASE("S27: lever arms turn with the platform; tilts lean forwards and to the right") {
  scene::Lidar lidar = at_rest();
  lidar.trajectory[0] = {0, 100, 200, 300, 0, 0, 90};  // nose east: right is south
  lidar.transmitter = {{1, 2, 3}, 0, 0};
  lidar.receiver_mount = {{-1, 0, 0.5}, 0, 0};
  CHECK_NEAR(one(lidar).exit_m, 102, 199, 303);
  CHECK_NEAR(one(lidar).pupil_m, 100, 201, 300.5);
  lidar.trajectory[0].roll_deg = 90;  // right wing down: the top leans south
  CHECK_NEAR(one(lidar).exit_m, 102, 197, 299);
  lidar = at_rest();
  lidar.transmitter.tilt_along_rad = 0.1;
  lidar.receiver_mount.tilt_across_rad = 0.2;
  CHECK_NEAR(one(lidar).exit_axis, 0, std::sin(0.1), -std::cos(0.1));
  CHECK_NEAR(one(lidar).pupil_axis, std::sin(0.2), 0, -std::cos(0.2));
}

TEST_CASE("LIDAR.md 4.4: a tilted biaxial pair crosses at offset over tilt") {
  scene::Lidar lidar = at_rest();
  lidar.transmitter.offset_m[0] = 1;
  lidar.transmitter.tilt_across_rad = -std::atan(1.0 / 500);
  const Shot shot = one(lidar);
  const double t = 500 / -shot.exit_axis[2];
  CHECK(shot.exit_m[0] + t * shot.exit_axis[0] == doctest::Approx(shot.pupil_m[0]).epsilon(1e-12));
}

TEST_CASE("S27: frames are orthonormal whatever is tilted, and the footprint's turn comes from seed and pulse alone") {
  scene::Lidar lidar = at_rest();
  lidar.trajectory[0] = {0, 0, 0, 0, 5, -7, 123};
  lidar.transmitter = {{0, 0, 0}, 0.3, -0.2};
  lidar.receiver_mount = {{0, 0, 0}, -0.1, 0.4};
  lidar.scan = {scene::ScanPattern::palmer, 13.7, 20 * kDeg, 1, 1, 0};
  const auto shots = make_shots(lidar, 0, 4000, 5);
  double c = 0, s = 0;
  for (const Shot& shot : shots) {
    CHECK(std::abs(dot(shot.exit_axis, shot.exit_axis) - 1) < kTiny);
    CHECK(std::abs(dot(shot.exit_u, shot.exit_u) - 1) < kTiny);
    CHECK(std::abs(dot(shot.exit_u, shot.exit_axis)) < kTiny);
    CHECK(std::abs(dot(shot.pupil_u, shot.pupil_u) - 1) < kTiny);
    CHECK(std::abs(dot(shot.pupil_u, shot.pupil_axis)) < kTiny);
  }
  lidar = at_rest();
  for (const Shot& shot : make_shots(lidar, 0, 4000, testing::seed(5))) c += shot.exit_u[0], s += shot.exit_u[1];
  // Mean of 4000 uniform directions: standard deviation sqrt(1/2 / 4000) = 0.0112 per axis; 4 of them.
  CHECK_WITHIN(c / 4000, 0.045);
  CHECK_WITHIN(s / 4000, 0.045);
  const auto part = make_shots(lidar, 1000, 3, 5), whole = make_shots(lidar, 0, 1003, 5);
  CHECK(part[1].exit_u == whole[1001].exit_u);
  CHECK(part[1].exit_u != make_shots(lidar, 1000, 3, 6)[1].exit_u);
}

TEST_CASE("S27: line scan runs linearly from -half to +half each cycle and jumps back") {
  scene::Lidar lidar = at_rest();
  lidar.scan = {scene::ScanPattern::line, 10, 30 * kDeg, 1, 1, 0};  // 100 pulses a cycle
  for (const std::int64_t i : {0, 1, 25, 50, 99, 100, 175})
    CHECK(across_deg(one(lidar, i)) == doctest::Approx(-30 + 0.6 * static_cast<double>(i % 100)).epsilon(1e-11));
}

TEST_CASE("S27: an oscillating mirror swings as a sine") {
  scene::Lidar lidar = at_rest();
  lidar.scan = {scene::ScanPattern::oscillating, 10, 30 * kDeg, 1, 1, 0};
  for (const std::int64_t i : {1, 12, 25, 60, 75, 1025})
    CHECK(across_deg(one(lidar, i)) ==
          doctest::Approx(30 * std::sin(2 * M_PI * static_cast<double>(i) / 100)).epsilon(1e-10));
}

TEST_CASE("S27: a rotating mirror turns evenly and fires within its half angle alone") {
  scene::Lidar lidar = at_rest();
  lidar.scan = {scene::ScanPattern::rotating, 10, 45 * kDeg + 1e-9, 1, 1, 0};  // 3.6 degrees a pulse
  const auto shots = make_shots(lidar, 0, 1000, 1);
  // 0, 3.6 ... 43.2 and -43.2 ... -3.6: 25 of each 100. (45 itself is no multiple of 3.6.)
  REQUIRE(shots.size() == 250);
  for (const Shot& shot : shots) {
    const double angle = 3.6 * static_cast<double>(shot.pulse % 100);
    CHECK(across_deg(shot) == doctest::Approx(angle > 180 ? angle - 360 : angle).epsilon(1e-10).scale(1));
    CHECK(shot.time_s == doctest::Approx(static_cast<double>(shot.pulse) / 1000).epsilon(1e-14));
  }
  lidar.scan.half_angle_rad = M_PI;
  CHECK(make_shots(lidar, 0, 1000, 1).size() == 1000);
}

TEST_CASE(
    "S27: a Palmer scanner keeps a constant angle from its boresight and turns once a cycle, clockwise seen from "
    "above") {
  scene::Lidar lidar = at_rest();
  lidar.scan = {scene::ScanPattern::palmer, 10, 20 * kDeg, 1, 1, 0};
  for (std::int64_t i = 0; i < 100; ++i) {
    const Shot shot = one(lidar, i);
    const double p = 2 * M_PI * static_cast<double>(i) / 100;
    CHECK_NEAR(shot.exit_axis, std::sin(20 * kDeg) * std::sin(p), std::sin(20 * kDeg) * std::cos(p),
               -std::cos(20 * kDeg));
    // The field nutates and does not roll: its turn is the shortest, so u changes by the lean alone.
    CHECK(dot(shot.pupil_u, {1, 0, 0}) > std::cos(20 * kDeg) - kTiny);
  }
  lidar.transmitter.tilt_along_rad = lidar.receiver_mount.tilt_along_rad = 0.3;
  for (const std::int64_t i : {0, 13, 77})
    CHECK(dot(one(lidar, i).exit_axis, {0, std::sin(0.3), -std::cos(0.3)}) ==
          doctest::Approx(std::cos(20 * kDeg)).epsilon(1e-13));
}

TEST_CASE("S27: a raster goes row by row, from behind forwards, and again") {
  scene::Lidar lidar = at_rest();
  lidar.scan = {scene::ScanPattern::raster, 0, 0, 4, 3, 0.01};
  for (const std::int64_t i : {0, 3, 4, 11, 12, 18}) {
    const double a = 0.01 * (static_cast<double>(i % 4) - 1.5), b = 0.01 * (static_cast<double>(i / 4 % 3) - 1);
    CHECK_NEAR(one(lidar, i).exit_axis, std::sin(a), std::cos(a) * std::sin(b), -std::cos(a) * std::cos(b));
  }
}

TEST_CASE("S27: the field follows the scan, or stays") {
  scene::Lidar lidar = at_rest();
  lidar.scan = {scene::ScanPattern::line, 10, 30 * kDeg, 1, 1, 0};
  const Shot with = one(lidar, 75);
  CHECK_NEAR(with.pupil_axis, with.exit_axis[0], with.exit_axis[1], with.exit_axis[2]);
  CHECK_NEAR(with.pupil_u, std::cos(15 * kDeg), 0, std::sin(15 * kDeg));
  lidar.receiver.scans_with_beam = false;
  CHECK_NEAR(one(lidar, 75).pupil_axis, 0, 0, -1);
}
