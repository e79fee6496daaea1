#include "host/render/trace_stages.h"

#include <algorithm>
#include <chrono>

#include "host/base/error.h"
#include "host/base/doing.h"
#include "host/base/sha256.h"
#include "host/render/camera_arguments.h"
#include "host/sensors/ray_groups.h"
#include "kernels/kernel_source.h"

namespace raycube::render {

namespace {

/// The device wants at least one element of everything.
template <class T>
cl::Buffer<T> upload(const cl::Context& context, const std::vector<T>& from, const std::string& what) {
  if (from.empty()) return cl::Buffer<T>(context, std::vector<T>(1), cl::Access::read_only, what);
  return cl::Buffer<T>(context, from, cl::Access::read_only, what);
}

std::vector<shared::rc_float4> sun_only(const plan::Plan& plan) {
  return {{plan.sun_direction[0], plan.sun_direction[1], plan.sun_direction[2], 0}};
}

}  // namespace

struct TraceStages::State {
  State(const cl::Context& context_, const scene::CompiledScene& scene, const SceneBuffers& buffers_,
        const plan::Plan& plan_, const StageShape& shape_, std::uint64_t seed_)
      : context(context_),
        buffers(buffers_),
        plan(plan_),
        shape(shape_),
        seed(static_cast<std::uint32_t>(seed_)),
        options(program_options(shape_, scene.stack_bound()).trace + buffers_.options),
        identity("trace\n" + options + "\n" + std::string(kernels::kernel_source("trace"))),
        program(context_, "trace", kernels::kernel_source("trace"), options),
        primary(program, "trace_primary"),
        surface(program, "make_surface"),
        light(program, "trace_light"),
        sun(upload(context_, sun_only(plan_), "sun direction")),
        directions(upload(context_, plan_.sky.direction, "sky directions")),
        weights(upload(context_, plan_.sky.weight, "sky weights")) {}

  cl_uint first_sample(int chunk) const { return static_cast<cl_uint>(chunk * shape.chunk_samples); }
  cl_uint sample_count(int chunk) const {
    return static_cast<cl_uint>(std::min(shape.chunk_samples, shape.samples - chunk * shape.chunk_samples));
  }
  bool sends_to_sky() const { return shape.sky_shadows && plan.components() > 0; }
  const cl::Kernel& primary_of(const TileLayout& layout, int chunk, TraceBuffers& traced) {
    return primary.arguments(TracePrimaryArguments{.nodes = buffers.nodes,
                                                   .blocks = buffers.blocks,
                                                   .instances = buffers.instances,
                                                   .groups = traced.groups,
                                                   .hits = traced.hits,
                                                   .seed = seed,
                                                   .columns = layout.columns,
                                                   .first_sample = first_sample(chunk),
                                                   .sample_count = sample_count(chunk)});
  }

  const cl::Context& context;
  const SceneBuffers& buffers;
  const plan::Plan& plan;
  StageShape shape;
  std::uint32_t seed;
  std::string options, identity;
  cl::Program program;
  cl::Kernel primary, surface, light;
  cl::Buffer<shared::rc_float4> sun, directions, weights;
  const void* zeroed = nullptr;  ///< buffers whose unused visibility has been cleared
};

TraceStages::TraceStages(const cl::Context& context, const scene::CompiledScene& scene, const SceneBuffers& buffers,
                         const plan::Plan& plan, const StageShape& shape, std::uint64_t seed)
    : state_(std::make_unique<State>(context, scene, buffers, plan, shape, seed)) {}
TraceStages::~TraceStages() = default;

const std::string& TraceStages::identity() const { return state_->identity; }
std::string TraceStages::program_hash() const { return base::sha256_hex(identity()); }
std::string program_hash(const TraceStages& trace, const RowStages& rows) {
  return base::sha256_hex(trace.identity() + rows.identity());
}
const std::string& TraceStages::options() const { return state_->options; }

TileRays tile_rays(const scene::Instrument& instrument, const scene::CompiledScene& scene, const Tile& tile,
                   int pixels_per_group) {
  const auto all = sensors::make_ray_groups(instrument, scene, tile.first_line, tile.lines);
  const int image_groups = sensors::groups_per_line(instrument);
  TileRays rays;
  rays.layout = {static_cast<std::uint32_t>(tile.columns), static_cast<std::uint32_t>(tile.lines),
                 static_cast<std::uint32_t>(pixels_per_group)};
  const auto per_line = static_cast<std::ptrdiff_t>(rays.layout.groups() / rays.layout.lines);
  for (int line = 0; line < tile.lines; ++line) {
    const auto first = all.begin() + line * image_groups + tile.first_column / pixels_per_group;
    rays.groups.insert(rays.groups.end(), first, first + per_line);
  }
  return rays;
}

TileRays listed_rays(std::vector<shared::RayGroup> groups, int pixels_per_group) {
  TileRays rays;
  rays.layout = {static_cast<std::uint32_t>(pixels_per_group), static_cast<std::uint32_t>(groups.size()),
                 static_cast<std::uint32_t>(pixels_per_group)};
  rays.groups = std::move(groups);
  return rays;
}

void TraceStages::run_primary(const TileLayout& layout, int chunk, TraceBuffers& traced) {
  State& s = *state_;
  s.context.launch(s.primary_of(layout, chunk, traced), layout.groups());
  s.context.finish();
}

void TraceStages::run(const TileLayout& layout, int chunk, TraceBuffers& traced,
                      std::map<std::string, double>& stage_s) {
  State& s = *state_;
  const cl_uint first_sample = s.first_sample(chunk), sample_count = s.sample_count(chunk);
  const std::size_t groups = layout.groups();
  const auto launch = [&](const char* stage, const cl::Kernel& kernel) {
    const base::Doing doing("stage", stage);
    const auto start = std::chrono::steady_clock::now();
    s.context.launch(kernel, groups);
    s.context.finish();
    stage_s[stage] += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  };

  if (s.zeroed != &traced) {
    if (!s.plan.sun_up) traced.sun.write(std::vector<std::uint16_t>(traced.sun.size(), 0));
    if (!s.sends_to_sky()) traced.blocked.write(std::vector<float>(traced.blocked.size(), 0.0f));
    s.zeroed = &traced;
  }
  launch("trace_primary", s.primary_of(layout, chunk, traced));
  launch("make_surface", s.surface.arguments(MakeSurfaceArguments{.blocks = s.buffers.blocks,
                                                                  .instances = s.buffers.instances,
                                                                  .lobes = s.buffers.lobes,
                                                                  .groups = traced.groups,
                                                                  .hits = traced.hits,
                                                                  .surface = traced.surface,
                                                                  .lift = traced.lift,
                                                                  .seed = s.seed,
                                                                  .columns = layout.columns,
                                                                  .first_sample = first_sample,
                                                                  .sample_count = sample_count}));
  const auto light = [&](const char* stage, const auto& directions, const auto& weights, bool sky, int sets, int count,
                         int share) {
    launch(stage, s.light.arguments(TraceLightArguments{.nodes = s.buffers.nodes,
                                                        .blocks = s.buffers.blocks,
                                                        .instances = s.buffers.instances,
                                                        .groups = traced.groups,
                                                        .surface = traced.surface,
                                                        .directions = directions,
                                                        .weights = weights,
                                                        .sun = traced.sun,
                                                        .blocked = traced.blocked,
                                                        .sky = cl_uint{sky},
                                                        .sets = static_cast<cl_uint>(sets),
                                                        .count = static_cast<cl_uint>(count),
                                                        .share = static_cast<cl_uint>(share),
                                                        .seed = s.seed,
                                                        .columns = layout.columns,
                                                        .first_sample = first_sample}));
  };
  if (s.plan.sun_up) light("trace_sun", s.sun, s.sun, false, 1, 1, 1);
  if (s.sends_to_sky())
    light("trace_sky", s.directions, s.weights, true, static_cast<int>(s.plan.sky.sets),
          static_cast<int>(s.plan.sky.directions), s.shape.sky_share);
}

}  // namespace raycube::render
