#include "host/base/attitude.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace raycube::base {
namespace {

/// Angles of a turn: with m = ned_from_body as a matrix, m's first column is forward = (cos p cos h, cos p
/// sin h, -sin p), and its third row (-sin p, cos p sin r, cos p cos r) (Diebel, "Representing attitude",
/// 2006, eq. 70-71 for z-y-x).
Attitude attitude_of(const glm::dquat& turn) {
  const glm::dvec3 forward = turn * glm::dvec3(1, 0, 0), right = turn * glm::dvec3(0, 1, 0),
                   down = turn * glm::dvec3(0, 0, 1);
  const double level = std::hypot(forward.x, forward.y);
  Attitude out;
  out.pitch_deg = glm::degrees(std::atan2(-forward.z, level));
  if (level > 1e-9) {
    out.heading_deg = glm::degrees(std::atan2(forward.y, forward.x));
    out.roll_deg = glm::degrees(std::atan2(right.z, down.z));
  } else {
    out.heading_deg = glm::degrees(std::atan2(-right.x, right.y));
  }
  return out;
}

}  // namespace

glm::dquat ned_from_body(const Attitude& attitude) {
  const glm::dquat yaw = glm::angleAxis(glm::radians(attitude.heading_deg), glm::dvec3(0, 0, 1));
  const glm::dquat pitch = glm::angleAxis(glm::radians(attitude.pitch_deg), glm::dvec3(0, 1, 0));
  const glm::dquat roll = glm::angleAxis(glm::radians(attitude.roll_deg), glm::dvec3(1, 0, 0));
  return yaw * pitch * roll;
}

// glm::slerp takes the long way for q and -q and clamps nothing; the shorter arc and extrapolation are wanted
// here.
glm::dquat turn_between(const glm::dquat& from, glm::dquat to, double fraction) {
  if (glm::dot(from, to) < 0) to = -to;
  const glm::dquat step = glm::inverse(from) * to;
  const glm::dvec3 axis(step.x, step.y, step.z);
  const double sine = glm::length(axis);
  if (sine == 0) return from;
  const double angle_rad = 2 * std::atan2(sine, step.w);
  return from * glm::angleAxis(angle_rad * fraction, axis / sine);
}

Attitude attitude_between(const Attitude& from, const Attitude& to, double fraction) {
  if (from == to || fraction == 0) return from;
  if (fraction == 1) return to;
  return attitude_of(turn_between(ned_from_body(from), ned_from_body(to), fraction));
}

}  // namespace raycube::base
