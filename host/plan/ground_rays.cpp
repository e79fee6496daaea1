#include "host/plan/ground_rays.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "scene_compiler/matter.h"
#include "scene_compiler/owner.h"

namespace raycube::plan {

namespace {

using Vec = std::array<double, 3>;

struct Ray {
  Vec origin, direction;
};

/// The uppermost triangle so far; of two at one height the first in the user's order.
struct Found {
  const scene::CompiledScene& scene;
  double t = std::numeric_limits<double>::infinity();
  std::uint32_t instance = RC_NONE, primitive = RC_NONE;

  void take(double at, std::uint32_t placed, std::uint32_t triangle) {
    if (at < t || (at == t && scene::user_before(scene, placed, triangle, instance, primitive)))
      t = at, instance = placed, primitive = triangle;
  }
};

Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/// Boxes are rounded outwards for fp32 rays already; this much more (relative) covers the matrices' rounding.
constexpr double kBoxSlack = 1e-6;
constexpr std::size_t kChildren = std::size(shared::BvhNode{}.child);

/// Where a ray enters a child's box before t_max; infinite: nowhere.
double enters_box(const shared::BvhNode& node, std::uint32_t slot, const Ray& ray, double t_max) {
  constexpr double nowhere = std::numeric_limits<double>::infinity();
  const Vec lo{node.lo_x[slot], node.lo_y[slot], node.lo_z[slot]},
      hi{node.hi_x[slot], node.hi_y[slot], node.hi_z[slot]};
  double enter = 0, leave = t_max;
  for (std::size_t i = 0; i < 3; ++i) {
    const double pad = kBoxSlack * std::max({std::abs(lo[i]), std::abs(hi[i]), std::abs(ray.origin[i])});
    const double below = lo[i] - pad - ray.origin[i], above = hi[i] + pad - ray.origin[i];
    if (ray.direction[i] == 0) {
      if (below > 0 || above < 0) return nowhere;
      continue;
    }
    const double a = below / ray.direction[i], b = above / ray.direction[i];
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
  }
  return enter <= leave ? enter : nowhere;
}

/// Whether a ray that goes straight down (or up) in this frame may meet each child's box: at least those that it does.
/// In float and for all at once; the slack is many times what that rounds by.
std::array<std::int32_t, kChildren> may_stand_over(const shared::BvhNode& node, const Ray& ray) {
  const auto x = static_cast<float>(ray.origin[0]), y = static_cast<float>(ray.origin[1]);
  constexpr auto slack = static_cast<float>(2 * kBoxSlack);
  const auto beside = [](float lo, float hi, float at) {
    const float pad = slack * (std::abs(lo) + std::abs(hi) + std::abs(at));
    return static_cast<std::int32_t>(lo - pad > at) | static_cast<std::int32_t>(hi + pad < at);
  };
  std::array<std::int32_t, kChildren> out;
  for (std::size_t slot = 0; slot < kChildren; ++slot)
    out[slot] = beside(node.lo_x[slot], node.hi_x[slot], x) | beside(node.lo_y[slot], node.hi_y[slot], y) ? 0 : 1;
  return out;
}

/// visit(slot) of every child whose box a ray meets before what it has found, nearest box first.
template <class Visit>
void visit_children(const shared::BvhNode& node, const Ray& ray, const Found& found, const Visit& visit) {
  std::array<std::pair<double, std::uint32_t>, kChildren> met;
  std::size_t count = 0;
  std::array<std::int32_t, kChildren> may;
  may.fill(1);
  if (ray.direction[0] == 0 && ray.direction[1] == 0) may = may_stand_over(node, ray);
  for (std::uint32_t slot = 0; slot < node.count; ++slot) {
    if (!may[slot]) continue;
    const double enter = enters_box(node, slot, ray, found.t);
    if (enter == std::numeric_limits<double>::infinity()) continue;
    std::size_t at = count++;
    for (; at > 0 && enter < met[at - 1].first; --at) met[at] = met[at - 1];
    met[at] = {enter, slot};
  }
  for (std::size_t i = 0; i < count && met[i].first <= found.t; ++i) visit(met[i].second);
}

/// Moller & Trumbore (1997) in double: a ray lost at an edge is one of many thousands.
void meet_triangle(std::uint32_t instance, std::uint32_t primitive, const Ray& ray, Found& found) {
  const shared::TriBlock& block = found.scene.blocks[primitive / RC_BLOCK];
  const std::uint32_t lane = primitive % RC_BLOCK;
  const Vec a{block.v0_x[lane], block.v0_y[lane], block.v0_z[lane]};
  const Vec ab = minus({block.v1_x[lane], block.v1_y[lane], block.v1_z[lane]}, a);
  const Vec ac = minus({block.v2_x[lane], block.v2_y[lane], block.v2_z[lane]}, a);
  const Vec p = cross(ray.direction, ac);
  const double determinant = dot(ab, p);
  if (determinant == 0) return;
  const Vec s = minus(ray.origin, a), q = cross(s, ab);
  const double u = dot(s, p) / determinant, v = dot(ray.direction, q) / determinant, t = dot(ac, q) / determinant;
  if (u >= 0 && v >= 0 && u + v <= 1 && t >= 0) found.take(t, instance, primitive);
}

void walk_tree(std::uint32_t instance, std::uint32_t index, const Ray& ray, Found& found) {
  const shared::BvhNode& node = found.scene.nodes[index];
  visit_children(node, ray, found, [&](std::uint32_t slot) {
    if (!(node.leaf_mask >> slot & 1u)) return walk_tree(instance, node.child[slot], ray, found);
    const std::uint32_t block = node.child[slot];
    for (std::uint32_t p = block * RC_BLOCK; p < (block + 1) * RC_BLOCK; ++p)
      if (scene::surface_of(found.scene, p) != RC_NONE) meet_triangle(instance, p, ray, found);
  });
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

void walk_top(std::uint32_t index, const Ray& ray, Found& found) {
  const shared::BvhNode& node = found.scene.nodes[index];
  visit_children(node, ray, found, [&](std::uint32_t slot) {
    if (!(node.leaf_mask >> slot & 1u)) return walk_top(node.child[slot], ray, found);
    const std::uint32_t instance = node.child[slot];
    const shared::Instance& placed = found.scene.instances[instance];
    walk_tree(instance, placed.root, to_local(placed, ray), found);
  });
}

}  // namespace

std::uint32_t uppermost_surface(const scene::CompiledScene& scene, double x_m, double y_m) {
  if (scene.nodes.empty() || scene.instances.empty()) return RC_NONE;
  Found found{scene};
  walk_top(0, {{x_m, y_m, double{scene.hi[2]} + 1}, {0, 0, -1}}, found);
  return found.primitive == RC_NONE ? RC_NONE : scene::surface_of(scene, found.primitive);
}

}  // namespace raycube::plan
