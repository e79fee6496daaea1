// What a compiled scene holds, in numbers.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

struct MeshInfo {
  std::string name;
  std::uint64_t triangles = 0;
  std::uint64_t instances = 0;  ///< times it is placed
  std::uint64_t tree = 0;       ///< which of the trees it lies in
};

/// Meshes that are always placed together.
struct TreeInfo {
  std::uint64_t triangles = 0, meshes = 0;
  std::uint64_t instances = 0;  ///< times it is placed
  std::uint64_t blocks = 0, depth = 0;
};

struct MaterialInfo {
  std::string name, source;
  double first_um = 0, last_um = 0;  ///< range of the reflectance curve
  std::size_t points = 0;
  bool transmits = false;
  bool plate = false, gloss = false;
  std::string shape;        ///< how it reflects: a name of kernels/materials
  std::size_t spectra = 1;  ///< members of its family
};

struct VolumeInfo {
  std::string name, shape, gas;      ///< gas empty: none
  double first_um = 0, last_um = 0;  ///< range of its cross sections
  bool particles = false;
};

struct SceneInfo {
  std::string content_hash;
  Origin origin;
  std::array<float, 3> lo{}, hi{};
  std::uint64_t triangles = 0;         ///< stored
  std::uint64_t placed_triangles = 0;  ///< counted once per instance
  std::uint64_t instances = 0;         ///< meshes as the user placed them
  std::uint64_t surfaces = 0, nodes = 0, blocks = 0, stack_bound = 0;
  std::uint64_t bytes = 0;        ///< device buffers: blocks, nodes, placed trees, surfaces
  double bytes_per_triangle = 0;  ///< blocks and their trees' nodes, per stored triangle
  double bytes_per_instance = 0;  ///< placed trees and top-tree nodes, per instance
  double block_fill = 0;          ///< used lanes over all lanes
  std::vector<MeshInfo> meshes;
  std::vector<TreeInfo> trees;
  std::vector<MaterialInfo> materials;
  std::vector<VolumeInfo> volumes;
};

SceneInfo scene_info(const CompiledScene& scene);
std::string scene_info_text(const SceneInfo& info);
std::string scene_info_json(const SceneInfo& info);

}  // namespace raycube::scene
