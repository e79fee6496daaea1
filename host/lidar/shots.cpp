#include <algorithm>
#include <cmath>
#include <optional>

#include "host/base/attitude.h"
#include "host/lidar/shot.h"
#include "kernels/sampling/sampler.h"
#include "host/base/units.h"

namespace raycube::lidar {
namespace {

constexpr unsigned kTurnDimension = 101;  ///< of rc_hash: the footprint's turn

/// Columns: where the x, y and z of the inner frame point in the outer one.
struct Turn {
  Vec3 x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
  Vec3 operator()(const Vec3& v) const {
    Vec3 out{};
    for (std::size_t i = 0; i < 3; ++i) out[i] = v[0] * x[i] + v[1] * y[i] + v[2] * z[i];
    return out;
  }
  Turn operator*(const Turn& inner) const { return {(*this)(inner.x), (*this)(inner.y), (*this)(inner.z)}; }
};

/// -z towards +x.
Turn across(double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {{c, 0, s}, {0, 1, 0}, {-s, 0, c}};
}

/// -z towards +y.
Turn along(double angle_rad) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {{1, 0, 0}, {0, c, s}, {0, -s, c}};
}

/// The shortest turn that takes -z away by `angle_rad`, towards +y turned by `azimuth_rad` to the right: the instrument
/// does not roll about its axis.
Turn lean(double angle_rad, double azimuth_rad) {
  const double ca = std::cos(azimuth_rad), sa = std::sin(azimuth_rad);
  const Turn to{{ca, -sa, 0}, {sa, ca, 0}, {0, 0, 1}}, back{{ca, sa, 0}, {-sa, ca, 0}, {0, 0, 1}};
  return to * along(angle_rad) * back;
}

/// Scene (x east, y north, z up) from platform (x right, y forward, z up): yaw, pitch, roll (z-y-x, intrinsic), as
/// instruments have it.
Turn scene_from_platform(const scene::LidarPose& pose) {
  const double ch = std::cos(base::rad_from_deg(pose.heading_deg)), sh = std::sin(base::rad_from_deg(pose.heading_deg));
  const double cp = std::cos(base::rad_from_deg(pose.pitch_deg)), sp = std::sin(base::rad_from_deg(pose.pitch_deg));
  const double cr = std::cos(base::rad_from_deg(pose.roll_deg)), sr = std::sin(base::rad_from_deg(pose.roll_deg));
  return {{cr * ch + sr * sp * sh, -cr * sh + sr * sp * ch, -sr * cp},
          {cp * sh, cp * ch, sp},
          {sr * ch - cr * sp * sh, -sr * sh - cr * sp * ch, cr * cp}};
}

base::Attitude attitude_of(const scene::LidarPose& pose) { return {pose.roll_deg, pose.pitch_deg, pose.heading_deg}; }

scene::LidarPose pose_at(const std::vector<scene::LidarPose>& poses, double time_s) {
  const auto after = std::upper_bound(poses.begin(), poses.end(), time_s,
                                      [](double t, const scene::LidarPose& pose) { return t < pose.time_s; });
  if (after == poses.begin()) return poses.front();
  if (after == poses.end()) return poses.back();
  const scene::LidarPose &a = *(after - 1), &b = *after;
  const double share = (time_s - a.time_s) / (b.time_s - a.time_s);
  const base::Attitude turned = base::attitude_between(attitude_of(a), attitude_of(b), share);
  return {time_s,
          a.x_m + share * (b.x_m - a.x_m),
          a.y_m + share * (b.y_m - a.y_m),
          a.z_m + share * (b.z_m - a.z_m),
          turned.roll_deg,
          turned.pitch_deg,
          turned.heading_deg};
}

/// How the scanner turns a mount's boresight for a pulse; nullopt: it does not fire. Phases count from pulse 0, so they
/// stay exact on any clock.
std::optional<Turn> scan_turn(const scene::Lidar& lidar, std::int64_t pulse) {
  const scene::LidarScan& scan = lidar.scan;
  const double cycles = scan.scan_rate_hz * static_cast<double>(pulse) / lidar.prf_hz,
               phase = cycles - std::floor(cycles);
  switch (scan.pattern) {
    case scene::ScanPattern::fixed:
      break;
    case scene::ScanPattern::line:
      return across(scan.half_angle_rad * (2 * phase - 1));
    case scene::ScanPattern::oscillating:
      return across(scan.half_angle_rad * std::sin(2 * M_PI * phase));
    case scene::ScanPattern::rotating: {
      const double angle_rad = 2 * M_PI * (phase < 0.5 ? phase : phase - 1);
      if (std::abs(angle_rad) > scan.half_angle_rad) return std::nullopt;
      return across(angle_rad);
    }
    case scene::ScanPattern::palmer:
      return lean(scan.half_angle_rad, 2 * M_PI * phase);
    case scene::ScanPattern::raster: {
      const std::int64_t place = pulse % (std::int64_t{scan.columns} * scan.rows);
      return along(scan.step_rad * (static_cast<double>(place / scan.columns) - 0.5 * (scan.rows - 1))) *
             across(scan.step_rad * (static_cast<double>(place % scan.columns) - 0.5 * (scan.columns - 1)));
    }
  }
  return Turn{};
}

/// Platform from mount: tilted across, then along.
Turn platform_from_mount(const scene::LidarMount& mount) {
  return along(mount.tilt_along_rad) * across(mount.tilt_across_rad);
}

Vec3 placed(const scene::LidarPose& pose, const Turn& scene_from_platform, const scene::LidarMount& mount) {
  const Vec3 lever = scene_from_platform({mount.offset_m[0], mount.offset_m[1], mount.offset_m[2]});
  return {pose.x_m + lever[0], pose.y_m + lever[1], pose.z_m + lever[2]};
}

Vec3 minus(const Vec3& v) { return {-v[0], -v[1], -v[2]}; }

double footprint_turn_rad(std::uint64_t seed, std::uint64_t key) {
  const auto bits = rc_hash(static_cast<rc_u32>(seed ^ (seed >> 32)), static_cast<rc_u32>(key), 0u, kTurnDimension);
  return 2 * M_PI * static_cast<double>(rc_unit_float(bits));
}

}  // namespace

std::vector<Shot> make_shots(const scene::Lidar& lidar, std::int64_t first, std::int64_t count, std::uint64_t seed) {
  std::vector<Shot> shots;
  const Turn transmitter = platform_from_mount(lidar.transmitter), receiver = platform_from_mount(lidar.receiver_mount);
  const auto pixels =
      static_cast<std::uint64_t>(lidar.receiver.columns) * static_cast<std::uint64_t>(lidar.receiver.rows);
  for (std::int64_t pulse = first; pulse < first + count; ++pulse) {
    const auto scan = scan_turn(lidar, pulse);
    if (!scan) continue;
    Shot& shot = shots.emplace_back();
    shot.pulse = pulse;
    shot.time_s = lidar.first_pulse_s + static_cast<double>(pulse) / lidar.prf_hz;
    const scene::LidarPose pose = pose_at(lidar.trajectory, shot.time_s);
    const Turn platform = scene_from_platform(pose), beam = platform * transmitter * *scan;
    const Turn field = platform * (lidar.receiver.scans_with_beam ? receiver * *scan : receiver);
    shot.exit_m = placed(pose, platform, lidar.transmitter);
    shot.exit_axis = minus(beam.z);
    const double turn_rad = footprint_turn_rad(seed, static_cast<std::uint64_t>(pulse) * pixels),
                 c = std::cos(turn_rad), s = std::sin(turn_rad);
    for (std::size_t i = 0; i < 3; ++i) shot.exit_u[i] = c * beam.x[i] + s * beam.y[i];
    shot.pupil_m = placed(pose, platform, lidar.receiver_mount);
    shot.pupil_axis = minus(field.z);
    shot.pupil_u = field.x;
    shot.half_divergence_rad = lidar.pulse.half_divergence_rad;
    const double heading_rad = base::rad_by_division(pose.heading_deg);
    shot.scan_angle_rad = std::atan2(
        shot.exit_axis[0] * std::cos(heading_rad) - shot.exit_axis[1] * std::sin(heading_rad), -shot.exit_axis[2]);
  }
  return shots;
}

}  // namespace raycube::lidar
