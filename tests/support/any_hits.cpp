#include "tests/support/any_hits.h"

#include "kernels/kernel_source.h"
#include "tests/support/brute_trace.h"

namespace raycube::test {
namespace {

constexpr const char* kAnyHits = R"(
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
)";

}  // namespace

std::vector<AnyAnswers> any_hits(const cl::Context& context, const scene::CompiledScene& scene, const AnyRays& rays) {
  const std::size_t sixteens = rays.x.size() / 16;
  std::vector<float> all;
  for (const std::vector<float>* part : {&rays.x, &rays.y, &rays.z, &rays.dx, &rays.dy, &rays.dz})
    all.insert(all.end(), part->begin(), part->end());
  const render::SceneBuffers buffers(context, scene);
  const cl::Program program(context, "any_hits", std::string(kernels::kernel_source("trace_light")) + kAnyHits,
                            trace_options(TraceShape{}, scene, "trace_light") + buffers.options);
  cl::Kernel kernel(program, "any_hits");
  const cl::Buffer<std::uint32_t> ranges(context, block_ranges(scene), cl::Access::read_only, "blocks of instances");
  const cl::Buffer<float> sent(context, all, cl::Access::read_only, "rays");
  const cl::Buffer<std::uint32_t> answers(context, 4 * sixteens, cl::Access::write_only, "answers");
  kernel.arguments(buffers.nodes, buffers.blocks, buffers.instances, ranges,
                   static_cast<std::uint32_t>(scene.instances.size()), sent, static_cast<std::uint32_t>(rays.x.size()),
                   answers);
  context.launch(kernel, sixteens);
  context.finish();
  const std::vector<std::uint32_t> words = answers.read_all();
  std::vector<AnyAnswers> found;
  for (std::size_t i = 0; i < words.size(); i += 4)
    found.push_back({words[i], words[i + 1], words[i + 2], words[i + 3]});
  return found;
}

}  // namespace raycube::test
