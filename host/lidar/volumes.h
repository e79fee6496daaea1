// Volumes as the device has them.
#pragma once

#include <array>
#include <vector>

#include "kernels/shared/structs.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::lidar {

/// 1 ppm m in molecules per cm2: p / (k T) at 296 K and 101325 Pa (LIDAR specification, 6.1).
inline constexpr double kMoleculesPerPpmM = 2.479371580e15;

struct FlatVolumes {
  std::vector<shared::LidarVolume> volumes;  ///< in the scene's order
  std::vector<float> values;                 ///< of all grids, one after the other
};

/// Constants of kernels/lidar/volume.h, computed in double and rounded once.
FlatVolumes flatten_volumes(const std::vector<scene::Volume>& volumes);

/// Integral of a volume's field from a point to another (scene frame), m; a plume: g/m2. As the device has it, single
/// precision.
double volume_path(const FlatVolumes& flat, std::size_t volume, const std::array<double, 3>& from_m,
                   const std::array<double, 3>& to_m);

}  // namespace raycube::lidar
