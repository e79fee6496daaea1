#include <algorithm>
#include <cmath>

#include "scene_compiler/instrument_builder.h"

namespace raycube::scene {
namespace {

double angle_between(double from_deg, double to_deg, double t) {
  return from_deg + t * std::remainder(to_deg - from_deg, 360.0);
}

}  // namespace

std::vector<Pose> straight_flight(InstrumentKind kind, int lines, int pixels, const Pose& middle,
                                  double line_spacing_m) {
  if (kind == InstrumentKind::framing) return {middle};
  const double heading = middle.heading_deg * M_PI / 180.0, east = std::sin(heading),
               north = std::cos(heading);
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
      out.push_back({a.x_m + t * (b.x_m - a.x_m), a.y_m + t * (b.y_m - a.y_m), a.z_m + t * (b.z_m - a.z_m),
                     angle_between(a.roll_deg, b.roll_deg, t), angle_between(a.pitch_deg, b.pitch_deg, t),
                     angle_between(a.heading_deg, b.heading_deg, t)});
    }
  return out;
}

}  // namespace raycube::scene
