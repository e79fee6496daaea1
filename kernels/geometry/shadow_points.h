/* Which of many points see a direction that they share (sun, sky). One walk of the top tree serves them all; a placed
 * mesh that it reaches is met by a bundle while that pays (terrain, walls: few triangles per point), else ray by ray
 * (crowns). Every decision is that of the single-ray test, so the choice cannot change a result. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_SHADOW_POINTS_H
#define RAYCUBE_KERNELS_GEOMETRY_SHADOW_POINTS_H

#include "kernels/geometry/bundle_shadow.h"
#include "kernels/geometry/tree_hides16.h"

/* What a bundle may spend in one placed mesh, in candidate triangles as rc_shadow_block counts them: a constant, which
 * holds what terrain and walls take, and a share per point whose ray meets the mesh's box. Past it the remaining points
 * go ray by ray: in crowns a bundle sets up many triangles per point. Choice changes time, never a result. */
#define RC_BUNDLE_BUDGET(points) (64u + (points) / 2u)
#define RC_FEW_POINTS 4u

/* Bits of a number below 32, one apart. */
static inline uint rc_spread_bits(uint v) {
  v = (v | v << 4) & 0x10Fu; /* ..e....dcba */
  v = (v | v << 2) & 0x133u;
  return (v | v << 1) & 0x155u;
}

/* Cells of the plane across the direction by which points are put in order: so many on its longer side, a power of two.
 */
#define RC_PLANE_CELLS 32u

/* Live points among `met`, in the order of a Z-curve over the plane across the direction, into `order`; their number.
 * Sixteen that follow one another then go the same way close together, whatever their distances along it. */
static inline uint rc_order_points(const Points* points, const ushort* met, ushort* order) {
  float lo_a = INFINITY, hi_a = -INFINITY, lo_b = INFINITY, hi_b = -INFINITY;
  for (uint word = 0; word < points->words; ++word) {
    if (!(points->live[word] & met[word])) continue;
    lo_a = fmin(lo_a, points->lo_a[word]);
    hi_a = fmax(hi_a, points->hi_a[word]);
    lo_b = fmin(lo_b, points->lo_b[word]);
    hi_b = fmax(hi_b, points->hi_b[word]);
  }
  const float per_m = (float)RC_PLANE_CELLS / fmax(fmax(hi_a - lo_a, hi_b - lo_b), 1e-30f);
  ushort cell[RC_POINTS], first[RC_PLANE_CELLS * RC_PLANE_CELLS];
  for (uint i = 0; i < RC_PLANE_CELLS * RC_PLANE_CELLS; ++i) first[i] = 0;
  uint count = 0;
  for (uint word = 0; word < points->words; ++word)
    for (uint bits = points->live[word] & met[word]; bits; bits &= bits - 1u) {
      const uint k = word * 16u + rc_lowest(bits);
      const uint i = min((uint)((points->a[k] - lo_a) * per_m), RC_PLANE_CELLS - 1u);
      const uint j = min((uint)((points->b[k] - lo_b) * per_m), RC_PLANE_CELLS - 1u);
      cell[k] = (ushort)(rc_spread_bits(i) | rc_spread_bits(j) << 1);
      ++first[cell[k]];
      ++count;
    }
  uint next = 0;
  for (uint i = 0; i < RC_PLANE_CELLS * RC_PLANE_CELLS; ++i) {
    const uint in = first[i];
    first[i] = (ushort)next;
    next += in;
  }
  for (uint word = 0; word < points->words; ++word)
    for (uint bits = points->live[word] & met[word]; bits; bits &= bits - 1u) {
      const uint k = word * 16u + rc_lowest(bits);
      order[first[cell[k]]++] = (ushort)k;
    }
  return count;
}

/* Clears the live points among `met` (a word of bits each) that the placed mesh hides, by sixteen. */
__attribute__((noinline)) static void rc_shadow_rays(SceneArrays scene, uint root, const ShadowFrame* frame,
                                                     Points* points, const ushort* met) {
  ushort order[RC_POINTS];
  const uint count = rc_order_points(points, met, order);
  const float4 way = frame->ray.direction;
  for (uint first = 0; first < count; first += 16u) {
    const uint together = min(count - first, 16u);
    Rays16 rays;
    for (uint i = 0; i < 16u; ++i) {
      const uint k = order[first + (i < together ? i : 0u)];
      float4 origin = (float4)(points->x[k], points->y[k], points->z[k], 0.0f);
      if (!frame->same) origin = rc_map_point(frame->l0, frame->l1, frame->l2, origin);
      rc_put_ray(&rays, i, origin, way);
    }
    for (uint hidden = rc_tree_hides16(scene, root, &rays, (1u << together) - 1u, true); hidden;
         hidden &= hidden - 1u) {
      const uint k = order[first + rc_lowest(hidden)];
      points->live[k / 16u] &= ~(1u << k % 16u);
    }
  }
  for (uint word = 0; word < points->words; ++word)
    if (!points->live[word]) rc_empty_word(points, word);
}

/* The live points whose rays meet a box of the top tree grown by `slack` (m), and their number. The test of
 * rc_boxes_met. */
static inline uint rc_rays_at_box(const Points* points, global const BvhNode* node, uint slot, float slack,
                                  ushort* met) {
  const float ix = rc_safe_inverse(points->towards.x), iy = rc_safe_inverse(points->towards.y),
              iz = rc_safe_inverse(points->towards.z);
  const float lo_x = node->lo_x[slot] - slack, lo_y = node->lo_y[slot] - slack, lo_z = node->lo_z[slot] - slack;
  const float hi_x = node->hi_x[slot] + slack, hi_y = node->hi_y[slot] + slack, hi_z = node->hi_z[slot] + slack;
  const float16 near_x = ix < 0.0f ? hi_x : lo_x, far_x = ix < 0.0f ? lo_x : hi_x;
  const float16 near_y = iy < 0.0f ? hi_y : lo_y, far_y = iy < 0.0f ? lo_y : hi_y;
  const float16 near_z = iz < 0.0f ? hi_z : lo_z, far_z = iz < 0.0f ? lo_z : hi_z;
  uint count = 0;
  for (uint word = 0; word < points->words; ++word) {
    const float16 x = rc_load16(word, points->x), y = rc_load16(word, points->y), z = rc_load16(word, points->z);
    const float16 enter = rc_max16(rc_max16((near_x - x) * ix, (near_y - y) * iy), rc_max16((near_z - z) * iz, 0.0f));
    const float16 leave = rc_min16(rc_min16((far_x - x) * ix, (far_y - y) * iy), (far_z - z) * iz);
    const uint bits = points->live[word] ? rc_mask16(enter <= leave) & points->live[word] : 0u;
    met[word] = (ushort)bits;
    count += popcount(bits);
  }
  return count;
}

/* One bundle through one placed mesh; stops when it has cost more than `budget`. Returns whether it came to the end. */
__attribute__((noinline)) static bool rc_shadow_mesh(SceneArrays scene, uint root, const ShadowFrame* frame,
                                                     const Cull* cull, const Cluster* cluster, Points* points,
                                                     uint budget, uint* stack, uint base) {
  uint top = base, cost = 0;
  stack[top++] = root;
  while (top > base) {
    const uint entry = stack[--top];
    if (!(entry & RC_LEAF)) {
      top = rc_push_children(cull, 5, scene, entry, true, stack, top);
      continue;
    }
    cost += rc_shadow_block(frame, cluster, points, rc_block(scene, entry & ~RC_LEAF));
    if (!rc_points_left(points)) return true;
    if (cost > budget) return false;
  }
  return true;
}

static inline void rc_shadow_cluster(SceneArrays scene, Points* points, Cluster cluster) {
  /* The scene's own frame, to walk the top tree. */
  Cull world;
  const float growth = 16.0f * RC_ULP, slack = (10.0f * RC_ULP + growth) * cluster.reach;
  const float4 widen = growth * points->towards;
  world.ox = points->centre.x;
  world.oy = points->centre.y;
  world.oz = points->centre.z;
  rc_set_plane(&world, 0, widen + points->across_a, slack - cluster.lo_a);
  rc_set_plane(&world, 1, widen - points->across_a, slack + cluster.hi_a);
  rc_set_plane(&world, 2, widen + points->across_b, slack - cluster.lo_b);
  rc_set_plane(&world, 3, widen - points->across_b, slack + cluster.hi_b);
  rc_set_plane(&world, 4, points->towards, slack - cluster.lo_d);
  const float4 centre = fabs(points->centre);
  const float box_slack = RC_WORLD_SLACK * RC_ULP *
                          (rc_node(scene, 0u)->reach + fmax(centre.x, fmax(centre.y, centre.z)) + 2.0f * cluster.reach);
  ushort met[RC_WORD_SLOTS];
  uint stack[RC_STACK + RC_STACK_SPARE];
  uint top = 1;
  stack[0] = 0;
  while (top) {
    global const BvhNode* node = rc_node(scene, stack[--top]);
    const uint boxes = rc_cull_boxes(&world, 5, node);
    for (uint inner = boxes & ~node->leaf_mask; inner; inner &= inner - 1u)
      stack[top++] = node->child[rc_lowest(inner)];
    for (uint leaves = boxes & node->leaf_mask; leaves; leaves &= leaves - 1u) {
      const uint slot = rc_lowest(leaves);
      const uint instance = node->child[slot];
      if (instance == points->ground) continue;
      uint count = rc_rays_at_box(points, node, slot, box_slack, met);
      if (!count) continue;
      global const Instance* placed = rc_instance(scene, instance);
      const uint tree = 1u << (placed->tree & 31u);
      ShadowFrame frame;
      rc_frame_rays(points, placed, &frame);
      if (count > RC_FEW_POINTS && !(points->costly & tree)) {
        Cull cull;
        const float extent = (node->hi_x[slot] - node->lo_x[slot]) + (node->hi_y[slot] - node->lo_y[slot]) +
                             (node->hi_z[slot] - node->lo_z[slot]);
        rc_frame_bundle(points, &cluster, placed, extent, &frame, &cull);
        if (!rc_shadow_mesh(scene, placed->root, &frame, &cull, &cluster, points, RC_BUNDLE_BUDGET(count), stack, top))
          points->costly |= tree;
        else
          count = 0;
      }
      if (count) rc_shadow_rays(scene, placed->root, &frame, points, met);
      if (!rc_points_left(points)) return;
    }
  }
}

/* Clears from points->live the points that something hides in the direction. Precondition: x, y, z, live, words,
 * costly and ground set. */
static inline void rc_shadow_points(SceneArrays scene, float4 towards, Points* points) {
  if (!rc_points_left(points)) return;
  for (uint word = points->words; word < points->word_slots; ++word) rc_empty_word(points, word);
  rc_project_points(points, towards);
  rc_shadow_cluster(scene, points, rc_cluster(points));
}

#endif
