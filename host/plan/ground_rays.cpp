#include "host/plan/ground_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace raycube::plan {

namespace {

using Vec = std::array<double, 3>;

struct Ray {
  Vec origin, direction;
};

struct Found {
  double t = std::numeric_limits<double>::infinity();
  std::uint32_t surface = RC_NONE;
};

Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Boxes are rounded outwards for fp32 rays already; this much more (relative) covers the matrices' rounding.
constexpr double kBoxSlack = 1e-6;

bool meets_box(const shared::BvhNode& node, std::uint32_t slot, const Ray& ray, double t_max) {
  const Vec lo{node.lo_x[slot], node.lo_y[slot], node.lo_z[slot]},
      hi{node.hi_x[slot], node.hi_y[slot], node.hi_z[slot]};
  double enter = 0, leave = t_max;
  for (std::size_t i = 0; i < 3; ++i) {
    const double pad = kBoxSlack * std::max({std::abs(lo[i]), std::abs(hi[i]), std::abs(ray.origin[i])});
    const double below = lo[i] - pad - ray.origin[i], above = hi[i] + pad - ray.origin[i];
    if (ray.direction[i] == 0) {
      if (below > 0 || above < 0) return false;
      continue;
    }
    const double a = below / ray.direction[i], b = above / ray.direction[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave;
}

/// Moller & Trumbore (1997) in double: a ray lost at an edge is one of many thousands.
void meet_triangle(const shared::TriBlock& block, std::uint32_t lane, const Ray& ray, Found& found) {
  const Vec a{block.v0_x[lane], block.v0_y[lane], block.v0_z[lane]};
  const Vec ab = minus({block.v1_x[lane], block.v1_y[lane], block.v1_z[lane]}, a);
  const Vec ac = minus({block.v2_x[lane], block.v2_y[lane], block.v2_z[lane]}, a);
  const Vec p = cross(ray.direction, ac);
  const double determinant = dot(ab, p);
  if (determinant == 0) return;
  const Vec s = minus(ray.origin, a), q = cross(s, ab);
  const double u = dot(s, p) / determinant, v = dot(ray.direction, q) / determinant, t = dot(ac, q) / determinant;
  if (u >= 0 && v >= 0 && u + v <= 1 && t >= 0 && t < found.t) found = {t, block.surface[lane]};
}

void walk_mesh(const scene::CompiledScene& scene, std::uint32_t index, const Ray& ray, Found& found) {
  const shared::BvhNode& node = scene.nodes[index];
  for (std::uint32_t slot = 0; slot < node.count; ++slot) {
    if (!meets_box(node, slot, ray, found.t)) continue;
    if (!(node.leaf_mask >> slot & 1u)) {
      walk_mesh(scene, node.child[slot], ray, found);
      continue;
    }
    const shared::TriBlock& block = scene.blocks[node.child[slot]];
    for (std::uint32_t lane = 0; lane < RC_BLOCK; ++lane)
      if (block.surface[lane] != RC_NONE) meet_triangle(block, lane, ray, found);
  }
}

/// A world ray in an instance's frame; t stays the same.
Ray to_local(const shared::Instance& instance, const Ray& ray) {
  const shared::rc_float4 rows[3] = {instance.local_from_world_0, instance.local_from_world_1,
                                     instance.local_from_world_2};
  Ray out;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec linear{rows[i].x, rows[i].y, rows[i].z};
    out.origin[i] = dot(linear, ray.origin) + double{rows[i].w};
    out.direction[i] = dot(linear, ray.direction);
  }
  return out;
}

void walk_top(const scene::CompiledScene& scene, std::uint32_t index, const Ray& ray, Found& found) {
  const shared::BvhNode& node = scene.nodes[index];
  for (std::uint32_t slot = 0; slot < node.count; ++slot) {
    if (!meets_box(node, slot, ray, found.t)) continue;
    if (node.leaf_mask >> slot & 1u) {
      const shared::Instance& instance = scene.instances[node.child[slot]];
      walk_mesh(scene, instance.root, to_local(instance, ray), found);
    } else {
      walk_top(scene, node.child[slot], ray, found);
    }
  }
}

}  // namespace

std::uint32_t uppermost_surface(const scene::CompiledScene& scene, double x_m, double y_m) {
  if (scene.nodes.empty() || scene.instances.empty()) return RC_NONE;
  Found found;
  walk_top(scene, 0, {{x_m, y_m, double{scene.hi[2]} + 1}, {0, 0, -1}}, found);
  return found.surface;
}

}  // namespace raycube::plan
