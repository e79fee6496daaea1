#include "host/render/trace_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include "host/base/error.h"
#include "host/base/doing.h"
#include "host/base/sha256.h"
#include "host/plan/sky_rays.h"
#include "host/render/camera_arguments.h"
#include "host/sensors/ray_groups.h"
#include "kernels/kernel_source.h"
#include "kernels/materials/shapes.h"
#include "scene_compiler/matter.h"

namespace raycube::render {

namespace {

/// The sky's maps as trace_sky reads them (kernels/light/sky_map.h).
struct SkyMapBuffers {
  SkyMapBuffers(const cl::Context& context, const plan::Plan& plan)
      : solar(context, quads(plan.sky_basis), cl::Access::read_only, "sky map"),
        zenith(context, plan::searched_nodes(plan.sky_basis.zenith_rad), cl::Access::read_only,
               "zeniths of the sky map"),
        azimuth(context, plan::searched_nodes(plan.sky_basis.azimuth_rad), cl::Access::read_only,
                "azimuths of the sky map"),
        thermal(context, first_column(plan.thermal.basis), cl::Access::read_only, "thermal sky map"),
        thermal_zenith(context, plan::searched_nodes(plan.thermal.basis.zenith_rad), cl::Access::read_only,
                       "zeniths of the thermal sky map") {}
  cl::Buffer<shared::rc_float4> solar;
  cl::Buffer<float> zenith, azimuth;
  cl::Buffer<shared::rc_float4> thermal;
  cl::Buffer<float> thermal_zenith;

 private:
  static shared::rc_float4 quad(const std::array<double, 4>& v) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), static_cast<float>(v[3])};
  }
  static std::vector<shared::rc_float4> quads(const plan::SkyBasis& basis) {
    std::vector<shared::rc_float4> out;
    for (const auto& value : basis.value) out.push_back(quad(value));
    return out;
  }
  /// Of maps of zenith angle alone.
  static std::vector<shared::rc_float4> first_column(const plan::SkyBasis& basis) {
    std::vector<shared::rc_float4> out;
    for (std::size_t i = 0; i < basis.value.size(); i += basis.azimuth_rad.size()) out.push_back(quad(basis.value[i]));
    return out;
  }
};

/// Lamps as kernels read them.
struct LampBuffers {
  LampBuffers(const cl::Context& context, const plan::Lamps& plan)
      : lamps(context, plan.lamp, cl::Access::read_only, "lamps"),
        first(context, plan.first, cl::Access::read_only, "sources of lamps"),
        distribution(context, plan.distribution, cl::Access::read_only, "distributions of lamps") {}
  cl::Buffer<shared::Lamp> lamps;
  cl::Buffer<std::uint32_t> first;
  cl::Buffer<float> distribution;
};

/// trace_bounce and what it reads beside the scene.
struct PathStage {
  PathStage(const cl::Context& context, const std::string& options, const plan::Plan& plan, const StageShape& shape,
            std::optional<sensors::SampleWeights> weights_)
      : program(context.program("trace_bounce", kernels::kernel_source("trace_bounce"), options)),
        kernel(*program, "trace_bounce"),
        scattering(context, plan.bounces.scattering, cl::Access::read_only, "scattering of surfaces"),
        curve(context, plan.bounces.curve, cl::Access::read_only, "curves of the skeleton"),
        albedo(context, plan.thermal.albedo, cl::Access::read_only, "albedos of lobes"),
        albedo_at(context, plan.thermal.albedo_at, cl::Access::read_only, "albedo tables of lobes"),
        share(context, plan.bounces.source_share, cl::Access::read_only, "sources of the skeleton"),
        ground(context, plan.bounces.ground, cl::Access::read_only, "ground around a scene"),
        weight(context, shape.tile().near, cl::Access::read_only, "sample weights"),
        weights(std::move(weights_)) {}

  /// The chunk's weights are in `weight` from here on.
  void load(const cl::Context& context, int chunk, std::size_t first, std::size_t count) {
    if (chunk == loaded_chunk) return;
    std::vector<float> padded = weights ? weights->stretch(first, count) : std::vector<float>(count, 1.0f);
    padded.resize(weight.size(), 0.0f);
    context.finish();  // a launch may still read the chunk before
    weight.write(padded);
    loaded_chunk = chunk;
  }

  std::shared_ptr<const cl::Program> program;
  cl::Kernel kernel;
  cl::Buffer<shared::rc_float4> scattering;
  cl::Buffer<float> curve, albedo;
  cl::Buffer<std::uint32_t> albedo_at;
  cl::Buffer<float> share, ground, weight;
  std::optional<sensors::SampleWeights> weights;
  int loaded_chunk = -1;
};

std::string identity_of(const char* program, const std::string& options) {
  return program + ("\n" + options) + "\n" + std::string(kernels::kernel_source(program));
}

/// Records of BSDFs by which every surface reflects as Lambert's law has it and lets through what it does.
std::vector<shared::Lobe> lambertian_lobes(const scene::CompiledScene& scene) {
  std::vector<shared::Lobe> lobes = scene::camera_lobes(scene);
  const std::size_t records = scene::lobe_records(scene);
  lobes.resize(std::max(lobes.size(), scene.surfaces.size() * records));
  for (std::size_t surface = 0; surface < scene.surfaces.size(); ++surface)
    lobes[surface * records] = {.shape = RC_SHAPE_lambert, .share = 1, .parameter = {}};
  return lobes;
}

StageShape without_sky(StageShape shape) {
  shape.components = shape.thermal_components = shape.lamps = 0, shape.bounces = false;
  return shape;
}

/// SHA-256 of two texts, one after the other. The last few are kept: small images, as trials and measures make many of,
/// would spend most of their time on the hashes of half a megabyte of kernels.
std::string hash_of(const std::string& first, const std::string& second) {
  struct Known {
    std::string first, second, hash;
  };
  constexpr std::size_t kKept = 8;
  static std::mutex one_at_a_time;
  static std::vector<Known> known;  // the last one asked for at the end
  const std::lock_guard lock(one_at_a_time);
  const auto found = std::find_if(known.rbegin(), known.rend(),
                                  [&](const Known& k) { return k.first == first && k.second == second; });
  if (found != known.rend()) {
    std::rotate(found.base() - 1, found.base(), known.end());
  } else {
    if (known.size() == kKept) known.erase(known.begin());
    known.push_back({first, second, base::sha256_hex(first + second)});
  }
  return known.back().hash;
}

}  // namespace

struct TraceStages::State {
  State(const cl::Context& context_, const scene::CompiledScene& scene, const SceneBuffers& buffers_,
        const plan::Plan& plan_, const StageShape& shape_, std::uint64_t seed_,
        std::optional<sensors::SampleWeights> weights_)
      : context(context_),
        buffers(buffers_),
        plan(plan_),
        shape(shape_),
        tile(shape_.arguments()),
        seed(static_cast<std::uint32_t>(seed_)),
        lowest(static_cast<float>(scene.lo[2])),
        primary_options(options_of(shape_, scene).primary + buffers_.options),
        options(options_of(shape_, scene).trace + buffers_.options),
        path_options(options_of(shape_, scene).paths + buffers_.options),
        identity(sampling.text() + identity_of("trace_primary", primary_options) + identity_of("trace_light", options) +
                 (shape_.bounces ? identity_of("trace_bounce", path_options) : "")),
        surfaces_identity(sampling.text() + identity_of("trace_primary", primary_options) +
                          identity_of("trace_light", options_of(without_sky(shape_), scene).trace + buffers_.options)),
        primary_program(context_.program("trace_primary", kernels::kernel_source("trace_primary"), primary_options)),
        program(context_.program("trace_light", kernels::kernel_source("trace_light"), options)),
        primary(*primary_program, "trace_primary"),
        surface(*program, "make_surface"),
        sun(*program, "trace_sun"),
        sky(*program, "trace_sky"),
        sky_map(context_, plan_),
        lamp_tables(context_, plan_.lamps),
        open_share(context_, open_shares(buffers_, plan_, shape_), cl::Access::read_only, "open share of surfaces") {
    if (shape.lambertian)
      own_lobes.emplace(context, lambertian_lobes(scene), cl::Access::read_only, "Lambertian surfaces");
    if (shape.lamps > 0) lamps.emplace(*program, "trace_lamps");
    if (shape.first_opaque) opaque.emplace(*program, "first_opaque");
    if (shape.bounces) paths.emplace(context, path_options, plan, shape, std::move(weights_));
  }

  const cl::Buffer<shared::Lobe>& lobes() const { return own_lobes ? *own_lobes : buffers.lobes; }
  ProgramOptions options_of(const StageShape& of, const scene::CompiledScene& scene) const {
    return program_options(of, scene.stack_bound(), context.device().info().is_cpu);
  }
  /// How a pixel's samples lie, as kernels take it.
  struct Sampling {
    explicit Sampling(const StageShape& shape)
        : sampler(static_cast<cl_uint>(shape.sampler)),
          samples_u(static_cast<cl_uint>(shape.samples_u)),
          samples_v(static_cast<cl_uint>(shape.samples_v)),
          support(shape.support_px) {}
    /// For hashes of what was launched.
    std::string text() const { return fmt::format("samples {} {} {} {}\n", sampler, samples_u, samples_v, support); }
    cl_uint sampler, samples_u, samples_v;
    float support;
  };
  cl_uint first_sample(int chunk) const { return static_cast<cl_uint>(chunk * shape.chunk_samples); }
  cl_uint sample_count(int chunk) const {
    return static_cast<cl_uint>(std::min(shape.chunk_samples, shape.samples - chunk * shape.chunk_samples));
  }
  bool sends_to_sky() const { return shape.sky_shadows && plan.components() > 0; }
  const cl::Kernel& primary_of(const TileLayout& layout, int chunk, TraceBuffers& traced) {
    return primary.arguments(TracePrimaryArguments{.tile = tile,
                                                   .nodes = buffers.nodes,
                                                   .blocks = buffers.blocks,
                                                   .instances = buffers.instances,
                                                   .groups = traced.groups,
                                                   .hits = traced.hits,
                                                   .sampler = sampling.sampler,
                                                   .samples_u = sampling.samples_u,
                                                   .samples_v = sampling.samples_v,
                                                   .sample_support = sampling.support,
                                                   .seed = seed,
                                                   .columns = layout.columns,
                                                   .first_sample = first_sample(chunk),
                                                   .sample_count = sample_count(chunk)});
  }

  shared::rc_float4 sun_direction() const {
    return {plan.sun_direction[0], plan.sun_direction[1], plan.sun_direction[2], 0};
  }
  shared::rc_float4 sun_azimuth() const {
    const double azimuth = plan.sky.sun_azimuth_rad;
    return {static_cast<float>(std::sin(azimuth)), static_cast<float>(std::cos(azimuth)), 0, 0};
  }
  shared::rc_float4 skyline_frame() const {
    return {buffers.skyline.x_m, buffers.skyline.y_m, buffers.skyline.per_cell, 0};
  }
  const cl::Kernel& sun_of(const TileLayout& layout, TraceBuffers& traced) {
    return sun.arguments(TraceSunArguments{.tile = tile,
                                           .nodes = buffers.nodes,
                                           .blocks = buffers.blocks,
                                           .instances = buffers.instances,
                                           .groups = traced.groups,
                                           .hits = traced.hits,
                                           .surface = traced.surface,
                                           .skyline_cells = buffers.skyline_cells,
                                           .skyline_frame = skyline_frame(),
                                           .skyline_instance = buffers.skyline.instance,
                                           .skyline_columns = buffers.skyline.columns,
                                           .skyline_rows = buffers.skyline.rows,
                                           .direction = sun_direction(),
                                           .sun = traced.sun,
                                           .columns = layout.columns});
  }
  const cl::Kernel& sky_of(const TileLayout& layout, int chunk, TraceBuffers& traced) {
    const SkyDensity law = plan::sky_density(plan);
    return sky.arguments(
        TraceSkyArguments{.tile = tile,
                          .nodes = buffers.nodes,
                          .blocks = buffers.blocks,
                          .instances = buffers.instances,
                          .lobes = lobes(),
                          .groups = traced.groups,
                          .hits = traced.hits,
                          .surface = traced.surface,
                          .skyline_cells = buffers.skyline_cells,
                          .skyline_frame = skyline_frame(),
                          .skyline_instance = buffers.skyline.instance,
                          .skyline_columns = buffers.skyline.columns,
                          .skyline_rows = buffers.skyline.rows,
                          .open_share = open_share,
                          .sky_map = sky_map.solar,
                          .sky_zenith = sky_map.zenith,
                          .sky_azimuth = sky_map.azimuth,
                          .zeniths = static_cast<cl_uint>(plan.sky_basis.zenith_rad.size()),
                          .azimuths = static_cast<cl_uint>(plan.sky_basis.azimuth_rad.size()),
                          .thermal_map = sky_map.thermal,
                          .thermal_zenith = sky_map.thermal_zenith,
                          .thermal_zeniths = static_cast<cl_uint>(plan.thermal.basis.zenith_rad.size()),
                          .sun_azimuth = sun_azimuth(),
                          .density = shared::rc_float4{law.cosine, law.sun, law.g, 0},
                          .sun_direction = sun_direction(),
                          .rays = static_cast<cl_uint>(plan.sky.rays),
                          .sampler = sampling.sampler,
                          .samples_u = sampling.samples_u,
                          .samples_v = sampling.samples_v,
                          .sample_support = sampling.support,
                          .seed = plan.sky.hash_seed(seed, sky_draw),
                          .columns = layout.columns,
                          .first_sample = first_sample(chunk),
                          .sample_count = sample_count(chunk),
                          .met_sky = traced.met_sky});
  }

  const cl::Kernel& lamps_of(const TileLayout& layout, int chunk, TraceBuffers& traced) {
    return lamps->arguments(TraceLampsArguments{.tile = tile,
                                                .nodes = buffers.nodes,
                                                .blocks = buffers.blocks,
                                                .instances = buffers.instances,
                                                .lobes = lobes(),
                                                .groups = traced.groups,
                                                .hits = traced.hits,
                                                .surface = traced.surface,
                                                .lift = traced.lift,
                                                .lamps = lamp_tables.lamps,
                                                .lamp_first = lamp_tables.first,
                                                .lamp_distribution = lamp_tables.distribution,
                                                .sampler = sampling.sampler,
                                                .samples_u = sampling.samples_u,
                                                .samples_v = sampling.samples_v,
                                                .sample_support = sampling.support,
                                                .seed = plan.sky.hash_seed(seed, sky_draw),
                                                .columns = layout.columns,
                                                .first_sample = first_sample(chunk),
                                                .met_sky = traced.met_sky});
  }

  const cl::Kernel& paths_of(const TileLayout& layout, int chunk, TraceBuffers& traced) {
    paths->load(context, chunk, first_sample(chunk), sample_count(chunk));
    return paths->kernel.arguments(TraceBounceArguments{
        .tile = tile,
        .nodes = buffers.nodes,
        .blocks = buffers.blocks,
        .instances = buffers.instances,
        .surfaces = buffers.surfaces,
        .lobes = lobes(),
        .scattering = paths->scattering,
        .skeleton_curve = paths->curve,
        .albedo_at = paths->albedo_at,
        .albedo = paths->albedo,
        .source_share = paths->share,
        .ground_around = paths->ground,
        .lamps = lamp_tables.lamps,
        .lamp_first = lamp_tables.first,
        .lamp_distribution = lamp_tables.distribution,
        .lowest = lowest,
        .groups = traced.groups,
        .hits = traced.hits,
        .surface = traced.surface,
        .lift = traced.lift,
        .sun = traced.sun,
        .skyline_cells = buffers.skyline_cells,
        .skyline_frame = skyline_frame(),
        .skyline_instance = buffers.skyline.instance,
        .skyline_columns = buffers.skyline.columns,
        .skyline_rows = buffers.skyline.rows,
        .sky_map = sky_map.solar,
        .sky_zenith = sky_map.zenith,
        .sky_azimuth = sky_map.azimuth,
        .zeniths = static_cast<cl_uint>(plan.sky_basis.zenith_rad.size()),
        .azimuths = static_cast<cl_uint>(plan.sky_basis.azimuth_rad.size()),
        .thermal_map = sky_map.thermal,
        .thermal_zenith = sky_map.thermal_zenith,
        .thermal_zeniths = static_cast<cl_uint>(plan.thermal.basis.zenith_rad.size()),
        .sun_azimuth = sun_azimuth(),
        .sun_direction = sun_direction(),
        .sun_up = cl_uint{plan.sun_up},
        .chunk_weight = paths->weight,
        .sample_total = static_cast<float>(shape.samples),
        .paths = static_cast<cl_uint>(plan.paths()),
        .levels = static_cast<cl_uint>(plan.bounces.levels),
        .sampler = sampling.sampler,
        .samples_u = sampling.samples_u,
        .samples_v = sampling.samples_v,
        .sample_support = sampling.support,
        .seed = plan.sky.hash_seed(seed, sky_draw),
        .columns = layout.columns,
        .first_sample = first_sample(chunk),
        .sample_count = sample_count(chunk),
        .glow = traced.glow,
        .log_paths = shape.path_steps > 0 ? RC_NUMBERED_PATHS(static_cast<cl_uint>(plan.paths())) : 0u,
        .path_log = traced.path_log});
  }

  const cl::Context& context;
  const SceneBuffers& buffers;
  const plan::Plan& plan;
  StageShape shape;
  shared::TileShape tile;
  Sampling sampling{shape};
  std::uint32_t seed, sky_draw = 0;
  float lowest;  ///< z of the scene, m
  std::string primary_options, options, path_options, identity, surfaces_identity;
  std::shared_ptr<const cl::Program> primary_program, program;
  cl::Kernel primary, surface, sun, sky;
  SkyMapBuffers sky_map;
  LampBuffers lamp_tables;
  cl::Buffer<float> open_share;
  std::optional<cl::Buffer<shared::Lobe>> own_lobes;  ///< where all is taken for Lambertian
  std::optional<cl::Kernel> lamps;                    ///< trace_lamps, where there are any
  std::optional<PathStage> paths;
  std::optional<cl::Kernel> opaque;  ///< first_opaque, where the shape has it
  const void* zeroed = nullptr;      ///< buffers whose unused visibility has been cleared
};

TraceStages::TraceStages(const cl::Context& context, const scene::CompiledScene& scene, const SceneBuffers& buffers,
                         const plan::Plan& plan, const StageShape& shape, std::uint64_t seed,
                         std::optional<sensors::SampleWeights> weights)
    : state_(std::make_unique<State>(context, scene, buffers, plan, shape, seed, std::move(weights))) {}
TraceStages::~TraceStages() = default;
void TraceStages::set_draw(const PixelDraw& draw) {
  state_->seed = static_cast<std::uint32_t>(draw.seed), state_->sky_draw = draw.sky_draw;
}

const std::string& TraceStages::identity() const { return state_->identity; }
std::string TraceStages::program_hash() const { return hash_of(state_->surfaces_identity, ""); }
std::string program_hash(const TraceStages& trace, const RowStages& rows) {
  return hash_of(trace.identity(), rows.identity());
}
std::vector<std::string> TraceStages::variants() const {
  std::vector<std::string> out = {state_->primary_options, state_->options};
  if (state_->paths) out.push_back(state_->path_options);
  return out;
}

TileRays tile_rays(const scene::Instrument& instrument, const scene::CompiledScene& scene, const Tile& tile,
                   int pixels_per_group) {
  TileRays rays;
  rays.layout = {static_cast<std::uint32_t>(tile.columns), static_cast<std::uint32_t>(tile.lines),
                 static_cast<std::uint32_t>(pixels_per_group)};
  rays.groups =
      sensors::make_ray_groups(instrument, scene, tile.first_line, tile.lines, tile.first_column / pixels_per_group,
                               static_cast<int>(rays.layout.groups() / rays.layout.lines));
  return rays;
}

TileRays listed_rays(std::vector<shared::RayGroup> groups, int pixels_per_group) {
  TileRays rays;
  rays.layout = {static_cast<std::uint32_t>(pixels_per_group), static_cast<std::uint32_t>(groups.size()),
                 static_cast<std::uint32_t>(pixels_per_group)};
  rays.groups = std::move(groups);
  return rays;
}

void TraceStages::run_first_opaque(const TileLayout& layout, int chunk, const TraceBuffers& traced,
                                   cl::Buffer<std::uint32_t>& opaque) {
  State& s = *state_;
  s.context.launch(s.opaque->arguments(FirstOpaqueArguments{.tile = s.tile,
                                                            .nodes = s.buffers.nodes,
                                                            .blocks = s.buffers.blocks,
                                                            .instances = s.buffers.instances,
                                                            .lobes = s.lobes(),
                                                            .groups = traced.groups,
                                                            .hits = traced.hits,

                                                            .sampler = s.sampling.sampler,
                                                            .samples_u = s.sampling.samples_u,
                                                            .samples_v = s.sampling.samples_v,
                                                            .sample_support = s.sampling.support,
                                                            .seed = s.seed,
                                                            .columns = layout.columns,
                                                            .first_sample = s.first_sample(chunk),
                                                            .opaque = opaque}),
                   layout.groups());
  s.context.finish();
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
    if (!s.sends_to_sky()) traced.met_sky.write(std::vector<float>(traced.met_sky.size(), 0.0f));
    s.zeroed = &traced;
  }
  launch("trace_primary", s.primary_of(layout, chunk, traced));
  launch("make_surface", s.surface.arguments(MakeSurfaceArguments{.tile = s.tile,
                                                                  .blocks = s.buffers.blocks,
                                                                  .instances = s.buffers.instances,
                                                                  .lobes = s.lobes(),
                                                                  .groups = traced.groups,
                                                                  .hits = traced.hits,
                                                                  .surface = traced.surface,
                                                                  .lift = traced.lift,
                                                                  .sampler = s.sampling.sampler,
                                                                  .samples_u = s.sampling.samples_u,
                                                                  .samples_v = s.sampling.samples_v,
                                                                  .sample_support = s.sampling.support,
                                                                  .seed = s.seed,
                                                                  .columns = layout.columns,
                                                                  .first_sample = first_sample,
                                                                  .sample_count = sample_count}));
  if (s.plan.sun_up) launch("trace_sun", s.sun_of(layout, traced));
  if (s.sends_to_sky()) launch("trace_sky", s.sky_of(layout, chunk, traced));
  if (s.lamps) launch("trace_lamps", s.lamps_of(layout, chunk, traced));
  if (s.paths) launch("trace_bounce", s.paths_of(layout, chunk, traced));
}

}  // namespace raycube::render
