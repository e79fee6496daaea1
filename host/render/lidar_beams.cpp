#include "host/render/lidar_beams.h"

#include <cmath>

#include "host/render/lidar_owners.h"

namespace raycube::render {

namespace {

using lidar::cross;
using lidar::dot;
using lidar::Vec3;

constexpr double kLength_m = 1e-6, kAngle_rad = 1e-9;

Vec3 scaled(const Vec3& a, double f) { return {a[0] * f, a[1] * f, a[2] * f}; }
Vec3 unit(const Vec3& a) { return scaled(a, 1 / std::sqrt(dot(a, a))); }
Vec3 beside(const Vec3& v, const Vec3& axis) {
  const double along = dot(v, axis);
  return {v[0] - along * axis[0], v[1] - along * axis[1], v[2] - along * axis[2]};
}
std::int64_t steps(double value, double step) { return std::llround(value / step); }

}  // namespace

std::uint32_t LidarBeams::number(const lidar::Shot& shot, int pixel) {
  const bool oriented = plan_.pixels() > 1 || plan_.lidar.transport.sampling == scene::LidarSampling::receiver;
  const Vec3 apart{shot.pupil_m[0] - shot.exit_m[0], shot.pupil_m[1] - shot.exit_m[1],
                   shot.pupil_m[2] - shot.exit_m[2]};
  // First axis across the beam: towards the pupil, else towards its tilt, else along its columns.
  Vec3 x = beside(apart, shot.exit_axis);
  if (dot(x, x) < kLength_m * kLength_m) x = beside(shot.pupil_axis, shot.exit_axis);
  if (dot(x, x) < kAngle_rad * kAngle_rad) x = beside(shot.pupil_u, shot.exit_axis);
  if (dot(x, x) < kAngle_rad * kAngle_rad) x = shot.exit_u;
  x = unit(x);
  const Vec3 y = cross(shot.exit_axis, x);
  const auto turned = [&](const Vec3& v, double step) {
    return std::array<std::int64_t, 3>{steps(dot(v, x), step), steps(dot(v, y), step),
                                       steps(dot(v, shot.exit_axis), step)};
  };
  const auto place = turned(apart, kLength_m), axis = turned(shot.pupil_axis, kAngle_rad),
             columns = oriented ? turned(shot.pupil_u, kAngle_rad) : std::array<std::int64_t, 3>{};
  // Third components follow from the others but for their sign.
  const std::array<std::int64_t, 9> key{place[0],
                                        place[2],
                                        axis[0],
                                        axis[1],
                                        axis[2] < 0 ? 1 : 0,
                                        columns[0],
                                        columns[1],
                                        steps(shot.half_divergence_rad, kAngle_rad),
                                        oriented ? 2 * pixel + (columns[2] < 0 ? 1 : 0) : 0};
  const auto [entry, fresh] = numbers_.try_emplace(key, static_cast<std::uint32_t>(numbers_.size()));
  if (!fresh) return entry->second;
  lidar::Shot own;
  own.exit_axis = {0, 0, 1};
  own.exit_u = {1, 0, 0};
  own.half_divergence_rad = static_cast<double>(key[7]) * kAngle_rad;
  own.pupil_m = {static_cast<double>(place[0]) * kLength_m, 0, static_cast<double>(place[2]) * kLength_m};
  own.pupil_axis = unit(
      scaled({static_cast<double>(axis[0]), static_cast<double>(axis[1]), static_cast<double>(axis[2])}, kAngle_rad));
  const Vec3 wanted =
      oriented
          ? scaled({static_cast<double>(columns[0]), static_cast<double>(columns[1]), static_cast<double>(columns[2])},
                   kAngle_rad)
      : std::abs(own.pupil_axis[0]) < 0.9 ? Vec3{1, 0, 0}
                                          : Vec3{0, 1, 0};
  own.pupil_u = unit(beside(wanted, own.pupil_axis));
  append_owner(plan_, {}, own, pixel, records_);
  return entry->second;
}

void LidarBeams::clear() {
  numbers_.clear();
  records_.clear();
}

}  // namespace raycube::render
