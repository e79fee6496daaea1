#include "scene_compiler/owner.h"

#include <algorithm>
#include <tuple>

namespace raycube::scene {

namespace {

/// The mesh of a tree that stands so many places behind the tree's first.
std::uint32_t mesh_of(const CompiledScene& scene, const Tree& tree, std::uint32_t placed_after) {
  return *std::lower_bound(
      tree.meshes.begin(), tree.meshes.end(), placed_after,
      [&](std::uint32_t mesh, std::uint32_t after) { return scene.meshes[mesh].placed_after < after; });
}

}  // namespace

Owner owner_of(const CompiledScene& scene, std::uint32_t instance, std::uint32_t primitive) {
  const shared::Instance& placed = scene.instances[instance];
  const shared::TriBlock& block = scene.blocks[primitive / RC_BLOCK];
  const std::uint32_t lane = primitive % RC_BLOCK, after = block.placed_after[lane], triangle = block.triangle[lane];
  const std::uint32_t mesh = mesh_of(scene, scene.trees[placed.tree], after);
  return {placed.placement + after, mesh, triangle, scene.meshes[mesh].user_face[triangle]};
}

bool user_before(const CompiledScene& scene, std::uint32_t instance, std::uint32_t primitive,
                 std::uint32_t than_instance, std::uint32_t than_primitive) {
  if (than_instance == RC_NONE || instance == RC_NONE) return instance != RC_NONE;
  const auto place = [&](std::uint32_t i, std::uint32_t p) {
    const shared::TriBlock& block = scene.blocks[p / RC_BLOCK];
    return std::tuple{scene.instances[i].placement + block.placed_after[p % RC_BLOCK], block.triangle[p % RC_BLOCK]};
  };
  return place(instance, primitive) < place(than_instance, than_primitive);
}

std::vector<Placement> placements(const CompiledScene& scene) {
  std::vector<Placement> out;
  for (std::uint32_t i = 0; i < scene.instances.size(); ++i)
    for (const std::uint32_t mesh : scene.trees[scene.instances[i].tree].meshes)
      out.push_back({scene.instances[i].placement + scene.meshes[mesh].placed_after, i, mesh});
  std::sort(out.begin(), out.end(), [](const Placement& a, const Placement& b) { return a.number < b.number; });
  return out;
}

MeshTriangles::MeshTriangles(const CompiledScene& scene) : first_(scene.meshes.size() + 1, 0) {
  for (std::size_t mesh = 0; mesh < scene.meshes.size(); ++mesh)
    first_[mesh + 1] = first_[mesh] + scene.meshes[mesh].triangle_count();
  primitive_.resize(first_.back()), surface_.resize(first_.back());
  for (const Tree& tree : scene.trees)
    for (std::uint32_t p = tree.first_block * RC_BLOCK; p < (tree.first_block + tree.block_count) * RC_BLOCK; ++p) {
      const shared::TriBlock& block = scene.blocks[p / RC_BLOCK];
      const std::uint32_t lane = p % RC_BLOCK;
      if (block.surface[lane] == RC_NONE) continue;
      const std::size_t at = first_[mesh_of(scene, tree, block.placed_after[lane])] + block.triangle[lane];
      primitive_[at] = p, surface_[at] = block.surface[lane];
    }
}

}  // namespace raycube::scene
