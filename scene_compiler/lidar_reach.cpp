#include "scene_compiler/lidar_reach.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "scene_compiler/plume_width.h"

namespace raycube::scene {

namespace {

struct Box {
  std::array<double, 3> lo{}, hi{};
};

/// What holds a volume whatever its azimuth.
Box box_of(const Volume& volume) {
  const bool plume = volume.shape == Volume::Shape::plume;
  double reach = 0.5 * std::hypot(volume.size_m[0], volume.size_m[1]), low = 0, high = volume.size_m[2];
  if (plume) {
    const double rise = plume_rise_m(volume);
    reach = std::hypot(volume.length_m, plume_side_m(volume));
    low = std::max(volume.release_height_m - rise, 0.0), high = volume.release_height_m + rise;
  }
  const auto& p = volume.position_m;
  return {{p[0] - reach, p[1] - reach, p[2] + low}, {p[0] + reach, p[1] + reach, p[2] + high}};
}

double nearest_m(const Box& box, const std::array<double, 3>& p) {
  double square = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const double off = std::max({box.lo[i] - p[i], p[i] - box.hi[i], 0.0});
    square += off * off;
  }
  return std::sqrt(square);
}

double farthest_m(const Box& box, const std::array<double, 3>& p) {
  double square = 0;
  for (std::size_t i = 0; i < 3; ++i) square += std::pow(std::max(p[i] - box.lo[i], box.hi[i] - p[i]), 2);
  return std::sqrt(square);
}

std::array<double, 3> place(const LidarPose& pose) { return {pose.x_m, pose.y_m, pose.z_m}; }

/// Nearest on the way between two poses: the distance to a box is convex along it.
double nearest_between_m(const Box& box, const std::array<double, 3>& a, const std::array<double, 3>& b) {
  const auto at = [&](double t) {
    return nearest_m(box, {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])});
  };
  double low = 0, high = 1;
  for (int i = 0; i < 80; ++i) {
    const double third = (high - low) / 3;
    if (at(low + third) <= at(high - third))
      high -= third;
    else
      low += third;
  }
  return std::min({at(0), at(1), at(0.5 * (low + high))});
}

double nearest_on_way_m(const Box& box, const std::vector<LidarPose>& poses) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& pose : poses) nearest = std::min(nearest, nearest_m(box, place(pose)));
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const auto a = place(poses[i - 1]), b = place(poses[i]);
    const double length = std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    // No place between two poses is nearer than half of the way between them allows.
    if (0.5 * (nearest_m(box, a) + nearest_m(box, b) - length) < nearest)
      nearest = std::min(nearest, nearest_between_m(box, a, b));
  }
  return nearest;
}

}  // namespace

Reach reach_of(const std::array<float, 3>& lo, const std::array<float, 3>& hi, const std::vector<Volume>& volumes,
               const Lidar& lidar) {
  std::vector<Box> boxes;
  if (lo[0] <= hi[0]) boxes.push_back({{lo[0], lo[1], lo[2]}, {hi[0], hi[1], hi[2]}});
  for (const auto& volume : volumes)
    if (volume.extinction_per_m > 0) boxes.push_back(box_of(volume));  // gas takes light, and sends none back
  if (boxes.empty()) return {};
  Reach reach{std::numeric_limits<double>::infinity(), 0};
  for (const auto& box : boxes) {
    reach.nearest_m = std::min(reach.nearest_m, nearest_on_way_m(box, lidar.trajectory));
    for (const auto& pose : lidar.trajectory)
      reach.farthest_m = std::max(reach.farthest_m, farthest_m(box, place(pose)));
  }
  // The exit and the pupil lie up to so far from the platform's place.
  double arm_m = 0;
  for (const LidarMount* mount : {&lidar.transmitter, &lidar.receiver_mount})
    arm_m = std::max(arm_m, std::hypot(mount->offset_m[0], mount->offset_m[1], mount->offset_m[2]));
  reach.nearest_m = std::max(0.0, reach.nearest_m - arm_m), reach.farthest_m += arm_m;
  if (lidar.transport.range_limit_m > 0) reach.farthest_m = std::min(reach.farthest_m, lidar.transport.range_limit_m);
  return reach;
}

}  // namespace raycube::scene
