#include "host/sensors/camera_frame.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/trigonometric.hpp>

namespace raycube::sensors {
namespace {

// North-east-down from forward-right-down.
glm::dquat ned_from_body(const scene::Pose& pose) {
  const glm::dquat yaw = glm::angleAxis(glm::radians(pose.heading_deg), glm::dvec3(0, 0, 1));
  const glm::dquat pitch = glm::angleAxis(glm::radians(pose.pitch_deg), glm::dvec3(0, 1, 0));
  const glm::dquat roll = glm::angleAxis(glm::radians(pose.roll_deg), glm::dvec3(1, 0, 0));
  return yaw * pitch * roll;
}

glm::dvec3 enu_from_ned(const glm::dvec3& v) { return {v.y, v.x, -v.z}; }

CameraFrame frame_at(const glm::dvec3& origin_m, const glm::dquat& rotation) {
  return {origin_m, enu_from_ned(rotation * glm::dvec3(1, 0, 0)), enu_from_ned(rotation * glm::dvec3(0, 1, 0)),
          enu_from_ned(rotation * glm::dvec3(0, 0, 1))};
}

// glm::slerp takes the long way for q and -q and clamps nothing; the shorter arc and extrapolation are wanted here.
glm::dquat turn_between(const glm::dquat& from, glm::dquat to, double fraction) {
  if (glm::dot(from, to) < 0) to = -to;
  const glm::dquat step = glm::inverse(from) * to;
  const glm::dvec3 axis(step.x, step.y, step.z);
  const double sine = glm::length(axis);
  if (sine == 0) return from;
  const double angle_rad = 2 * std::atan2(sine, step.w);
  return from * glm::angleAxis(angle_rad * fraction, axis / sine);
}

}  // namespace

CameraFrame frame_of(const scene::Pose& pose) {
  return frame_at({pose.x_m, pose.y_m, pose.z_m}, ned_from_body(pose));
}

CameraFrame interpolate(const scene::Pose& from, const scene::Pose& to, double fraction) {
  const glm::dvec3 a(from.x_m, from.y_m, from.z_m), b(to.x_m, to.y_m, to.z_m);
  return frame_at(a + fraction * (b - a), turn_between(ned_from_body(from), ned_from_body(to), fraction));
}

}  // namespace raycube::sensors
