// Small compiled scenes made by hand for the reference's tests: triangles packed in order into blocks and a bottom-up
// tree, so that nothing of the scene compiler is needed (or trusted).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <glm/geometric.hpp>

#include "host/reference/ray.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::test {

struct Triangle {
  glm::vec3 a, b, c;
  std::uint32_t surface = 0;
};

struct Box {
  glm::vec3 lo{INFINITY}, hi{-INFINITY};
  void add(const glm::vec3& p) {
    for (int i = 0; i < 3; ++i) lo[i] = std::min(lo[i], p[i]), hi[i] = std::max(hi[i], p[i]);
  }
};

/// Leaves (index, box) in order -> 8-wide tree; returns its root.
inline std::uint32_t build_tree(scene::CompiledScene& scene, std::vector<std::pair<std::uint32_t, Box>> level,
                                std::uint32_t& depth) {
  bool leaves = true;
  for (depth = 0;; ++depth) {
    std::vector<std::pair<std::uint32_t, Box>> above;
    for (std::size_t first = 0; first < level.size(); first += 8) {
      shared::BvhNode node{};
      Box box;
      node.count = static_cast<std::uint32_t>(std::min<std::size_t>(8, level.size() - first));
      for (std::uint32_t i = 0; i < node.count; ++i) {
        const auto& [index, child] = level[first + i];
        node.lo_x[i] = child.lo.x, node.lo_y[i] = child.lo.y, node.lo_z[i] = child.lo.z;
        node.hi_x[i] = child.hi.x, node.hi_y[i] = child.hi.y, node.hi_z[i] = child.hi.z;
        node.child[i] = index;
        if (leaves) node.leaf_mask |= 1u << i;
        box.add(child.lo), box.add(child.hi);
      }
      above.emplace_back(static_cast<std::uint32_t>(scene.nodes.size()), box);
      scene.nodes.push_back(node);
    }
    level = above;
    leaves = false;
    if (level.size() == 1) return level[0].first;
  }
}

/// Collects meshes, each with a tree of its own, and instances; finish() builds the trees with the top tree's root at
/// node 0.
class SceneBuilder {
 public:
  scene::CompiledScene scene;

  SceneBuilder() { scene.nodes.emplace_back(); }

  std::uint32_t mesh(const std::vector<Triangle>& triangles) {
    scene::Mesh mesh;
    scene::Tree tree;
    mesh.tree = static_cast<std::uint32_t>(scene.trees.size());
    tree.meshes = {static_cast<std::uint32_t>(scene.meshes.size())};
    tree.first_block = static_cast<std::uint32_t>(scene.blocks.size());
    tree.triangle_count = static_cast<std::uint32_t>(triangles.size());
    std::vector<std::pair<std::uint32_t, Box>> leaves;
    Box bounds;
    for (std::size_t first = 0; first < triangles.size(); first += RC_BLOCK) {
      shared::TriBlock block{};
      Box box;
      for (std::size_t k = 0; k < RC_BLOCK; ++k) {
        const bool used = first + k < triangles.size();
        Triangle t = used ? triangles[first + k] : Triangle{triangles[first].a, triangles[first].a, triangles[first].a};
        block.v0_x[k] = t.a.x, block.v0_y[k] = t.a.y, block.v0_z[k] = t.a.z;
        block.v1_x[k] = t.b.x, block.v1_y[k] = t.b.y, block.v1_z[k] = t.b.z;
        block.v2_x[k] = t.c.x, block.v2_y[k] = t.c.y, block.v2_z[k] = t.c.z;
        block.surface[k] = used ? t.surface : RC_NONE;
        block.triangle[k] = static_cast<std::uint32_t>(first + k);
        if (used) mesh.user_face.push_back(block.triangle[k]);
        box.add(t.a), box.add(t.b), box.add(t.c);
      }
      leaves.emplace_back(static_cast<std::uint32_t>(scene.blocks.size()), box);
      scene.blocks.push_back(block);
      bounds.add(box.lo), bounds.add(box.hi);
    }
    tree.block_count = static_cast<std::uint32_t>(leaves.size());
    tree.root = build_tree(scene, leaves, tree.depth);
    for (int i = 0; i < 3; ++i) mesh.lo[i] = tree.lo[i] = bounds.lo[i], mesh.hi[i] = tree.hi[i] = bounds.hi[i];
    scene.meshes.push_back(mesh);
    scene.trees.push_back(tree);
    return static_cast<std::uint32_t>(scene.meshes.size() - 1);
  }

  std::uint32_t instance(std::uint32_t mesh, const glm::dmat3& m = glm::dmat3(1), const glm::dvec3& t = glm::dvec3(0)) {
    const glm::dmat3 inverse = glm::inverse(m);
    const glm::dvec3 back = -(inverse * t);
    const auto row = [](const glm::dmat3& matrix, const glm::dvec3& shift, int r) {
      return shared::rc_float4{static_cast<float>(matrix[0][r]), static_cast<float>(matrix[1][r]),
                               static_cast<float>(matrix[2][r]), static_cast<float>(shift[r])};
    };
    shared::Instance placed{};
    placed.world_from_local_0 = row(m, t, 0), placed.world_from_local_1 = row(m, t, 1),
    placed.world_from_local_2 = row(m, t, 2);
    placed.local_from_world_0 = row(inverse, back, 0), placed.local_from_world_1 = row(inverse, back, 1);
    placed.local_from_world_2 = row(inverse, back, 2);
    placed.tree = mesh, placed.root = scene.trees[mesh].root;
    placed.placement = static_cast<std::uint32_t>(scene.instances.size());
    placed.flags = m == glm::dmat3(1) && t == glm::dvec3(0) ? 1u : 0u;
    Box box;
    for (int corner = 0; corner < 8; ++corner) {
      const auto& mesh_box = scene.meshes[mesh];
      const glm::dvec3 p((corner & 1 ? mesh_box.hi : mesh_box.lo)[0], (corner & 2 ? mesh_box.hi : mesh_box.lo)[1],
                         (corner & 4 ? mesh_box.hi : mesh_box.lo)[2]);
      box.add(glm::vec3(m * p + t));
    }
    boxes_.emplace_back(placed.placement, box);
    scene.instances.push_back(placed);
    return placed.placement;
  }

  scene::CompiledScene finish() {
    if (boxes_.empty()) return scene;
    const std::uint32_t root = build_tree(scene, boxes_, scene.top_depth);
    scene.nodes[0] = scene.nodes[root];
    return scene;
  }

  std::uint32_t material(const std::string& name, const std::vector<double>& wavelength_um,
                         const std::vector<double>& value) {
    scene::Material material;
    material.name = name, material.source = "test", material.reflectance = {wavelength_um, value};
    scene.materials.push_back(material);
    shared::Surface surface{};
    surface.material[0] = static_cast<std::uint32_t>(scene.materials.size());
    surface.fraction[0] = 1;
    scene.surfaces.push_back(surface);
    return static_cast<std::uint32_t>(scene.surfaces.size() - 1);
  }

 private:
  std::vector<std::pair<std::uint32_t, Box>> boxes_;
};

/// Two triangles of the parallelogram p, p+e, p+e+f, p+f (outward normal e x f).
inline void add_quad(std::vector<Triangle>& out, glm::vec3 p, glm::vec3 e, glm::vec3 f, std::uint32_t surface = 0) {
  out.push_back({p, p + e, p + e + f, surface});
  out.push_back({p, p + e + f, p + f, surface});
}

/// Closed axis-parallel box, outward normals.
inline void add_box(std::vector<Triangle>& out, glm::vec3 lo, glm::vec3 hi, std::uint32_t surface = 0) {
  const glm::vec3 d = hi - lo, x(d.x, 0, 0), y(0, d.y, 0), z(0, 0, d.z);
  add_quad(out, lo, y, x, surface), add_quad(out, lo + z, x, y, surface);
  add_quad(out, lo, x, z, surface), add_quad(out, lo + y, z, x, surface);
  add_quad(out, lo, z, y, surface), add_quad(out, lo + x, y, z, surface);
}

/// A rolling height field of n x n quads of `cell` metres, centred on the origin; returns its vertices too.
inline std::vector<Triangle> terrain(int n, float cell, std::uint32_t surface,
                                     std::vector<glm::vec3>* vertices = nullptr) {
  const auto at = [&](int i, int j) {
    const float x = (static_cast<float>(i) - 0.5f * static_cast<float>(n)) * cell;
    const float y = (static_cast<float>(j) - 0.5f * static_cast<float>(n)) * cell;
    return glm::vec3(x, y, 2 * std::sin(0.3f * x) * std::cos(0.23f * y));
  };
  std::vector<Triangle> out;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      out.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), surface});
      out.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1), surface});
      if (vertices) vertices->push_back(at(i, j));
    }
  return out;
}

inline glm::dmat3 rotation(double yaw_rad, double pitch_rad, double scale) {
  const double c = std::cos(yaw_rad), s = std::sin(yaw_rad), p = std::cos(pitch_rad), q = std::sin(pitch_rad);
  return glm::dmat3(glm::dvec3(c, s, 0), glm::dvec3(-s, c, 0), glm::dvec3(0, 0, 1)) *
         glm::dmat3(glm::dvec3(1, 0, 0), glm::dvec3(0, p, q), glm::dvec3(0, -q, p)) * glm::dmat3(scale);
}

inline reference::Ray ray_between(const glm::vec3& from, const glm::vec3& to) {
  const glm::vec3 d = to - from;
  return {{from.x, from.y, from.z}, {d.x, d.y, d.z}};
}

}  // namespace raycube::test
