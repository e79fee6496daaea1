// Attitudes between two others: the turn about one axis at a constant rate, in closed form by Rodrigues'
// formula.
#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>

#include "host/base/attitude.h"
#include "host/lidar/shot.h"
#include "host/sensors/camera_frame.h"
#include "scene_compiler/instrument_builder.h"

using namespace raycube;
using base::Attitude;

namespace {

constexpr double kDeg = M_PI / 180, kTiny = 1e-12;  // double rounding of a few products of unit vectors

/// Rodrigues (1840): v turned by angle_rad about the unit vector axis, right-handed.
glm::dvec3 turned(const glm::dvec3& v, const glm::dvec3& axis, double angle_rad) {
  return v * std::cos(angle_rad) + glm::cross(axis, v) * std::sin(angle_rad) +
         axis * glm::dot(axis, v) * (1 - std::cos(angle_rad));
}

/// Columns forward, right, down in north-east-down, written out for z-y-x (Diebel 2006, eq. 70).
glm::dmat3 matrix(const Attitude& a) {
  const double cr = std::cos(a.roll_deg * kDeg), sr = std::sin(a.roll_deg * kDeg), cp = std::cos(a.pitch_deg * kDeg);
  const double sp = std::sin(a.pitch_deg * kDeg), ch = std::cos(a.heading_deg * kDeg),
               sh = std::sin(a.heading_deg * kDeg);
  return {cp * ch,
          cp * sh,
          -sp,
          sr * sp * ch - cr * sh,
          sr * sp * sh + cr * ch,
          sr * cp,
          cr * sp * ch + sr * sh,
          cr * sp * sh - sr * ch,
          cr * cp};
}

double apart(const glm::dmat3& a, const glm::dmat3& b) {
  double most = 0;
  for (int c = 0; c < 3; ++c) most = std::max(most, glm::length(a[c] - b[c]));
  return most;
}

struct Way {
  Attitude from, to;
  glm::dvec3 axis;  ///< in north-east-down
  double angle_rad;
};

/// Angles of a matrix of the form above.
Attitude angles(const glm::dmat3& m) {
  return {std::atan2(m[1].z, m[2].z) / kDeg, std::asin(-m[0].z) / kDeg, std::atan2(m[0].y, m[0].x) / kDeg};
}

Way way(const Attitude& from, const glm::dvec3& axis, double angle_rad) {
  const glm::dmat3 m = matrix(from);
  return {from, angles({turned(m[0], axis, angle_rad), turned(m[1], axis, angle_rad), turned(m[2], axis, angle_rad)}),
          axis, angle_rad};
}

const std::array<Way, 4> kWays{way({0, 0, 0}, glm::normalize(glm::dvec3(1, 2, -1)), 1.1),
                               way({-40, 30, 170}, {0, 0, 1}, 0.8),
                               way({20, -60, -175}, glm::normalize(glm::dvec3(-1, 0.2, 0.4)), 2.0),
                               way({5, 2, 359.5}, glm::normalize(glm::dvec3(0.1, 1, 0)), 0.02)};

glm::dmat3 expected(const Way& w, double fraction) {
  const glm::dmat3 m = matrix(w.from);
  return {turned(m[0], w.axis, fraction * w.angle_rad), turned(m[1], w.axis, fraction * w.angle_rad),
          turned(m[2], w.axis, fraction * w.angle_rad)};
}

}  // namespace

TEST_CASE("S10: between two attitudes the platform turns about one axis at a constant rate") {
  for (const Way& w : kWays)
    for (const double fraction : {0.0, 0.2, 0.5, 0.9, 1.0, 1.25, -0.25})
      CHECK(apart(matrix(base::attitude_between(w.from, w.to, fraction)), expected(w, fraction)) < kTiny);
}

TEST_CASE("S10: equal attitudes and the ends come back as they are; a nose straight up or down is no trouble") {
  const Attitude a{1.1, -2.2, 359.9}, b{3, 4, 5};
  CHECK(base::attitude_between(a, a, 0.3) == a);
  CHECK(base::attitude_between(a, b, 0) == a);
  CHECK(base::attitude_between(a, b, 1) == b);
  for (const double pitch_deg : {90.0, -90.0}) {
    const Attitude up{0, pitch_deg, 40};
    CHECK(apart(matrix(base::attitude_between({0, pitch_deg / 2, 40}, {0, pitch_deg * 1.5, 40}, 0.5)), matrix(up)) <
          1e-9);
  }
}

TEST_CASE("S10: pixels of a whiskbroom's line and pulses of a LIDAR turn that way") {
  for (const Way& w : kWays) {
    const scene::Pose from{0, 0, 100, w.from.roll_deg, w.from.pitch_deg, w.from.heading_deg};
    const scene::Pose to{10, 0, 100, w.to.roll_deg, w.to.pitch_deg, w.to.heading_deg};
    const auto poses = scene::poses_per_pixel({from, to}, 4);  // pixel s of line 0 is at (s + 0.5) / 4 - 0.5 of the way
    for (std::size_t s = 0; s < 4; ++s) {
      const double fraction = (static_cast<double>(s) + 0.5) / 4 - 0.5;
      CHECK(apart(matrix({poses[s].roll_deg, poses[s].pitch_deg, poses[s].heading_deg}), expected(w, fraction)) <
            kTiny);
    }
    scene::Lidar lidar;
    lidar.trajectory = {{0, 0, 0, 100, from.roll_deg, from.pitch_deg, from.heading_deg},
                        {1, 10, 0, 100, to.roll_deg, to.pitch_deg, to.heading_deg}};
    lidar.prf_hz = 10;
    lidar.pulses = 11;
    lidar.pulse.half_divergence_rad = 1e-3;
    for (const auto& shot : lidar::make_shots(lidar, 0, 11, 1)) {
      const glm::dvec3 down = expected(w, shot.time_s)[2];  // north-east-down; the shot's axis is east-north-up
      CHECK(glm::length(glm::dvec3(shot.exit_axis[1], shot.exit_axis[0], -shot.exit_axis[2]) - down) < kTiny);
    }
  }
}
