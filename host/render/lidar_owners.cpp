#include "host/render/lidar_owners.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "host/base/units.h"
#include "kernels/lidar/layout.h"

namespace raycube::render {

namespace {

using lidar::cross;
using lidar::dot;
using lidar::length;
using lidar::Vec3;

Vec3 plus(const Vec3& a, double f, const Vec3& b) { return {a[0] + f * b[0], a[1] + f * b[1], a[2] + f * b[2]}; }
Vec3 minus(const Vec3& a, const Vec3& b) { return plus(a, -1, b); }
shared::rc_float4 pack(const Vec3& v, double w = 0) {
  return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), static_cast<float>(w)};
}

double diagonal(const scene::CompiledScene& scene) {
  if (scene.lo[0] > scene.hi[0]) return 0;
  return length(
      {double(scene.hi[0]) - scene.lo[0], double(scene.hi[1]) - scene.lo[1], double(scene.hi[2]) - scene.lo[2]});
}

/// Where a ray enters the scene's box, in units of its direction; a ray that misses it: the plane across it before the
/// scene.
double entry(const scene::CompiledScene& scene, const Vec3& at, const Vec3& way) {
  if (scene.lo[0] > scene.hi[0]) return 0;
  double enter = 0, leave = std::numeric_limits<double>::infinity();
  Vec3 centre;
  for (std::size_t i = 0; i < 3; ++i) {
    const double lo = scene.lo[i], hi = scene.hi[i];
    centre[i] = 0.5 * (lo + hi);
    if (way[i] == 0) {
      if (at[i] < lo || at[i] > hi) leave = -1;
      continue;
    }
    const double a = (lo - at[i]) / way[i], b = (hi - at[i]) / way[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  if (enter <= leave) return enter;
  return std::max(0.0, (dot(minus(centre, at), way) / length(way) - 0.5 * diagonal(scene)) / length(way));
}

}  // namespace

double camera_factor(const scene::LidarReceiver& receiver) {
  if (!receiver.tangent_aperture || receiver.focal_length_m == 0) return 1;
  const double f_number = receiver.focal_length_m / (2 * receiver.aperture_radius_m), square = 4 * f_number * f_number;
  return square / (1 + square);
}

void append_owner(const lidar::LidarPlan& plan, const scene::CompiledScene& scene, const lidar::Shot& shot, int pixel,
                  std::vector<shared::rc_float4>& records) {
  const scene::Lidar& lidar = plan.lidar;
  const bool receiver = lidar.transport.sampling == scene::LidarSampling::receiver;
  const double spread = std::tan(shot.half_divergence_rad), pitch = lidar.receiver.pixel_pitch_rad;
  const Vec3 exit_v = cross(shot.exit_axis, shot.exit_u), pupil_v = cross(shot.pupil_axis, shot.pupil_u);
  const Vec3 &start = receiver ? shot.pupil_m : shot.exit_m, &end = receiver ? shot.exit_m : shot.pupil_m;
  Vec3 axis = receiver ? shot.pupil_axis : shot.exit_axis;
  if (receiver) {
    const int column = pixel % lidar.receiver.columns, row = pixel / lidar.receiver.columns;
    axis = plus(axis, (column + 0.5 - 0.5 * lidar.receiver.columns) * pitch, shot.pupil_u);
    axis = plus(axis, (row + 0.5 - 0.5 * lidar.receiver.rows) * pitch, pupil_v);
  }
  const double s = entry(scene, start, axis);
  const Vec3 reference = plus(start, s, axis),
             rounded{static_cast<float>(reference[0]), static_cast<float>(reference[1]),
                     static_cast<float>(reference[2])};
  const Vec3 from_start = minus(reference, start), from_end = minus(reference, end);

  const double radius = lidar.receiver.aperture_radius_m, hidden = lidar.receiver.obscuration_radius_m;
  double weight = M_PI * (radius * radius - hidden * hidden) * camera_factor(lidar.receiver) *
                  lidar.receiver.efficiency * shot.gain / lidar.transport.subrays;
  if (receiver) weight *= pitch * pitch;

  const double position =
      ((length(from_start) + length(from_end)) * lidar.transport.group_index / base::kLightSpeed_m_s -
       lidar.gate.start_s) /
      lidar.gate.bin_s;
  const double bin = std::clamp(std::floor(position), -1e9, 1e9);
  const std::uint32_t key = lidar::draw_key(plan, shot.pulse, pixel);

  const double step = receiver ? pitch : spread;
  const Vec3 nil{};
  const std::size_t first = records.size();
  records.resize(first + RC_SHOT_FLOAT4S);
  shared::rc_float4* at = records.data() + first;
  at[RC_SHOT_START] = pack(start, s);
  at[RC_SHOT_AXIS] = pack(axis, shot.exit_m == shot.pupil_m ? 1 : 0);
  at[RC_SHOT_DU] = pack(plus(nil, step, receiver ? shot.pupil_u : shot.exit_u), weight);
  at[RC_SHOT_DV] = pack(plus(nil, step, receiver ? pupil_v : exit_v));
  at[RC_SHOT_REFERENCE] = pack(rounded, std::min(s, 2 * diagonal(scene)));
  at[RC_SHOT_RESIDUAL] = pack(minus(reference, rounded));
  at[RC_SHOT_FROM_START] = pack(from_start, length(from_start));
  at[RC_SHOT_FROM_END] = pack(from_end, length(from_end));
  at[RC_SHOT_END_AXIS] = pack(receiver ? shot.exit_axis : shot.pupil_axis, lidar.pulse.exit_radius_m);
  at[RC_SHOT_END_U] = pack(shot.pupil_u, spread);
  at[RC_SHOT_END_V] = pack(pupil_v);
  at[RC_SHOT_START_AXIS] = pack(receiver ? shot.pupil_axis : shot.exit_axis);
  at[RC_SHOT_EXIT_U] = pack(plus(nil, lidar.pulse.exit_radius_m, shot.exit_u));
  at[RC_SHOT_EXIT_V] = pack(plus(nil, lidar.pulse.exit_radius_m, exit_v));
  // Where the ray is when the gate opens; its whole way cannot be shorter than the two ends are apart.
  const Vec3 way = plus(nil, 1 / length(axis), axis), apart = minus(start, end);
  const double gate_way = lidar.gate.start_s * base::kLightSpeed_m_s / lidar.transport.group_index,
               bin_way = lidar.gate.bin_s * base::kLightSpeed_m_s / lidar.transport.group_index;
  const double along = dot(apart, way), squared = dot(apart, apart), whole = std::max(gate_way, std::sqrt(squared));
  const double past = whole + along > 0 ? std::max(0.0, (whole * whole - squared) / (2 * (whole + along))) : 0;
  at[RC_SHOT_GATE] = pack(plus(start, past, way), past);
  at[RC_SHOT_GATE_WAY] = {static_cast<float>(whole), static_cast<float>((whole - gate_way) / bin_way), 0, 0};
  at[RC_SHOT_TIME] = {std::bit_cast<float>(static_cast<std::int32_t>(bin)), static_cast<float>(position - bin),
                      std::bit_cast<float>(key), 0};
}

}  // namespace raycube::render
