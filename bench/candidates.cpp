#include "bench/candidates.h"

#include <array>
#include <atomic>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <thread>

namespace raycube::bench {
namespace {

using Vec = glm::dvec3;

// Four half-spaces through the origin; a point is outside plane k when dot(normal[k], p - origin) < 0.
struct Pyramid {
  Vec origin;
  std::array<Vec, 4> normal;
};

Pyramid pyramid(const Vec& origin, const std::array<Vec, 4>& corner) {
  Pyramid p{origin, {}};
  const Vec middle = corner[0] + corner[1] + corner[2] + corner[3];
  for (int k = 0; k < 4; ++k) {
    Vec n = glm::cross(corner[k], corner[(k + 1) % 4]);
    if (glm::dot(n, middle) < 0) n = -n;
    p.normal[k] = n;
  }
  return p;
}

bool box_outside(const Pyramid& p, const shared::BvhNode& node, int i) {
  for (const Vec& n : p.normal) {
    const Vec farthest(n.x > 0 ? node.hi_x[i] : node.lo_x[i], n.y > 0 ? node.hi_y[i] : node.lo_y[i],
                       n.z > 0 ? node.hi_z[i] : node.lo_z[i]);
    if (glm::dot(n, farthest - p.origin) < 0) return true;
  }
  return false;
}

// True when the plane through the origin and one of the triangle's edges has the whole pixel on its outer side.
bool edge_separates(const Pyramid& p, const std::array<Vec, 4>& corner, const std::array<Vec, 3>& vertex) {
  for (int k = 0; k < 3; ++k) {
    Vec n = glm::cross(vertex[k] - p.origin, vertex[(k + 1) % 3] - p.origin);
    if (glm::dot(n, vertex[(k + 2) % 3] - p.origin) < 0) n = -n;
    bool outside = true;
    for (const Vec& c : corner) outside = outside && glm::dot(n, c) < 0;
    if (outside) return true;
  }
  return false;
}

std::uint32_t in_block(const Pyramid& p, const std::array<Vec, 4>& corner, const shared::TriBlock& t) {
  std::uint32_t count = 0;
  for (int i = 0; i < RC_BLOCK; ++i) {
    if (t.surface[i] == RC_NONE) continue;
    const std::array<Vec, 3> vertex{Vec(t.v0_x[i], t.v0_y[i], t.v0_z[i]), Vec(t.v1_x[i], t.v1_y[i], t.v1_z[i]),
                                    Vec(t.v2_x[i], t.v2_y[i], t.v2_z[i])};
    bool outside = false;
    for (const Vec& n : p.normal)
      outside = outside || (glm::dot(n, vertex[0] - p.origin) < 0 && glm::dot(n, vertex[1] - p.origin) < 0 &&
                            glm::dot(n, vertex[2] - p.origin) < 0);
    outside = outside || edge_separates(p, corner, vertex);
    count += !outside;
  }
  return count;
}

Vec row_times(const shared::rc_float4& r0, const shared::rc_float4& r1, const shared::rc_float4& r2, const Vec& v,
              double w) {
  return {r0.x * v.x + r0.y * v.y + r0.z * v.z + r0.w * w, r1.x * v.x + r1.y * v.y + r1.z * v.z + r1.w * w,
          r2.x * v.x + r2.y * v.y + r2.z * v.z + r2.w * w};
}

std::uint32_t in_tree(const scene::CompiledScene& scene, const Pyramid& p, const std::array<Vec, 4>& corner,
                      std::uint32_t root, bool top) {
  std::uint32_t count = 0;
  const shared::BvhNode& node = scene.nodes[root];
  for (std::uint32_t i = 0; i < node.count; ++i) {
    if (box_outside(p, node, static_cast<int>(i))) continue;
    if (!(node.leaf_mask >> i & 1u)) {
      count += in_tree(scene, p, corner, node.child[i], top);
    } else if (!top) {
      count += in_block(p, corner, scene.blocks[node.child[i]]);
    } else {
      const shared::Instance& placed = scene.instances[node.child[i]];
      const auto local = [&](const Vec& v, double w) {
        return row_times(placed.local_from_world_0, placed.local_from_world_1, placed.local_from_world_2, v, w);
      };
      std::array<Vec, 4> local_corner;
      for (int k = 0; k < 4; ++k) local_corner[k] = local(corner[k], 0);
      count += in_tree(scene, pyramid(local(p.origin, 1), local_corner), local_corner, placed.root, false);
    }
  }
  return count;
}

}  // namespace

std::vector<std::uint32_t> count_candidates(const scene::CompiledScene& scene,
                                            const std::vector<shared::RayGroup>& groups, int width, double half_px,
                                            int threads) {
  std::vector<std::uint32_t> counts(groups.size() * static_cast<std::size_t>(width));
  std::atomic<std::size_t> next{0};
  const auto run = [&] {
    for (std::size_t g; (g = next.fetch_add(1)) < groups.size();)
      for (int i = 0; i < width; ++i) {
        const auto exact = [](const shared::rc_float4& v) { return Vec(v.x, v.y, v.z); };
        const Vec d0 = exact(groups[g].d0), origin = exact(groups[g].origin) - double{groups[g].d0.w} * d0,
                  du = exact(groups[g].du), dv = exact(groups[g].dv);
        const double a = i - 0.5 * (width - 1);
        const std::array<Vec, 4> corner{d0 + (a - half_px) * du - half_px * dv, d0 + (a + half_px) * du - half_px * dv,
                                        d0 + (a + half_px) * du + half_px * dv, d0 + (a - half_px) * du + half_px * dv};
        counts[g * width + i] = in_tree(scene, pyramid(origin, corner), corner, 0, true);
      }
  };
  std::vector<std::jthread> workers;
  for (int t = 0; t < threads; ++t) workers.emplace_back(run);
  workers.clear();
  return counts;
}

}  // namespace raycube::bench
