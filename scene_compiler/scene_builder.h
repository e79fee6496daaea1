// From the records of a simulation file to triangles, placements and surfaces, and on to the compiled scene.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scene_compiler/bvh_builder.h"
#include "scene_compiler/document.h"
#include "scene_compiler/material_table.h"
#include "scene_compiler/memory_sum.h"
#include "scene_compiler/terrain.h"

namespace raycube::scene {

struct NamedMesh {
  std::string name;
  TriangleMesh mesh;
  std::array<double, 3> centre_m{};  ///< of the mesh's own frame: its vertices count from there (MeshFile::centre_m)
};

struct Placed {
  std::uint32_t mesh = 0;                    ///< index into SceneParts::meshes
  std::array<double, 12> scene_from_mesh{};  ///< row-major 3 x 4
};

/// Everything a scene is made of, before trees are built.
struct SceneParts {
  Origin origin;
  std::vector<NamedMesh> meshes;
  std::vector<Placed> placed;  ///< in file order: terrains, planes, boxes, instances, scatters
  std::vector<Volume> volumes;
  std::vector<TerrainGrid> terrains;
  std::optional<std::array<double, 2>> cell_m;  ///< of a scene that repeats: width and length
  int cell_copies = 0;                          ///< of it to each of its four sides
  bool terrains_whole = true;  ///< false: one could not be read and has been reported; heights say nothing
  std::vector<std::vector<int>> terrain_classes;  ///< class of each cell; empty without class map
  std::vector<int> terrain_refine;                ///< into how many along each side its triangles cut a cell
  std::vector<std::string> notices;               ///< dropped faces, meshes never placed
  MemorySum memory;                               ///< of all that is to be built

  /// Height of the highest terrain at a point, or nullopt off all of them.
  std::optional<double> terrain_height_m(double x_m, double y_m) const;
};

/// Reads all files the records name. Problems are collected, nothing is thrown.
SceneParts read_scene_parts(const Record& root, MaterialTable& materials, base::Problems& problems);

// One per kind of entry; each appends to parts.
void add_terrains(const Record& root, MaterialTable& materials, SceneParts& parts, base::Problems& problems);
void add_panels(const Record& root, MaterialTable& materials, SceneParts& parts, base::Problems& problems);
void add_meshes_and_instances(const Record& root, MaterialTable& materials, SceneParts& parts,
                              base::Problems& problems);

void add_volumes(const Record& root, SceneParts& parts, base::Problems& problems);
/// `position_m` of a record, on the terrain where `on_terrain` says so.
std::array<double, 3> position_of(const Record& record, const SceneParts& parts, base::Problems& problems);

/// Builds trees and the content hash. Precondition: read_scene_parts found no problem.
CompiledScene compile_scene(SceneParts&& parts, MaterialTable&& materials, TreeSharing sharing = TreeSharing::together);

inline constexpr std::array<double, 12> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

}  // namespace raycube::scene
