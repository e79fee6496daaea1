#include "tests/support/brute_trace.h"

#include "kernels/kernel_source.h"

namespace raycube::test {
namespace {

constexpr const char* kBruteSource = R"(
static Hit brute(global const TriBlock* blocks, global const Instance* instances, global const uint* ranges, uint count,
                 float4 origin, float4 offset, float4 direction) {
  SceneArrays scene;
  scene.blocks[0] = blocks;
  scene.instances[0] = instances;
  Hit hit;
  hit.t = INFINITY;
  hit.instance = hit.primitive = RC_NONE;
  for (uint i = 0; i < count; ++i) {
    global const Instance* placed = instances + i;
    const float4 r0 = placed->local_from_world_0, r1 = placed->local_from_world_1, r2 = placed->local_from_world_2;
    Ray ray = placed->flags & 1u ? rc_make_ray(origin, direction)
                                 : rc_make_ray(rc_map_point(r0, r1, r2, origin), rc_map_vector(r0, r1, r2, direction));
    ray.offset = placed->flags & 1u ? offset : rc_map_vector(r0, r1, r2, offset);
    for (uint b = ranges[2 * i]; b < ranges[2 * i + 1]; ++b) {
      float16 t;
      const uint lanes = rc_hit_block(ray, true, blocks + b, &t);
      if (lanes) rc_take_closest(scene, &hit, i, b, lanes, t);
    }
  }
  return hit;
}

kernel void brute_primary(global const TriBlock* blocks, global const Instance* instances,
                          global const uint* ranges, uint count,
                          global const RayGroup* groups, global uint* hits, TileShape tile, uint sampler,
                          uint samples_u, uint samples_v, float sample_support, uint seed, uint columns) {
  const Sampling sampling = RC_GATHER_SAMPLING();
  const uint index = get_global_id(0);
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
        hit = brute(blocks, instances, ranges, count, group.origin, rc_group_offset(group, a, b),
                    rc_group_direction(group, a, b));
      }
      out[rc_hits_slot(k)] = hit.instance;
      out[rc_hits_slot(k) + RC_PLANE(RC_HIT_PRIMITIVE)] = hit.primitive;
    }
  }
}

kernel void brute_sun(global const TriBlock* blocks, global const Instance* instances,
                      global const uint* ranges, uint count,
                      global const float* surface, global ushort* sun_mask, TileShape tile, float4 sun) {
  const uint pixel = get_global_id(0);
  global const float* in = surface + rc_surface_at(&tile, pixel);
  for (uint word = 0; word < tile.words; ++word) {
    uint seen = 0;
    for (uint k = word * 16u; k < word * 16u + 16u; ++k) {
      global const float* at = in + rc_surface_slot(k);
      const float4 normal =
          (float4)(at[RC_PLANE(RC_NORMAL_X)], at[RC_PLANE(RC_NORMAL_Y)], at[RC_PLANE(RC_NORMAL_Z)], 0.0f);
      const float4 point =
          (float4)(at[RC_PLANE(RC_POINT_X)], at[RC_PLANE(RC_POINT_Y)], at[RC_PLANE(RC_POINT_Z)], 0.0f);
      if (!(fma(sun.x, normal.x, fma(sun.y, normal.y, sun.z * normal.z)) > 0.0f)) continue;
      if (brute(blocks, instances, ranges, count, point, (float4)(0.0f), sun).instance == RC_NONE)
        seen |= 1u << (k % 16u);
    }
    sun_mask[rc_sun_at(&tile, pixel) + word] = (ushort)seen;
  }
}
)";

}  // namespace

std::vector<std::uint32_t> block_ranges(const scene::CompiledScene& scene) {
  std::vector<std::uint32_t> ranges;
  for (const auto& placed : scene.instances) {
    const auto& tree = scene.trees[placed.tree];
    ranges.insert(ranges.end(), {tree.first_block, tree.first_block + tree.block_count});
  }
  return ranges;
}

BruteTrace::BruteTrace(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape)
    : context_(context),
      shape_(shape),
      count_(static_cast<std::uint32_t>(scene.instances.size())),
      program_(context, "brute", std::string(kernels::kernel_source("trace_primary")) + kBruteSource,
               trace_options(shape, scene, "trace_primary")),
      primary_(program_, "brute_primary"),
      sun_(program_, "brute_sun"),
      blocks_(context, scene.blocks, cl::Access::read_only, "triangle blocks"),
      instances_(context, scene.instances, cl::Access::read_only, "instances"),
      ranges_(context, block_ranges(scene), cl::Access::read_only, "blocks of instances"),
      groups_(context, shape.groups(), cl::Access::read_only, "ray groups"),
      hits_(context, shape.pixels() * shape.elements().hits, cl::Access::read_write, "hits"),
      points_(context, shape.pixels() * shape.elements().surface, cl::Access::read_only, "surface points"),
      sun_mask_(context, shape.pixels() * shape.elements().sun, cl::Access::read_write, "sun masks") {}

std::vector<std::uint32_t> BruteTrace::primary(std::span<const shared::RayGroup> groups) {
  groups_.write(numbered(groups, shape_));
  primary_.arguments(blocks_, instances_, ranges_, count_, groups_, hits_, shape_.arguments(),
                     static_cast<std::uint32_t>(shape_.sampler), static_cast<std::uint32_t>(shape_.nu),
                     static_cast<std::uint32_t>(shape_.nv), shape_.support, shape_.seed, shape_.columns);
  context_.launch(primary_, shape_.groups());
  context_.finish();
  return hits_.read_all();
}

std::vector<std::uint16_t> BruteTrace::sun(std::span<const float> points, const shared::rc_float4& direction) {
  points_.write(points);
  sun_.arguments(blocks_, instances_, ranges_, count_, points_, sun_mask_, shape_.arguments(), direction);
  context_.launch(sun_, shape_.pixels());
  context_.finish();
  return sun_mask_.read_all();
}

}  // namespace raycube::test
