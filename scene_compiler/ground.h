// The ground below any place of a scene, for what counts heights from it.
#pragma once

#include <vector>

#include "scene_compiler/terrain.h"

namespace raycube::scene {

/// Heights of a scene's terrains. Things that stand on them (trees, roofs, meshes) are not ground.
class Ground {
 public:
  explicit Ground(std::vector<TerrainGrid> terrains) : terrains_(std::move(terrains)) {}

  /// Local z of the ground at local x, y, m: the highest terrain there; off all of them the edge of the
  /// nearest one; z = 0 in a scene without terrain.
  double z_m(double x_m, double y_m) const;

 private:
  std::vector<TerrainGrid> terrains_;
};

}  // namespace raycube::scene
