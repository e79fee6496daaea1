#include "host/sensors/view_bounds.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "host/base/error.h"
#include "host/sensors/ray_groups.h"

namespace raycube::sensors {
namespace {

using Vec = glm::dvec3;

Vec exact(const shared::rc_float4& v) { return {v.x, v.y, v.z}; }

}  // namespace

plan::ViewBounds view_bounds(const scene::Instrument& given) {
  scene::Instrument instrument = given;  // with `automatic` motion settled once, not once per line
  instrument.motion = pose_moves(given) ? scene::PoseMotion::moving : scene::PoseMotion::held;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  plan::ViewBounds bounds{kInfinity, -kInfinity, kInfinity, -kInfinity, kInfinity, -kInfinity, 0};
  const int width = pixels_per_group(instrument);
  const double half = 0.5 * std::max(1.0, instrument.psf_support_px);
  for (int line = 0; line < instrument.lines; ++line) {
    const auto groups = make_ray_groups(instrument, line, 1);
    for (int sample = 0; sample < instrument.pixels; ++sample) {
      const auto& group = groups[sample / width];
      const double a = sample % width - 0.5 * (width - 1);
      for (const auto& [u, v] : {std::pair{0.0, 0.0}, {-half, -half}, {-half, half}, {half, -half}, {half, half}}) {
        const Vec d = exact(group.d0) + (a + u) * exact(group.du) + v * exact(group.dv);
        if (!(d.z < 0))
          throw base::Error(base::Fault::input,
                            "instrument '" + instrument.name + "': line " + std::to_string(line) + ", sample " +
                                std::to_string(sample) + " looks up or level (direction z " + std::to_string(d.z) +
                                "); every ray must look down: reduce roll, pitch or the field of view");
        const Vec to_sensor = -d / glm::length(d);
        const double sec = 1.0 / to_sensor.z;
        bounds.sec_min = std::min(bounds.sec_min, sec);
        bounds.sec_max = std::max(bounds.sec_max, sec);
        bounds.x_min = std::min(bounds.x_min, to_sensor.x);
        bounds.x_max = std::max(bounds.x_max, to_sensor.x);
        bounds.y_min = std::min(bounds.y_min, to_sensor.y);
        bounds.y_max = std::max(bounds.y_max, to_sensor.y);
      }
    }
  }
  bounds.sensor_x_min = bounds.sensor_y_min = kInfinity;
  bounds.sensor_x_max = bounds.sensor_y_max = -kInfinity;
  for (const auto& pose : instrument.poses) {
    bounds.sensor_x_min = std::min(bounds.sensor_x_min, pose.x_m), bounds.sensor_x_max = std::max(bounds.sensor_x_max, pose.x_m);
    bounds.sensor_y_min = std::min(bounds.sensor_y_min, pose.y_m), bounds.sensor_y_max = std::max(bounds.sensor_y_max, pose.y_m);
  }
  for (const auto& pose : instrument.poses) bounds.sensor_height_m += pose.z_m / static_cast<double>(instrument.poses.size());
  return bounds;
}

}  // namespace raycube::sensors
