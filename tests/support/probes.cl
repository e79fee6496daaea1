/* Kernels that only tests launch, in one program: each finds with the kernels' own functions what a test knows
 * otherwise (probes.h). */
#include "kernels/geometry/trace_args.h"
#include "kernels/geometry/any_hits16.h"
#include "kernels/geometry/ray_trace.h"
#include "kernels/geometry/samples.h"
#include "kernels/light/sun_points.h"
#include "kernels/lidar/volume.h"
#include "kernels/materials/shapes.h"
#include "kernels/shared/camera_arguments.h"

/* Closest hits and shadows of rays one by one, without a tree (brute_trace.h) and through the trees (trace_chain.h). */
static Hit rc_brute(SceneArrays scene, global const uint* ranges, uint count, float4 origin, float4 offset,
                    float4 direction) {
  Hit hit;
  hit.t = INFINITY;
  hit.instance = hit.primitive = RC_NONE;
  for (uint i = 0; i < count; ++i) {
    global const Instance* placed = rc_instance(scene, i);
    const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
    Ray ray = placed->flags & 1u ? rc_make_ray(origin, direction)
                                 : rc_make_ray(rc_map_point(r0, r1, r2, origin), rc_map_vector(r0, r1, r2, direction));
    ray.offset = placed->flags & 1u ? offset : rc_map_vector(r0, r1, r2, offset);
    for (uint b = ranges[2 * i]; b < ranges[2 * i + 1]; ++b) {
      float16 t;
      const uint lanes = rc_hit_block(ray, true, rc_block(scene, b), &t);
      if (lanes) rc_take_closest(scene, &hit, i, b, lanes, t);
    }
  }
  return hit;
}

kernel void brute_primary(RC_BLOCKS, RC_INSTANCES, global const uint* ranges, uint count, global const RayGroup* groups,
                          global uint* hits, TileShape tile, uint sampler, uint samples_u, uint samples_v,
                          float sample_support, uint seed, uint columns) {
  SceneArrays scene;
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const Sampling sampling = RC_GATHER_SAMPLING();
  const uint index = (uint)get_global_id(0);
  const GroupPlace place = rc_group_place(&tile, groups, index, columns);
  const RayGroup group = rc_group_rays(groups, index);
  for (uint p = 0; p < place.used; ++p) {
    global uint* out = hits + rc_hits_at(&tile, place.pixel + p);
    for (uint k = 0; k < tile.near; ++k) {
      Hit hit;
      hit.instance = hit.primitive = RC_NONE;
      if (k < samples_u * samples_v) {
        float a, b;
        rc_group_sample(sampling, seed, place.number + p, p, k, &a, &b);
        hit =
            rc_brute(scene, ranges, count, group.origin, rc_group_offset(group, a, b), rc_group_direction(group, a, b));
      }
      out[rc_hits_slot(k)] = hit.instance;
      out[rc_hits_slot(k) + RC_PLANE(RC_HIT_PRIMITIVE)] = hit.primitive;
    }
  }
}

/* The samples of a word that see the sun: of those that face it, one by one, by a test without a tree or through the
 * trees. */
static uint rc_seen_alone(SceneArrays scene, global const uint* ranges, uint count, bool without_tree,
                          global const float* at, float4 sun) {
  uint lit = rc_mask16(rc_cosines(sun, at) > 0.0f);
  for (uint left = lit; left; left &= left - 1u) {
    const uint k = rc_lowest(left);
    const float4 point =
        (float4)(at[RC_PLANE(RC_POINT_X) + k], at[RC_PLANE(RC_POINT_Y) + k], at[RC_PLANE(RC_POINT_Z) + k], 0.0f);
    const bool hidden = without_tree ? rc_brute(scene, ranges, count, point, (float4)(0.0f), sun).instance != RC_NONE
                                     : rc_any_hit(scene, point, sun);
    if (hidden) lit &= ~(1u << k);
  }
  return lit;
}

kernel void sun_alone(RC_NODES, RC_BLOCKS, RC_INSTANCES, global const uint* ranges, uint count, uint without_tree,
                      global const float* surface, global ushort* sun_mask, TileShape tile, float4 sun) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const uint pixel = (uint)get_global_id(0);
  for (uint word = 0; word < tile.words; ++word)
    sun_mask[rc_sun_at(&tile, pixel) + word] = (ushort)rc_seen_alone(
        scene, ranges, count, without_tree != 0u, rc_surface_word(&tile, surface, pixel * tile.words + word), sun);
}

/* any_hits.h */
static bool rc_any_without_tree(SceneArrays scene, global const uint* ranges, uint instances, float4 origin,
                                float4 direction) {
  for (uint i = 0; i < instances; ++i) {
    global const Instance* placed = rc_instance(scene, i);
    const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
    const Ray ray = placed->flags & 1u
                        ? rc_make_ray(origin, direction)
                        : rc_make_ray(rc_map_point(r0, r1, r2, origin), rc_map_vector(r0, r1, r2, direction));
    for (uint b = ranges[2 * i]; b < ranges[2 * i + 1]; ++b) {
      float16 t;
      if (rc_hit_block(ray, false, rc_block(scene, b), &t)) return true;
    }
  }
  return false;
}

/* Of the first `count` rays, which go one way, those that an instance hides, all sixteen together. */
static uint rc_any_one_way(SceneArrays scene, uint instances, const Rays16* rays, uint count) {
  uint hidden = 0;
  for (uint i = 0; i < instances; ++i) {
    global const Instance* placed = rc_instance(scene, i);
    const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
    Rays16 moved = *rays;
    for (uint k = 0; k < 16u && !(placed->flags & 1u); ++k)
      rc_put_ray(&moved, k, rc_map_point(r0, r1, r2, (float4)(rays->x[k], rays->y[k], rays->z[k], 0.0f)),
                 rc_map_vector(r0, r1, r2, (float4)(rays->dx[k], rays->dy[k], rays->dz[k], 0.0f)));
    hidden |= rc_tree_hides16(scene, placed->root, &moved, (1u << count) - 1u, true);
  }
  return hidden;
}

kernel void any_hits(RC_NODES, RC_BLOCKS, RC_INSTANCES, global const uint* ranges, uint instances,
                     global const float* rays, uint stride, global uint* answers) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const uint sixteen = (uint)get_global_id(0), count = 1u + sixteen % 16u;
  global const float* at = rays + 16u * sixteen;
  Rays16 together;
  uint alone = 0, without_tree = 0;
  for (uint k = 0; k < count; ++k) {
    const float4 origin = (float4)(at[k], at[stride + k], at[2u * stride + k], 0.0f);
    const float4 direction = (float4)(at[3u * stride + k], at[4u * stride + k], at[5u * stride + k], 0.0f);
    rc_put_ray(&together, k, origin, direction);
    if (rc_any_hit(scene, origin, direction)) alone |= 1u << k;
    if (rc_any_without_tree(scene, ranges, instances, origin, direction)) without_tree |= 1u << k;
  }
  const uint hidden = rc_first_hidden(scene, &together, count, RC_NONE, 0u); /* sets the rays past count */
  bool parallel = true;
  for (uint k = 1; k < count; ++k)
    parallel = parallel && together.dx[k] == together.dx[0] && together.dy[k] == together.dy[0] &&
               together.dz[k] == together.dz[0];
  const uint one_way = parallel ? rc_any_one_way(scene, instances, &together, count) : without_tree;
  vstore4((uint4)(hidden, alone, without_tree, one_way), sixteen, answers);
}

/* Every element of the scene's arrays as kernels read it. */
kernel void read_all(RC_NODES, RC_BLOCKS, RC_INSTANCES, RC_SURFACES, global BvhNode* nodes, global TriBlock* blocks,
                     global Instance* instances, global Surface* surfaces, uint node_count, uint block_count,
                     uint instance_count, uint surface_count) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  RC_GATHER_SURFACES(scene);
  const uint at = get_global_id(0);
  if (at < node_count) nodes[at] = *rc_node(scene, at);
  if (at < block_count) blocks[at] = *rc_block(scene, at);
  if (at < instance_count) instances[at] = *rc_instance(scene, at);
  if (at < surface_count) surfaces[at] = *rc_surface(scene, at);
}

/* Where the layout of a tile puts what (kernels/shared/tile_layout.h). */
kernel void probe_layout(TileShape tile, global ulong* at) {
  at[0] = RC_WORD * tile.words;
  at[1] = rc_near_words(&tile);
  at[2] = rc_hits_at(&tile, 3);
  at[3] = rc_surface_at(&tile, 3);
  at[4] = rc_lift_at(&tile, 3);
  at[5] = rc_sun_at(&tile, 3);
  at[6] = rc_met_sky_at(&tile, 3);
  at[7] = rc_sums_of_key(&tile, 1);
  at[8] = rc_sums_at(&tile, 3, 16);
  at[9] = rc_path_at(&tile, 3);
  at[10] = rc_truth_at(&tile, 3);
  at[11] = rc_glow_at(&tile, 3, 2);
  at[12] = rc_group_of(37, 10, tile.pixels_per_group);
  const uint slot = 16 * tile.words - 3;
  at[13] = rc_hits_slot(5) + RC_PLANE(RC_HIT_PRIMITIVE);
  at[14] = rc_surface_slot(slot) + RC_PLANE(RC_NORMAL_Z);
  at[15] = rc_met_slot(&tile, slot) + RC_PLANE(1);
  at[16] = rc_sample_of(&tile, slot);
  at[17] = rc_side_of(&tile, slot);
  at[18] = rc_slot_of_side(&tile, at[16], at[17]);
}

/* Value and density of BSDF models. */
kernel void probe_shapes(global const uint* shape, global const float4* normal, global const float4* in,
                         global const float4* out, global const float* parameter, global const float* table,
                         global float4* result) {
  const size_t i = get_global_id(0);
  const RcAngles angles = rc_angles(normal[i], in[i], out[i]);
  RcParameters p;
  p.table = table;
  for (int k = 0; k < 6; ++k) p.of[k] = parameter[6 * i + k];
  result[i] = (float4)(rc_shape_eval(shape[i], 1.0f, p, angles), rc_shape_pdf(shape[i], p, angles), 0.0f, 0.0f);
}

/* What rays pass of volumes: [ray][volume]. */
kernel void columns(global const LidarVolume* volumes, global const float* values, global const float4* rays,
                    uint count, global float* out) {
  const uint i = (uint)get_global_id(0), ray = i / count;
  global const LidarVolume* v = volumes + i % count;
  out[i] = v->strength.x * rc_volume_path(v, values, rays[2 * ray], rays[2 * ray + 1], 0.0f, rays[2 * ray + 1].w);
}
