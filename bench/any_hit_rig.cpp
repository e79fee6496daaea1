#include "bench/any_hit_rig.h"

#include "bench/device.h"
#include "bench/timing.h"
#include "host/cl/kernel.h"
#include "host/render/scene_buffers.h"
#include "kernels/kernel_source.h"

namespace raycube::bench {
namespace {

constexpr cl_uint kRaysPerItem = 256;
/// Rays one after the other, as they lie in the pixels they come from. rays: x, y, z, dx, dy, dz, each [count].
constexpr const char* kAnyHits = R"(
kernel void any_hits(RC_NODES, RC_BLOCKS, RC_INSTANCES, global const float* restrict rays,
                     global const uint2* restrict left, global const float* restrict skyline_cells,
                     float4 skyline_frame, uint skyline_instance, uint skyline_columns, uint skyline_rows,
                     global uint2* restrict blocked, uint count, uint per_item) {
  const Skyline skyline = RC_GATHER_SKYLINE();
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const uint first = (uint)get_global_id(0) * per_item, end = min(first + per_item, count);
  uint i = first;
  while (i < end) {
    Rays16 together;
    uint number[16], filled = 0, clear = 0;
    for (; i < end && filled < 16u; ++i) {
      blocked[i] = (uint2)(0u, 0u);
      if (rays[i] != rays[i]) continue;
      const float4 way = (float4)(rays[3 * count + i], rays[4 * count + i], rays[5 * count + i], 0.0f);
      const float4 from = (float4)(rays[i], rays[count + i], rays[2 * count + i], 0.0f);
      rc_put_ray(&together, filled, from, way);
      if (rc_above_skyline(scene, &skyline, left[i].x, from, way)) clear |= 1u << filled;
      number[filled++] = i;
    }
    if (!filled) continue;
    for (uint bits = rc_first_hidden(scene, &together, filled, skyline.instance, clear); bits; bits &= bits - 1u)
      blocked[number[rc_lowest(bits)]] = (uint2)(RC_NONE, 0u);
  }
}
)";

constexpr const char* kClosestHits = R"(
kernel void closest_hits(RC_NODES, RC_BLOCKS, RC_INSTANCES, global const float* restrict rays,
                         global uint2* restrict hits, uint count, uint per_item) {
  SceneArrays scene;
  RC_GATHER_NODES(scene);
  RC_GATHER_BLOCKS(scene);
  RC_GATHER_INSTANCES(scene);
  const uint first = (uint)get_global_id(0) * per_item, end = min(first + per_item, count);
  for (uint i = first; i < end; ++i) {
    hits[i] = (uint2)(RC_NONE, RC_NONE);
    if (rays[i] != rays[i]) continue;
    const Hit hit = rc_trace_ray(scene, (float4)(rays[i], rays[count + i], rays[2 * count + i], 0.0f),
                                 (float4)(rays[3 * count + i], rays[4 * count + i], rays[5 * count + i], 0.0f));
    hits[i] = (uint2)(hit.instance, hit.primitive);
  }
}
)";

std::vector<float> side_by_side(const ShadowRays& rays) {
  std::vector<float> all;
  for (const std::vector<float>* part : {&rays.x, &rays.y, &rays.z, &rays.dx, &rays.dy, &rays.dz})
    all.insert(all.end(), part->begin(), part->end());
  return all;
}

}  // namespace

struct AnyHitRig::State {
  State(const scene::CompiledScene& scene, const ShadowRays& shadows, const std::vector<RayResult>& hits, int threads)
      : context(pick_device(threads)),
        buffers(context, scene),
        program(context, "any_hits", std::string(kernels::kernel_source("trace_light")) + kAnyHits,
                "-cl-std=CL1.2 -D RC_STACK=" + std::to_string(scene.stack_bound()) + buffers.options),
        kernel(program, "any_hits"),
        rays(context, side_by_side(shadows), cl::Access::read_only, "rays of the bench"),
        left(context, hits, cl::Access::read_only, "where rays leave"),
        blocked(context, shadows.x.size(), cl::Access::write_only, "results of the bench"),
        count(static_cast<cl_uint>(shadows.x.size())) {
    kernel.arguments(buffers.nodes, buffers.blocks, buffers.instances, rays, left, buffers.skyline_cells,
                     shared::rc_float4{buffers.skyline.x_m, buffers.skyline.y_m, buffers.skyline.per_cell, 0},
                     buffers.skyline.instance, buffers.skyline.columns, buffers.skyline.rows, blocked, count,
                     kRaysPerItem);
  }

  cl::Context context;
  render::SceneBuffers buffers;
  cl::Program program;
  cl::Kernel kernel;
  cl::Buffer<float> rays;
  cl::Buffer<RayResult> left, blocked;
  cl_uint count;
};

AnyHitRig::AnyHitRig(const scene::CompiledScene& scene, const ShadowRays& rays, const std::vector<RayResult>& hits,
                     int threads)
    : state_(std::make_unique<State>(scene, rays, hits, threads)) {}
AnyHitRig::~AnyHitRig() = default;

double AnyHitRig::run() {
  return seconds_of([this] {
    state_->context.launch(state_->kernel, (state_->count + kRaysPerItem - 1) / kRaysPerItem);
    state_->context.finish();
  });
}

std::vector<RayResult> AnyHitRig::results() const { return state_->blocked.read_all(); }

struct ClosestHitRig::State {
  State(const scene::CompiledScene& scene, const ShadowRays& own, int threads)
      : context(pick_device(threads)),
        buffers(context, scene),
        program(context, "closest_hits", std::string(kernels::kernel_source("trace_primary")) + kClosestHits,
                "-cl-std=CL1.2 -D RC_BOUNCES=1 -D RC_STACK=" + std::to_string(scene.stack_bound()) + buffers.options),
        kernel(program, "closest_hits"),
        rays(context, side_by_side(own), cl::Access::read_only, "rays of the bench"),
        hits(context, own.x.size(), cl::Access::write_only, "results of the bench"),
        count(static_cast<cl_uint>(own.x.size())) {
    kernel.arguments(buffers.nodes, buffers.blocks, buffers.instances, rays, hits, count, kRaysPerItem);
  }

  cl::Context context;
  render::SceneBuffers buffers;
  cl::Program program;
  cl::Kernel kernel;
  cl::Buffer<float> rays;
  cl::Buffer<RayResult> hits;
  cl_uint count;
};

ClosestHitRig::ClosestHitRig(const scene::CompiledScene& scene, const ShadowRays& rays, int threads)
    : state_(std::make_unique<State>(scene, rays, threads)) {}
ClosestHitRig::~ClosestHitRig() = default;

double ClosestHitRig::run() {
  return seconds_of([this] {
    state_->context.launch(state_->kernel, (state_->count + kRaysPerItem - 1) / kRaysPerItem);
    state_->context.finish();
  });
}

std::vector<RayResult> ClosestHitRig::results() const { return state_->hits.read_all(); }

}  // namespace raycube::bench
