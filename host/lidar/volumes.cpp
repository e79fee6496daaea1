#include "host/lidar/volumes.h"

#include <algorithm>
#include <cmath>

#include "kernels/lidar/volume.h"
#include "scene_compiler/plume_width.h"
#include "host/base/units.h"

namespace raycube::lidar {
namespace {

constexpr double kAvogadro = 6.02214076e23;
constexpr double kMoleculesPerPpmM3 = kMoleculesPerPpmM * 1e4;  ///< per m3 at 1 ppm

float f(double value) { return static_cast<float>(value); }

void flatten_plume(const scene::Volume& volume, shared::LidarVolume& out) {
  const double end = volume.length_m;
  const double side = scene::plume_side_m(volume), rise = scene::plume_rise_m(volume);
  out.place.w = f(volume.release_height_m);
  out.lo.x = f(-side), out.lo.y = 0, out.lo.z = f(std::max(volume.release_height_m - rise, 0.0));
  out.hi.x = f(side), out.hi.y = f(end), out.hi.z = f(volume.release_height_m + rise);
  // g/m3 to ppm: molecules per m3 over those of 1 ppm.
  out.strength = {f(kAvogadro / volume.molar_mass_g / kMoleculesPerPpmM3),
                  f(volume.source_g_s / (2 * M_PI * volume.wind_m_s)), 0, 0};
  out.spread = {f(volume.sigma_y_a), f(volume.sigma_y_b), f(volume.sigma_z_a), f(volume.sigma_z_b)};
  // The law a x / sqrt(1 + b x) is steepest at x = 0, with slope a (b >= 0).
  out.fixed = {f(volume.sigma_y_m), f(volume.sigma_z_m), f(volume.sigma_y_m > 0 ? 0 : volume.sigma_y_a),
               f(volume.sigma_z_m > 0 ? 0 : volume.sigma_z_a)};
}

}  // namespace

FlatVolumes flatten_volumes(const std::vector<scene::Volume>& volumes) {
  FlatVolumes flat;
  for (const scene::Volume& volume : volumes) {
    shared::LidarVolume& out = flat.volumes.emplace_back();
    out.place = {f(volume.position_m[0]), f(volume.position_m[1]), f(volume.position_m[2]), 0};
    out.lo = {f(-0.5 * volume.size_m[0]), f(-0.5 * volume.size_m[1]), 0,
              f(std::cos(base::rad_by_division(volume.yaw_deg)))};
    out.hi = {f(0.5 * volume.size_m[0]), f(0.5 * volume.size_m[1]), f(volume.size_m[2]),
              f(std::sin(base::rad_by_division(volume.yaw_deg)))};
    out.strength = {f(volume.concentration_ppm), 0, 0, 0};
    out.particles = {f(volume.extinction_per_m), 0, f(volume.lidar_ratio_sr), 0};
    out.gas = volume.gas.empty() ? 0 : 1;
    if (volume.shape == scene::Volume::Shape::plume) {
      out.shape = RC_VOLUME_PLUME;
      flatten_plume(volume, out);
    } else if (volume.shape == scene::Volume::Shape::grid) {
      out.shape = RC_VOLUME_GRID;
      for (std::size_t i = 0; i < 3; ++i) out.cells[i] = static_cast<std::uint32_t>(volume.cells[i]);
      out.first_value = static_cast<std::uint32_t>(flat.values.size());
      flat.values.insert(flat.values.end(), volume.values.begin(), volume.values.end());
    }
  }
  return flat;
}

double volume_path(const FlatVolumes& flat, std::size_t volume, const std::array<double, 3>& from_m,
                   const std::array<double, 3>& to_m) {
  const double dx = to_m[0] - from_m[0], dy = to_m[1] - from_m[1], dz = to_m[2] - from_m[2],
               length = std::sqrt(dx * dx + dy * dy + dz * dz);
  if (!(length > 0)) return 0;
  // Measured from the end, which is near the volume; the start can be kilometres away.
  const shared::rc_float4 origin{f(to_m[0]), f(to_m[1]), f(to_m[2]), 0},
      way{f(dx / length), f(dy / length), f(dz / length), 0};
  return shared::rc_volume_path(&flat.volumes[volume], flat.values.data(), origin, way, f(-length), 0);
}

}  // namespace raycube::lidar
