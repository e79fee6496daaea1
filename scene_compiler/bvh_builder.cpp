#include "scene_compiler/bvh_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "host/base/error.h"
#include "scene_compiler/block_order.h"
#include "scene_compiler/bvh_tree.h"
#include "scene_compiler/skyline.h"

namespace raycube::scene {
namespace {

using base::Error;
using base::Fault;
using detail::Box;

constexpr std::uint32_t kBlock = RC_BLOCK;
constexpr std::uint32_t kMaxDepth = 64;  // a traversal stack of 7 * 64 + 8 words is the most a kernel gets

void require(bool holds, const std::string& mesh, const char* what) {
  if (!holds) throw Error(Fault::bug, "mesh '" + mesh + "' reached the BVH builder with " + what);
}

void set_vertex(float (&x)[16], float (&y)[16], float (&z)[16], std::uint32_t lane, const std::array<float, 3>& v) {
  x[lane] = v[0], y[lane] = v[1], z[lane] = v[2];
}

// Inverse of a row-major 3 x 4 affine map by cofactors; false when singular or not finite.
bool invert(const std::array<double, 12>& m, std::array<double, 12>& inverse) {
  const double c00 = m[5] * m[10] - m[6] * m[9], c01 = m[6] * m[8] - m[4] * m[10], c02 = m[4] * m[9] - m[5] * m[8];
  const double determinant = m[0] * c00 + m[1] * c01 + m[2] * c02;
  const double r = 1.0 / determinant;
  inverse = {c00 * r, (m[2] * m[9] - m[1] * m[10]) * r, (m[1] * m[6] - m[2] * m[5]) * r, 0,
             c01 * r, (m[0] * m[10] - m[2] * m[8]) * r, (m[2] * m[4] - m[0] * m[6]) * r, 0,
             c02 * r, (m[1] * m[8] - m[0] * m[9]) * r,  (m[0] * m[5] - m[1] * m[4]) * r, 0};
  for (int i = 0; i < 3; ++i)
    inverse[4 * i + 3] = -(inverse[4 * i] * m[3] + inverse[4 * i + 1] * m[7] + inverse[4 * i + 2] * m[11]);
  const auto fits = [](double value) { return std::isfinite(static_cast<float>(value)); };
  return std::all_of(m.begin(), m.end(), fits) && std::all_of(inverse.begin(), inverse.end(), fits);
}

shared::rc_float4 row(const std::array<double, 12>& m, int i) {
  return {static_cast<float>(m[4 * i]), static_cast<float>(m[4 * i + 1]), static_cast<float>(m[4 * i + 2]),
          static_cast<float>(m[4 * i + 3])};
}

// World box of a placed tree, or of one of its meshes: the eight corners of its bounds through the stored matrix in
// double, grown by what the rounded matrices can move a point (16 ulp of the sums involved), so that no local hit lies
// outside.
Box world_box(const shared::Instance& instance, const std::array<float, 3>& from, const std::array<float, 3>& to) {
  const shared::rc_float4* w = &instance.world_from_local_0;
  const shared::rc_float4* l = &instance.local_from_world_0;
  double reach = 0;  // largest |world coordinate| of the corners
  double lo[3], hi[3], size[3];
  for (int i = 0; i < 3; ++i) {
    lo[i] = std::numeric_limits<double>::max(), hi[i] = -lo[i], size[i] = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const double x = corner & 1 ? to[0] : from[0], y = corner & 2 ? to[1] : from[1];
      const double z = corner & 4 ? to[2] : from[2];
      const double value = w[i].x * x + w[i].y * y + w[i].z * z + w[i].w;
      lo[i] = std::min(lo[i], value), hi[i] = std::max(hi[i], value);
      size[i] =
          std::max(size[i], std::abs(w[i].x * x) + std::abs(w[i].y * y) + std::abs(w[i].z * z) + std::abs(w[i].w));
    }
    reach = std::max({reach, std::abs(lo[i]), std::abs(hi[i])});
  }
  Box box;
  for (int i = 0; i < 3; ++i) {
    double there_and_back = 0;
    for (int j = 0; j < 3; ++j) {
      const double wij = std::abs(j == 0 ? w[i].x : j == 1 ? w[i].y : w[i].z);
      there_and_back += wij * ((std::abs(l[j].x) + std::abs(l[j].y) + std::abs(l[j].z)) * reach + std::abs(l[j].w));
    }
    const double margin = 16 * 0x1p-24 * (size[i] + there_and_back);
    box.lo[i] = std::nextafter(static_cast<float>(lo[i] - margin), -std::numeric_limits<float>::max());
    box.hi[i] = std::nextafter(static_cast<float>(hi[i] + margin), std::numeric_limits<float>::max());
  }
  return box;
}

// A triangle of a tree: the mesh that it belongs to, and its number there.
struct TreeTriangle {
  const TreeMember* member;
  std::uint32_t number;

  const std::array<float, 3>& corner(int k) const {
    const TriangleMesh& mesh = *member->triangles;
    return mesh.vertices[mesh.triangles[number][k]];
  }
  Box box() const {
    Box out;
    for (int k = 0; k < 3; ++k) out.grow(corner(k));
    return out;
  }
};

// The triangles of a tree, one member after the other.
class TreeTriangles {
 public:
  explicit TreeTriangles(const std::vector<TreeMember>& members) : members_(members) {
    for (const TreeMember& member : members)
      end_.push_back(count() + static_cast<std::uint32_t>(member.triangles->triangles.size()));
  }
  std::uint32_t count() const { return end_.empty() ? 0 : end_.back(); }
  TreeTriangle operator[](std::uint32_t i) const {
    const auto member = static_cast<std::size_t>(std::upper_bound(end_.begin(), end_.end(), i) - end_.begin());
    return {&members_[member], member == 0 ? i : i - end_[member - 1]};
  }

 private:
  const std::vector<TreeMember>& members_;
  std::vector<std::uint32_t> end_;  // of each member's triangles
};

void check_mesh(const TriangleMesh& mesh, const std::string& name) {
  require(!mesh.triangles.empty(), name, "no triangle");
  require(mesh.surface.size() == mesh.triangles.size() && mesh.user_face.size() == mesh.triangles.size(), name,
          "lists of different lengths");
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t vertex : triangle) {
      require(vertex < mesh.vertices.size(), name, "a vertex index out of range");
      for (const float x : mesh.vertices[vertex]) require(std::isfinite(x), name, "a vertex that is not finite");
    }
}

void set_corners(shared::TriBlock& block, std::uint32_t lane, const std::array<float, 3>& v0,
                 const std::array<float, 3>& v1, const std::array<float, 3>& v2) {
  set_vertex(block.v0_x, block.v0_y, block.v0_z, lane, v0);
  set_vertex(block.v1_x, block.v1_y, block.v1_z, lane, v1);
  set_vertex(block.v2_x, block.v2_y, block.v2_z, lane, v2);
}

// Puts a triangle into a lane of its block, whose box grows.
void set_triangle(shared::TriBlock& block, std::uint32_t lane, const TreeTriangle& triangle, Box& box) {
  set_corners(block, lane, triangle.corner(0), triangle.corner(1), triangle.corner(2));
  block.surface[lane] = triangle.member->triangles->surface[triangle.number];
  block.placed_after[lane] = triangle.member->placed_after;
  block.triangle[lane] = triangle.number;
  for (int k = 0; k < 3; ++k) box.grow(triangle.corner(k));
}

// A lane without a triangle repeats the block's first corner.
void set_unused(shared::TriBlock& block, std::uint32_t lane) {
  const std::array<float, 3> point{block.v0_x[0], block.v0_y[0], block.v0_z[0]};
  set_corners(block, lane, point, point, point);
  block.surface[lane] = block.placed_after[lane] = block.triangle[lane] = RC_NONE;
}

// What a mesh's entry says beside its name.
void finish_mesh(Mesh& mesh, const TreeMember& member, std::uint32_t tree) {
  Box bounds;
  for (const auto& triangle : member.triangles->triangles)
    for (const std::uint32_t vertex : triangle) bounds.grow(member.triangles->vertices[vertex]);
  mesh.tree = tree, mesh.placed_after = member.placed_after;
  mesh.lo = bounds.lo, mesh.hi = bounds.hi;
  mesh.user_face = member.spent != nullptr ? std::move(member.spent->user_face) : member.triangles->user_face;
}

// Builds the BVH over a tree's blocks behind the scene's nodes.
void append_nodes(CompiledScene& scene, Tree& tree, const std::vector<Box>& boxes) {
  detail::BoxTree built = detail::build_tree(boxes);
  if (built.depth > kMaxDepth)
    throw Error(Fault::bug,
                "mesh '" + scene.meshes[tree.meshes[0]].name + "': tree of " + std::to_string(built.depth) + " levels");
  tree.depth = built.depth;
  tree.root = static_cast<std::uint32_t>(scene.nodes.size());
  for (shared::BvhNode& node : built.nodes)
    for (std::uint32_t i = 0; i < node.count; ++i)
      node.child[i] += node.leaf_mask >> i & 1u ? tree.first_block : tree.root;
  scene.nodes.insert(scene.nodes.end(), built.nodes.begin(), built.nodes.end());
}

}  // namespace

std::uint32_t append_tree(CompiledScene& scene, const std::vector<TreeMember>& members) {
  for (const TreeMember& member : members) check_mesh(*member.triangles, scene.meshes[member.mesh].name);
  const TreeTriangles triangles(members);
  const std::uint32_t count = triangles.count();
  std::vector<std::uint32_t> order = detail::block_order(count, [&](std::uint32_t i) { return triangles[i].box(); });

  Tree result;
  result.first_block = static_cast<std::uint32_t>(scene.blocks.size());
  result.block_count = (count + kBlock - 1) / kBlock;
  result.triangle_count = count;
  scene.blocks.resize(scene.blocks.size() + result.block_count);
  std::vector<Box> boxes(result.block_count);
  for (std::uint32_t b = 0; b < result.block_count; ++b)
    for (std::uint32_t lane = 0; lane < kBlock; ++lane) {
      const std::uint32_t at = b * kBlock + lane;
      if (at < count)
        set_triangle(scene.blocks[result.first_block + b], lane, triangles[order[at]], boxes[b]);
      else
        set_unused(scene.blocks[result.first_block + b], lane);
    }

  std::vector<std::uint32_t>().swap(order);

  const auto index = static_cast<std::uint32_t>(scene.trees.size());
  Box bounds;
  for (const TreeMember& member : members) {
    finish_mesh(scene.meshes[member.mesh], member, index);
    result.meshes.push_back(member.mesh);
    bounds.grow(scene.meshes[member.mesh].lo);
    bounds.grow(scene.meshes[member.mesh].hi);
    if (member.spent != nullptr) *member.spent = TriangleMesh();
  }
  result.lo = bounds.lo, result.hi = bounds.hi;
  append_nodes(scene, result, boxes);
  scene.trees.push_back(std::move(result));
  return index;
}

std::uint32_t append_mesh(CompiledScene& scene, const std::string& name, const TriangleMesh& mesh) {
  const auto index = static_cast<std::uint32_t>(scene.meshes.size());
  scene.meshes.push_back({name, 0, 0, {}, {}, {}});
  append_tree(scene, {{index, 0, &mesh, nullptr}});
  return index;
}

void append_instance(CompiledScene& scene, std::uint32_t tree, const std::array<double, 12>& world_from_local,
                     std::uint32_t placement) {
  if (tree >= scene.trees.size())
    throw Error(Fault::bug, "placement " + std::to_string(placement) + " of an unknown tree");
  std::array<double, 12> inverse{};
  if (!invert(world_from_local, inverse))
    throw Error(Fault::input,
                "placement " + std::to_string(placement) + ", of mesh '" +
                    scene.meshes[scene.trees[tree].meshes[0]].name +
                    "': its matrix cannot be inverted (singular or not finite); give a scale other than zero");
  shared::Instance instance{};
  instance.world_from_local_0 = row(world_from_local, 0);
  instance.world_from_local_1 = row(world_from_local, 1);
  instance.world_from_local_2 = row(world_from_local, 2);
  instance.local_from_world_0 = row(inverse, 0);
  instance.local_from_world_1 = row(inverse, 1);
  instance.local_from_world_2 = row(inverse, 2);
  instance.root = scene.trees[tree].root;
  instance.tree = tree;
  instance.placement = placement;
  const std::array<double, 12> identity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  instance.flags = world_from_local == identity ? 1u : 0u;
  scene.instances.push_back(instance);
}

void finish_top_tree(CompiledScene& scene) {
  detail::BoxTree top;
  Box bounds;
  if (scene.instances.empty()) {
    top.nodes.emplace_back();
    top.nodes[0] = {};
  } else {
    std::vector<Box> boxes;
    boxes.reserve(scene.instances.size());
    for (const auto& instance : scene.instances) {
      const Tree& tree = scene.trees[instance.tree];
      boxes.push_back(world_box(instance, tree.lo, tree.hi));
      // The scene's bounds are those of what the user placed: they must not hang on which meshes share a tree.
      for (const std::uint32_t mesh : tree.meshes)
        bounds.grow(world_box(instance, scene.meshes[mesh].lo, scene.meshes[mesh].hi));
    }
    top = detail::build_tree(boxes);
  }
  if (top.depth > kMaxDepth) throw Error(Fault::bug, "top tree of " + std::to_string(top.depth) + " levels");
  const auto shift = static_cast<std::uint32_t>(top.nodes.size());
  for (shared::BvhNode& node : scene.nodes)
    for (std::uint32_t i = 0; i < node.count; ++i)
      if (!(node.leaf_mask >> i & 1u)) node.child[i] += shift;
  for (Tree& tree : scene.trees) tree.root += shift;
  for (shared::Instance& instance : scene.instances) instance.root = scene.trees[instance.tree].root;
  scene.nodes.insert(scene.nodes.begin(), top.nodes.begin(), top.nodes.end());
  scene.top_depth = top.depth;
  scene.lo = bounds.lo, scene.hi = bounds.hi;
  scene.skyline = survey_skyline(scene, 0);
}

}  // namespace raycube::scene
