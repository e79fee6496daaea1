#include <algorithm>
#include <cmath>

#include "host/base/attitude.h"
#include "scene_compiler/instrument_builder.h"
#include "host/base/units.h"

namespace raycube::scene {
namespace {

base::Attitude attitude_of(const Pose& pose) { return {pose.roll_deg, pose.pitch_deg, pose.heading_deg}; }

}  // namespace

void Aim::place(double height_m, Pose& pose) const {
  const double azimuth = base::rad_by_division(azimuth_deg),
               aside_m = height_m * std::tan(base::rad_by_division(*off_nadir_deg));
  pose.x_m = point_m[0] - aside_m * std::sin(azimuth), pose.y_m = point_m[1] - aside_m * std::cos(azimuth);
  pose.z_m = point_m[2] + height_m;
}

bool Aim::turn(bool heading_too, Pose& pose) const {
  double east = point_m[0] - pose.x_m, north = point_m[1] - pose.y_m, down = pose.z_m - point_m[2];
  if (!at_point) {
    const double azimuth = base::rad_by_division(azimuth_deg), off = base::rad_by_division(*off_nadir_deg);
    east = std::sin(off) * std::sin(azimuth), north = std::sin(off) * std::cos(azimuth), down = std::cos(off);
  }
  const double length = std::hypot(east, north, down);
  if (!(down > 1e-3 * length)) return false;
  if (heading_too && std::hypot(east, north) > 1e-9 * length)
    pose.heading_deg = base::deg_by_division(std::atan2(east, north));
  const double heading = base::rad_by_division(pose.heading_deg);
  // Of the boresight forward, right and down of that heading: (sin p cos r, -sin r, cos p cos r).
  const double forward = north * std::cos(heading) + east * std::sin(heading),
               right = east * std::cos(heading) - north * std::sin(heading);
  pose.roll_deg = base::deg_by_division(std::asin(std::clamp(-right / length, -1.0, 1.0)));
  pose.pitch_deg = base::deg_by_division(std::atan2(forward, down));
  if (heading_too) pose.roll_deg = 0;
  return true;
}

std::vector<Pose> straight_flight(InstrumentKind kind, int lines, int pixels, const Pose& middle,
                                  double line_spacing_m) {
  if (kind == InstrumentKind::framing) return {middle};
  const double heading = base::rad_by_division(middle.heading_deg), east = std::sin(heading), north = std::cos(heading);
  std::vector<Pose> poses;
  const auto at = [&](double lines_from_middle) {
    Pose pose = middle;
    pose.x_m += lines_from_middle * line_spacing_m * east;
    pose.y_m += lines_from_middle * line_spacing_m * north;
    poses.push_back(pose);
  };
  for (int line = 0; line < lines; ++line) {
    const double from_middle = line - 0.5 * (lines - 1);
    if (kind == InstrumentKind::pushbroom)
      at(from_middle);
    else
      for (int sample = 0; sample < pixels; ++sample) at(from_middle + (sample + 0.5) / pixels - 0.5);
  }
  return poses;
}

std::vector<Pose> poses_per_pixel(const std::vector<Pose>& per_line, int pixels) {
  std::vector<Pose> out;
  const auto lines = static_cast<int>(per_line.size());
  for (int line = 0; line < lines; ++line)
    for (int sample = 0; sample < pixels; ++sample) {
      const double time = line + (sample + 0.5) / pixels - 0.5;
      const int from = std::clamp(static_cast<int>(std::floor(time)), 0, std::max(lines - 2, 0));
      const Pose &a = per_line[static_cast<std::size_t>(from)],
                 &b = per_line[static_cast<std::size_t>(std::min(from + 1, lines - 1))];
      const double t = time - from;
      const base::Attitude turned = base::attitude_between(attitude_of(a), attitude_of(b), t);
      out.push_back({a.x_m + t * (b.x_m - a.x_m), a.y_m + t * (b.y_m - a.y_m), a.z_m + t * (b.z_m - a.z_m),
                     turned.roll_deg, turned.pitch_deg, turned.heading_deg});
    }
  return out;
}

}  // namespace raycube::scene
