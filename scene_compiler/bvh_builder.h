// Two-level BVH: triangles regrouped into full blocks of 16 (block_order.h), 8-wide trees over blocks and over
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

/// A mesh of a tree: its index in scene.meshes, where it stands in the user's list (Mesh::placed_after), its triangles.
/// `spent`: the same where they may go, which they do before the tree's nodes are built; else null.
struct TreeMember {
  std::uint32_t mesh = 0, placed_after = 0;
  const TriangleMesh* triangles = nullptr;
  TriangleMesh* spent = nullptr;
};

/// Appends the blocks and the BVH of meshes that share a tree, fills in what their entries in scene.meshes lack beside
/// the name, and returns the tree's index. Precondition: members by placed_after, ascending from 0; of each: finite
/// vertices, indices in range, at least one triangle of non-zero area. Throws Error(bug) when a precondition does not
/// hold.
std::uint32_t append_tree(CompiledScene& scene, const std::vector<TreeMember>& members);

/// Appends a mesh and a tree of its own, and returns its index. Where every mesh is appended so, trees and meshes have
/// the same numbers.
std::uint32_t append_mesh(CompiledScene& scene, const std::string& name, const TriangleMesh& mesh);

/// Appends a placed tree (row-major 3 x 4 world_from_local, double). The inverse is computed in double and both are
/// rounded once. `placement`: the user's number of the tree's first mesh as placed here; no two meshes may have one
/// number. Throws Error(input) when the matrix is singular or not finite.
void append_instance(CompiledScene& scene, std::uint32_t tree, const std::array<double, 12>& world_from_local,
                     std::uint32_t placement);

/// Builds the top tree over the placed trees into scene.nodes[0..] (roots and children of trees are renumbered), sets
/// bounds and top_depth, and surveys the ground's skyline (skyline.h). Call once, after the last instance.
void finish_top_tree(CompiledScene& scene);

}  // namespace raycube::scene
