// Whose a triangle is. Trees and the triangles in them are numbered as rays find them; users number what they place,
// its meshes and their faces. This table, from (placed tree, primitive) to the user's numbers, is the only way from the
// first to the second: for ties, truth, LIDAR truth, LAS object_id and whatever is told of a mesh or a facet.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

struct Owner {
  std::uint32_t placement = 0;  ///< the user's number of what was placed, in file order
  std::uint32_t mesh = 0;       ///< index into CompiledScene::meshes
  std::uint32_t triangle = 0;   ///< its number in that mesh
  std::uint32_t face = 0;       ///< its face in the user's file
};

/// Precondition: primitive = block * RC_BLOCK + lane names a triangle of the instance's tree.
Owner owner_of(const CompiledScene& scene, std::uint32_t instance, std::uint32_t primitive);

/// Which of two hits at one distance is taken: the one placed earlier, in one placement the triangle that stands
/// earlier in its mesh; any before none (RC_NONE). Kernels do the same: rc_user_before, kernels/geometry/user_order.h.
bool user_before(const CompiledScene& scene, std::uint32_t instance, std::uint32_t primitive,
                 std::uint32_t than_instance, std::uint32_t than_primitive);

/// One mesh as the user placed it.
struct Placement {
  std::uint32_t number = 0;    ///< the user's, in file order
  std::uint32_t instance = 0;  ///< index into CompiledScene::instances: the tree it is placed with
  std::uint32_t mesh = 0;      ///< index into CompiledScene::meshes
};

/// All of them, by their numbers, ascending.
std::vector<Placement> placements(const CompiledScene& scene);

/// Primitives of the triangles of every mesh, in the user's order: what is summed or told over a mesh does not depend
/// on how its tree was made.
class MeshTriangles {
 public:
  explicit MeshTriangles(const CompiledScene& scene);
  std::span<const std::uint32_t> of(std::uint32_t mesh) const {
    return {primitive_.data() + first_[mesh], first_[mesh + 1] - first_[mesh]};
  }
  /// Their surfaces.
  std::span<const std::uint32_t> surfaces_of(std::uint32_t mesh) const {
    return {surface_.data() + first_[mesh], first_[mesh + 1] - first_[mesh]};
  }

 private:
  std::vector<std::size_t> first_;  ///< [mesh], and the end
  std::vector<std::uint32_t> primitive_, surface_;
};

}  // namespace raycube::scene
