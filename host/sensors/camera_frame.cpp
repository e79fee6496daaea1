#include "host/sensors/camera_frame.h"

#include "host/base/attitude.h"

namespace raycube::sensors {
namespace {

glm::dquat ned_from_body(const scene::Pose& pose) {
  return base::ned_from_body({pose.roll_deg, pose.pitch_deg, pose.heading_deg});
}

glm::dvec3 enu_from_ned(const glm::dvec3& v) { return {v.y, v.x, -v.z}; }

CameraFrame frame_at(const glm::dvec3& origin_m, const glm::dquat& rotation) {
  return {origin_m, enu_from_ned(rotation * glm::dvec3(1, 0, 0)), enu_from_ned(rotation * glm::dvec3(0, 1, 0)),
          enu_from_ned(rotation * glm::dvec3(0, 0, 1))};
}

}  // namespace

CameraFrame frame_of(const scene::Pose& pose) { return frame_at({pose.x_m, pose.y_m, pose.z_m}, ned_from_body(pose)); }

CameraFrame interpolate(const scene::Pose& from, const scene::Pose& to, double fraction) {
  const glm::dvec3 a(from.x_m, from.y_m, from.z_m), b(to.x_m, to.y_m, to.z_m);
  return frame_at(a + fraction * (b - a), base::turn_between(ned_from_body(from), ned_from_body(to), fraction));
}

}  // namespace raycube::sensors
