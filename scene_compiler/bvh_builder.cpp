#include "scene_compiler/bvh_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "host/base/error.h"
#include "scene_compiler/bvh_tree.h"

namespace raycube::scene {
namespace {

using base::Error;
using base::Fault;
using detail::Box;

constexpr std::uint32_t kBlock = RC_BLOCK;
constexpr std::uint32_t kMaxDepth = 64;  // a traversal stack of 7 * 64 + 8 words is the most a kernel gets

struct Centroid {
  std::array<float, 3> position;
  std::uint32_t triangle;
};

// Orders the range so that consecutive runs of 16 are spatially compact: recursive split of the longest centroid axis
// at a count rounded up to full blocks. Equal keys fall back on the triangle number, so the order is the same
// everywhere.
void regroup(Centroid* first, Centroid* last) {
  while (last - first > static_cast<std::ptrdiff_t>(kBlock)) {
    Box box;
    for (const Centroid* c = first; c != last; ++c) box.grow(c->position);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (box.hi[k] - box.lo[k] > box.hi[axis] - box.lo[axis]) axis = k;
    const std::ptrdiff_t half = (last - first + 1) / 2;
    Centroid* middle = first + (half + kBlock - 1) / kBlock * kBlock;
    std::nth_element(first, middle, last, [axis](const Centroid& a, const Centroid& b) {
      return a.position[axis] != b.position[axis] ? a.position[axis] < b.position[axis] : a.triangle < b.triangle;
    });
    regroup(first, middle);
    first = middle;
  }
  // Inside a block the file's order stands.
  std::sort(first, last, [](const Centroid& a, const Centroid& b) { return a.triangle < b.triangle; });
}

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

// World box of an instance: the eight corners of its mesh through the stored matrix in double, grown by what the
// rounded matrices can move a point (16 ulp of the sums involved), so that no local hit lies outside.
Box world_box(const shared::Instance& instance, const Mesh& mesh) {
  const shared::rc_float4* w = &instance.world_from_local_0;
  const shared::rc_float4* l = &instance.local_from_world_0;
  double reach = 0;  // largest |world coordinate| of the corners
  double lo[3], hi[3], size[3];
  for (int i = 0; i < 3; ++i) {
    lo[i] = std::numeric_limits<double>::max(), hi[i] = -lo[i], size[i] = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const double x = corner & 1 ? mesh.hi[0] : mesh.lo[0], y = corner & 2 ? mesh.hi[1] : mesh.lo[1];
      const double z = corner & 4 ? mesh.hi[2] : mesh.lo[2];
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

}  // namespace

std::uint32_t append_mesh(CompiledScene& scene, const std::string& name, const TriangleMesh& mesh) {
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  require(count > 0, name, "no triangle");
  require(mesh.surface.size() == count && mesh.user_face.size() == count, name, "lists of different lengths");
  std::vector<Centroid> order(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    order[i] = {{0, 0, 0}, i};
    for (const std::uint32_t vertex : mesh.triangles[i]) {
      require(vertex < mesh.vertices.size(), name, "a vertex index out of range");
      for (int k = 0; k < 3; ++k) {
        require(std::isfinite(mesh.vertices[vertex][k]), name, "a vertex that is not finite");
        order[i].position[k] += mesh.vertices[vertex][k] * (1.0f / 3.0f);
      }
    }
  }
  regroup(order.data(), order.data() + count);

  Mesh result;
  result.name = name;
  result.first_block = static_cast<std::uint32_t>(scene.blocks.size());
  result.block_count = (count + kBlock - 1) / kBlock;
  result.triangle_count = count;
  result.user_face.assign(std::size_t{result.block_count} * kBlock, RC_NONE);
  scene.blocks.resize(scene.blocks.size() + result.block_count);
  std::vector<Box> boxes(result.block_count);
  Box bounds;
  for (std::uint32_t b = 0; b < result.block_count; ++b) {
    shared::TriBlock& block = scene.blocks[result.first_block + b];
    for (std::uint32_t lane = 0; lane < kBlock; ++lane) {
      const std::uint32_t at = b * kBlock + lane;
      const bool used = at < count;
      const std::uint32_t triangle = order[used ? at : b * kBlock].triangle;
      const auto& corner = mesh.triangles[triangle];
      const auto& v0 = mesh.vertices[corner[0]];
      set_vertex(block.v0_x, block.v0_y, block.v0_z, lane, v0);
      set_vertex(block.v1_x, block.v1_y, block.v1_z, lane, used ? mesh.vertices[corner[1]] : v0);
      set_vertex(block.v2_x, block.v2_y, block.v2_z, lane, used ? mesh.vertices[corner[2]] : v0);
      block.surface[lane] = used ? mesh.surface[triangle] : RC_NONE;
      if (!used) continue;
      result.user_face[at] = mesh.user_face[triangle];
      for (const std::uint32_t vertex : corner) boxes[b].grow(mesh.vertices[vertex]);
    }
    bounds.grow(boxes[b]);
  }
  result.lo = bounds.lo, result.hi = bounds.hi;

  detail::Tree tree = detail::build_tree(boxes);
  if (tree.depth > kMaxDepth)
    throw Error(Fault::bug, "mesh '" + name + "': tree of " + std::to_string(tree.depth) + " levels");
  result.depth = tree.depth;
  result.root = static_cast<std::uint32_t>(scene.nodes.size());
  for (shared::BvhNode& node : tree.nodes)
    for (std::uint32_t i = 0; i < node.count; ++i)
      node.child[i] += node.leaf_mask >> i & 1u ? result.first_block : result.root;
  scene.nodes.insert(scene.nodes.end(), tree.nodes.begin(), tree.nodes.end());
  scene.meshes.push_back(std::move(result));
  return static_cast<std::uint32_t>(scene.meshes.size() - 1);
}

void append_instance(CompiledScene& scene, std::uint32_t mesh, const std::array<double, 12>& world_from_local,
                     std::uint32_t id) {
  if (mesh >= scene.meshes.size()) throw Error(Fault::bug, "instance " + std::to_string(id) + " of an unknown mesh");
  std::array<double, 12> inverse{};
  if (!invert(world_from_local, inverse))
    throw Error(Fault::input,
                "instance " + std::to_string(id) + " of mesh '" + scene.meshes[mesh].name +
                    "': its matrix cannot be inverted (singular or not finite); give a scale other than zero");
  shared::Instance instance{};
  instance.world_from_local_0 = row(world_from_local, 0);
  instance.world_from_local_1 = row(world_from_local, 1);
  instance.world_from_local_2 = row(world_from_local, 2);
  instance.local_from_world_0 = row(inverse, 0);
  instance.local_from_world_1 = row(inverse, 1);
  instance.local_from_world_2 = row(inverse, 2);
  instance.root = scene.meshes[mesh].root;
  instance.mesh = mesh;
  instance.id = id;
  const std::array<double, 12> identity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  instance.flags = world_from_local == identity ? 1u : 0u;
  scene.instances.push_back(instance);
}

void finish_top_tree(CompiledScene& scene) {
  detail::Tree top;
  Box bounds;
  if (scene.instances.empty()) {
    top.nodes.emplace_back();
    top.nodes[0] = {};
  } else {
    std::vector<Box> boxes;
    boxes.reserve(scene.instances.size());
    for (const auto& instance : scene.instances) {
      boxes.push_back(world_box(instance, scene.meshes[instance.mesh]));
      bounds.grow(boxes.back());
    }
    top = detail::build_tree(boxes);
  }
  if (top.depth > kMaxDepth) throw Error(Fault::bug, "top tree of " + std::to_string(top.depth) + " levels");
  const auto shift = static_cast<std::uint32_t>(top.nodes.size());
  for (shared::BvhNode& node : scene.nodes)
    for (std::uint32_t i = 0; i < node.count; ++i)
      if (!(node.leaf_mask >> i & 1u)) node.child[i] += shift;
  for (Mesh& mesh : scene.meshes) mesh.root += shift;
  for (shared::Instance& instance : scene.instances) instance.root = scene.meshes[instance.mesh].root;
  scene.nodes.insert(scene.nodes.begin(), top.nodes.begin(), top.nodes.end());
  scene.top_depth = top.depth;
  scene.lo = bounds.lo, scene.hi = bounds.hi;
}

}  // namespace raycube::scene
