// One pulse as it is fired: exit, axis and field of view in the scene frame, in double, with what was drawn for it.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene_compiler/lidar_spec.h"
#include "host/lidar/vec3.h"

namespace raycube::lidar {

/// Frame: the scene's (x east, y north, z up), metres. Directions are unit vectors; u is perpendicular to its axis and
/// v = axis x u.
struct Shot {
  std::int64_t pulse = 0;                   ///< number in the survey, from 0
  double time_s = 0;                        ///< of emission, on the trajectory's clock
  Vec3 exit_m{}, exit_axis{}, exit_u{};     ///< transmitter; u carries the footprint's random turn about the axis
  Vec3 pupil_m{}, pupil_axis{}, pupil_u{};  ///< receiver; u: direction of the array's columns
  double half_divergence_rad = 0;           ///< 1/e2 or edge, turbulence included
  double gain = 1;                          ///< scintillation: factor on all that is received
  std::vector<double> line_gain;            ///< and on what is received of each line; empty: 1
  double scan_angle_rad =
      0;  ///< of the axis from the nadir, across the heading, right positive; roll and tilt included
};

/// Shots first .. first + count - 1 of the survey, nothing drawn yet but the footprint's turn (by `seed` and pulse
/// number). Poses are interpolated linearly in time (angles along the shorter way); times before and after the
/// trajectory keep its ends. Pulses a scanner does not fire are left out, so fewer may come; `pulse` tells which.
/// A mount is tilted across, then along (about the platform's own axes); the scan turns it about the tilted ones. Scan
/// phases count from pulse 0. A raster goes through its directions again and again. Array: u points right, v = axis x u
/// backwards, so row 0 of a level array lies in front.
std::vector<Shot> make_shots(const scene::Lidar& lidar, std::int64_t first, std::int64_t count, std::uint64_t seed);

}  // namespace raycube::lidar
