// Two-level BVH: triangles regrouped into full blocks of 16 by a median split, 8-wide trees over blocks and over
// instances from Embree's rtcBuildBVH.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// A triangle soup in one mesh frame, before blocks are made.
struct TriangleMesh {
  std::vector<std::array<float, 3>> vertices;           ///< m
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< vertex indices, counter-clockwise seen from outside
  std::vector<std::uint32_t> surface;                   ///< per triangle: index into CompiledScene::surfaces
  std::vector<std::uint32_t> user_face;                 ///< per triangle: face number in the user's file
};

/// Appends a mesh's blocks and tree to the scene and returns its index in scene.meshes. Precondition: finite vertices,
/// indices in range, at least one triangle of non-zero area. Throws Error(bug) when a precondition does not hold.
std::uint32_t append_mesh(CompiledScene& scene, const std::string& name, const TriangleMesh& mesh);

/// Appends an instance (row-major 3 x 4 world_from_local, double). The inverse is computed in double and both are
/// rounded once. Throws Error(input) when the matrix is singular or not finite.
void append_instance(CompiledScene& scene, std::uint32_t mesh, const std::array<double, 12>& world_from_local,
                     std::uint32_t id);

/// Builds the top tree over the instances into scene.nodes[0..] (mesh roots and children are renumbered), sets bounds
/// and top_depth. Call once, after the last instance.
void finish_top_tree(CompiledScene& scene);

}  // namespace raycube::scene
