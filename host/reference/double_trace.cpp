#include "host/reference/double_trace.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/owner.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raycube::reference {

namespace {

/// Two depths of one ray are the same to rounding in double: some 1e3 times 2^-53, for a plane seen edge-on loses
/// digits.
constexpr double kSameDepth = 1e-13;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Slab test in double. Boxes grow by far more than any rounding (including that of the top tree's fp32 boxes, and the
/// slack of spawned rays), so only speed depends on it.
bool meets_box(const shared::BvhNode& node, std::uint32_t slot, const LocalRay& ray, double t_max) {
  const double lo[3] = {node.lo_x[slot], node.lo_y[slot], node.lo_z[slot]};
  const double hi[3] = {node.hi_x[slot], node.hi_y[slot], node.hi_z[slot]};
  double size = 0;
  for (int axis = 0; axis < 3; ++axis)
    size = std::max({size, std::abs(lo[axis]), std::abs(hi[axis]), std::abs(ray.origin[axis])});
  const double pad = 256 * kUlp * size + 2 * ray.origin_error_m;
  double enter = 0, leave = t_max;
  for (int axis = 0; axis < 3; ++axis) {
    const double below = lo[axis] - pad - ray.origin[axis], above = hi[axis] + pad - ray.origin[axis];
    if (ray.direction[axis] == 0) {
      if (below > 0 || above < 0) return false;
      continue;
    }
    const double t0 = below / ray.direction[axis], t1 = above / ray.direction[axis];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return enter <= leave;
}

/// Calls visit(primitive, local ray) for every triangle whose block's box the ray meets before visit's bound t_max().
template <typename Visit>
void walk_tree(const scene::CompiledScene& scene, std::uint32_t node_index, std::uint32_t instance, const LocalRay& ray,
               Visit& visit) {
  const shared::BvhNode& node = scene.nodes[node_index];
  for (std::uint32_t slot = 0; slot < node.count; ++slot) {
    if (!meets_box(node, slot, ray, visit.t_max())) continue;
    if (!(node.leaf_mask >> slot & 1u)) {
      walk_tree(scene, node.child[slot], instance, ray, visit);
      continue;
    }
    const std::uint32_t block = node.child[slot];
    for (std::uint32_t lane = 0; lane < RC_BLOCK; ++lane)
      if (scene.blocks[block].surface[lane] != RC_NONE) visit({instance, block * RC_BLOCK + lane}, ray);
  }
}

template <typename Visit>
void walk_top(const scene::CompiledScene& scene, std::uint32_t node_index, const DoubleRay& ray, const LocalRay& world,
              Visit& visit) {
  const shared::BvhNode& node = scene.nodes[node_index];
  for (std::uint32_t slot = 0; slot < node.count; ++slot) {
    if (!meets_box(node, slot, world, visit.t_max())) continue;
    if (node.leaf_mask >> slot & 1u) {
      const shared::Instance& instance = scene.instances[node.child[slot]];
      walk_tree(scene, instance.root, node.child[slot], to_local(instance, ray), visit);
    } else {
      walk_top(scene, node.child[slot], ray, world, visit);
    }
  }
}

template <typename Visit>
void walk(const scene::CompiledScene& scene, const DoubleRay& ray, Visit& visit) {
  if (scene.nodes.empty() || scene.instances.empty()) return;
  walk_top(scene, 0, ray, {ray.origin, ray.direction, ray.origin_slack_m, 0}, visit);
}

struct Closest {
  const scene::CompiledScene& scene;
  Trace result{{}, kInfinity, kInfinity, {}};
  double t_max() const { return result.certain_t; }
  bool before(const Hit& a, const Hit& b) const {
    return scene::user_before(scene, a.instance, a.primitive, b.instance, b.primitive);
  }
  void operator()(const Hit& hit, const LocalRay& ray) {
    const Contact c = contact(scene, hit.primitive, ray);
    if (c.hit && (c.t < result.t || (c.t == result.t && before(hit, result.hit)))) result.hit = hit, result.t = c.t;
    if (c.certain() && c.t + c.t_bound < result.certain_t) result.certain = hit, result.certain_t = c.t + c.t_bound;
  }
};

struct Shadow {
  const scene::CompiledScene& scene;
  Hit from;
  double t_far;
  Visibility result = Visibility::visible;
  double t_max() const { return result == Visibility::blocked ? -1 : t_far; }
  void operator()(const Hit& hit, const LocalRay& ray) {
    if (hit == from || result == Visibility::blocked) return;
    const Contact c = contact(scene, hit.primitive, ray);
    if (c.certain() && c.t + c.t_bound < t_far)
      result = Visibility::blocked;
    else if (c.possible() && c.t - c.t_bound <= t_far)
      result = Visibility::uncertain;
  }
};

Contact contact_of(const scene::CompiledScene& scene, const DoubleRay& ray, const Hit& hit) {
  return contact(scene, hit.primitive, to_local(scene.instances[hit.instance], ray));
}

bool names_a_triangle(const scene::CompiledScene& scene, const Hit& hit) {
  if (hit.instance >= scene.instances.size() || hit.primitive / RC_BLOCK >= scene.blocks.size()) return false;
  const scene::Tree& tree = scene.trees[scene.instances[hit.instance].tree];
  const std::uint32_t block = hit.primitive / RC_BLOCK;
  return block >= tree.first_block && block < tree.first_block + tree.block_count &&
         scene.blocks[block].surface[hit.primitive % RC_BLOCK] != RC_NONE;
}

}  // namespace

const char* cause_name(Cause cause) {
  switch (cause) {
    case Cause::agree:
      return "agree";
    case Cause::exact_tie:
      return "exact tie";
    case Cause::edge_tie:
      return "edge tie";
    case Cause::depth_tie:
      return "depth tie";
    case Cause::grazing:
      return "grazing";
    case Cause::unexplained:
      break;
  }
  return "unexplained";
}

Trace DoubleTracer::trace(const DoubleRay& ray) const {
  Closest visit{scene_};
  walk(scene_, ray, visit);
  return visit.result;
}

Trace DoubleTracer::trace_brute_force(const Ray& ray) const {
  Closest visit{scene_};
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
    const LocalRay local = to_local(scene_.instances[i], to_double(ray));
    const scene::Tree& tree = scene_.trees[scene_.instances[i].tree];
    for (std::uint32_t p = tree.first_block * RC_BLOCK; p < (tree.first_block + tree.block_count) * RC_BLOCK; ++p)
      if (scene::surface_of(scene_, p) != RC_NONE) visit({i, p}, local);
  }
  return visit.result;
}

Cause DoubleTracer::explain(const DoubleRay& ray, const Hit& a, const Hit& b) const {
  if (a == b) return Cause::agree;
  // A certain hit that the walk missed but one of the two found counts as well: the tree itself is not trusted.
  const Trace exact = trace(ray);
  double certain_t = exact.certain_t;
  bool grazing = false, near_edge = false, both_right = true;
  for (const Hit& hit : {a, b}) {
    if (hit.miss()) {
      both_right = false;
      continue;
    }
    if (!names_a_triangle(scene_, hit)) return Cause::unexplained;
    const Contact c = contact_of(scene_, ray, hit);
    if (c.certain()) certain_t = std::min(certain_t, c.t + c.t_bound);
    grazing |= c.grazing;
    near_edge |= c.side == Side::uncertain;
    both_right &= c.hit && c.t <= exact.t * (1 + kSameDepth);
  }
  for (const Hit& hit : {a, b}) {
    if (hit.miss()) {
      if (certain_t < kInfinity) return Cause::unexplained;
      continue;
    }
    const Contact c = contact_of(scene_, ray, hit);
    if (!c.possible() || c.t - c.t_bound > certain_t) return Cause::unexplained;
  }
  if (both_right) return Cause::exact_tie;
  return grazing ? Cause::grazing : near_edge ? Cause::edge_tie : Cause::depth_tie;
}

bool DoubleTracer::hits_anything(const Ray& ray, const Hit& guess) const {
  if (!guess.miss() && names_a_triangle(scene_, guess) && contact_of(scene_, to_double(ray), guess).hit) return true;
  return !trace(ray).hit.miss();
}

Visibility DoubleTracer::visibility(const DoubleRay& ray, const Hit& from, double t_far) const {
  Shadow visit{scene_, from, t_far};
  walk(scene_, ray, visit);
  return visit.result;
}

glm::dvec3 hit_point(const scene::CompiledScene& scene, const Ray& ray, const Hit& hit) {
  return start_of(ray) + contact_of(scene, to_double(ray), hit).t * to_double(ray.direction);
}

}  // namespace raycube::reference
