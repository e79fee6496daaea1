#include "tests/support/trace_chain.h"

#include <bit>
#include <cmath>

#include "host/base/error.h"
#include "host/plan/sky_rays.h"
#include "host/render/camera_arguments.h"
#include "host/render/tile_shape.h"
#include "kernels/kernel_source.h"
#include "kernels/sampling/sampler.h"
#include "tests/support/probes.h"

namespace raycube::test {

namespace {
render::StageShape stage_shape(const TraceShape& s) {
  render::StageShape shape;
  shape.samples_u = s.nu, shape.samples_v = s.nv, shape.samples = s.nu * s.nv;
  shape.sampler = static_cast<scene::SamplerKind>(s.sampler);
  shape.support_px = s.support;
  shape.moving = s.moving;
  shape.chunk_samples = static_cast<int>(s.chunk_samples());
  shape.pixels_per_group = s.pixels_per_group;
  shape.components = s.components, shape.thermal_components = s.thermal_components;
  return shape;
}
}  // namespace

shared::TileShape TraceShape::arguments() const {
  shared::TileShape tile = stage_shape(*this).arguments();
  if (!bundle) tile.most_visits = 0;
  if (visits > 0) tile.most_visits = static_cast<std::uint32_t>(visits);
  return tile;
}

std::string trace_options(const TraceShape& s, const scene::CompiledScene& scene, const std::string& kernel) {
  const render::ProgramOptions programs = render::program_options(stage_shape(s), scene.stack_bound(), true);
  return kernel == "trace_primary" ? programs.primary : programs.trace;
}

HostRay host_ray(const shared::RayGroup& g, const TraceShape& shape, std::uint32_t number, std::uint32_t p,
                 std::uint32_t s) {
  float u = 0, v = 0;
  rc_sample_uv(shape.sampler, shape.nu, shape.nv, shape.support, shape.seed, number, static_cast<int>(s), &u, &v);
  const float a = (static_cast<float>(p) - 0.5f * static_cast<float>(shape.pixels_per_group - 1)) + u, b = v;
  const auto direction = [&](float d0, float du, float dv) { return std::fma(b, dv, std::fma(a, du, d0)); };
  const float a_ahead = a * g.d0.w, b_ahead = b * g.d0.w;
  const auto origin = [&](float o, float du, float dv, float ov) {
    const float offset = std::fma(b_ahead, dv, a_ahead * du);
    return double{o} + (shape.moving ? std::fma(b, ov, offset) : offset);
  };
  return {{origin(g.origin.x, g.du.x, g.dv.x, g.ov.x), origin(g.origin.y, g.du.y, g.dv.y, g.ov.y),
           origin(g.origin.z, g.du.z, g.dv.z, g.ov.z)},
          {direction(g.d0.x, g.du.x, g.dv.x), direction(g.d0.y, g.du.y, g.dv.y), direction(g.d0.z, g.du.z, g.dv.z)}};
}

std::vector<shared::RayGroup> nadir_groups(const TraceShape& shape, double x, double y, double z, double gsd,
                                           double distance, double tilt) {
  std::vector<shared::RayGroup> groups;
  for (std::uint32_t line = 0; line < shape.lines; ++line)
    for (std::uint32_t g = 0; g < shape.groups_per_line(); ++g) {
      const double u = shape.first_column + (g + 0.5) * shape.pixels_per_group - 0.5 * shape.pixels_per_line;
      const double v = shape.first_line + line + 0.5 - 0.5 * shape.pixels_per_line;
      shared::RayGroup group{};
      group.origin = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z), 0};
      group.d0 = {static_cast<float>(u * gsd / distance + tilt), static_cast<float>(-v * gsd / distance), -1, 0};
      group.du = {static_cast<float>(gsd / distance), 0, 0, 0};
      group.dv = {0, static_cast<float>(-gsd / distance), 0, 0};
      groups.push_back(group);
    }
  return groups;
}

std::vector<shared::RayGroup> numbered(std::span<const shared::RayGroup> groups, const TraceShape& shape) {
  std::vector<shared::RayGroup> out(groups.begin(), groups.end());
  for (std::uint32_t i = 0; i < out.size(); ++i) {
    const std::uint32_t line = shape.first_line + i / shape.groups_per_line();
    const std::uint32_t column =
        shape.first_column + i % shape.groups_per_line() * static_cast<std::uint32_t>(shape.pixels_per_group);
    out[i].origin.w = std::bit_cast<float>(line * shape.pixels_per_line + column);
  }
  return out;
}

/// The sky of a plan as trace_sky reads it (kernels/light/sky_map.h).
struct TraceChain::SkyMaps {
  SkyMaps(const cl::Context& context, const plan::Plan& plan)
      : open_share(context, plan.sky.open_share, cl::Access::read_only, "open share of surfaces"),
        zenith(context, plan::searched_nodes(plan.sky_basis.zenith_rad), cl::Access::read_only,
               "zeniths of the sky map"),
        azimuth(context, plan::searched_nodes(plan.sky_basis.azimuth_rad), cl::Access::read_only,
                "azimuths of the sky map"),
        thermal_zenith(context, plan::searched_nodes(plan.thermal.basis.zenith_rad), cl::Access::read_only,
                       "thermal zeniths"),
        solar(context, quads(plan.sky_basis, 1), cl::Access::read_only, "sky map"),
        thermal(context, quads(plan.thermal.basis, plan.thermal.basis.azimuth_rad.size()), cl::Access::read_only,
                "thermal sky map") {}
  /// Every `step`-th node.
  static std::vector<shared::rc_float4> quads(const plan::SkyBasis& basis, std::size_t step) {
    std::vector<shared::rc_float4> out;
    for (std::size_t i = 0; i < basis.value.size(); i += step) {
      const auto& v = basis.value[i];
      out.push_back(
          {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]), static_cast<float>(v[3])});
    }
    return out;
  }
  cl::Buffer<float> open_share, zenith, azimuth, thermal_zenith;
  cl::Buffer<shared::rc_float4> solar, thermal;
};

TraceChain::~TraceChain() = default;

TraceChain::TraceChain(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape)
    : context_(context),
      shape_(shape),
      scene_(context, scene, shape.page_bytes),
      primary_options_(trace_options(shape, scene, "trace_primary") + scene_.options),
      options_(trace_options(shape, scene, "trace_light") + scene_.options),
      groups_(context, shape.groups(), cl::Access::read_only, "ray groups"),
      hits_(context, shape.pixels() * shape.elements().hits, cl::Access::read_write, "hits"),
      surface_(context, shape.pixels() * shape.elements().surface, cl::Access::read_write, "surface points"),
      lift_(context, shape.pixels() * shape.elements().lift, cl::Access::read_write, "lifts of surface points"),
      met_sky_(context, shape.pixels() * shape.elements().met_sky, cl::Access::read_write, "met sky"),
      sun_mask_(context, shape.pixels() * shape.elements().sun, cl::Access::read_write, "sun masks") {
  groups_.write(numbered(std::vector<shared::RayGroup>(shape.groups()), shape));
}

cl::Kernel& TraceChain::kernel(const std::string& name) {
  for (auto& [known, kernel] : kernels_)
    if (known == name) return kernel;
  const bool first = name == "trace_primary";
  const auto program =
      context_.program(first ? name : "trace_light", kernels::kernel_source(first ? name : "trace_light"),
                       first ? primary_options_ : options_);
  return kernels_.emplace_back(name, cl::Kernel(*program, name)).second;
}

std::vector<std::uint32_t> TraceChain::primary(std::span<const shared::RayGroup> groups, std::uint32_t first_sample) {
  groups_.write(numbered(groups, shape_));
  first_sample_ = first_sample;
  count_ = std::min(shape_.chunk_samples(), shape_.samples() - first_sample);
  kernel("trace_primary")
      .arguments(render::TracePrimaryArguments{.tile = shape_.arguments(),
                                               .nodes = scene_.nodes,
                                               .blocks = scene_.blocks,
                                               .instances = scene_.instances,
                                               .groups = groups_,
                                               .hits = hits_,
                                               .sampler = static_cast<std::uint32_t>(shape_.sampler),
                                               .samples_u = static_cast<std::uint32_t>(shape_.nu),
                                               .samples_v = static_cast<std::uint32_t>(shape_.nv),
                                               .sample_support = shape_.support,
                                               .seed = shape_.seed,
                                               .columns = shape_.columns,
                                               .first_sample = first_sample_,
                                               .sample_count = count_});
  again("trace_primary");
  return hits_.read_all();
}

std::vector<float> TraceChain::surface() {
  kernel("make_surface")
      .arguments(render::MakeSurfaceArguments{.tile = shape_.arguments(),
                                              .blocks = scene_.blocks,
                                              .instances = scene_.instances,
                                              .lobes = scene_.lobes,
                                              .groups = groups_,
                                              .hits = hits_,
                                              .surface = surface_,
                                              .lift = lift_,
                                              .sampler = static_cast<std::uint32_t>(shape_.sampler),
                                              .samples_u = static_cast<std::uint32_t>(shape_.nu),
                                              .samples_v = static_cast<std::uint32_t>(shape_.nv),
                                              .sample_support = shape_.support,
                                              .seed = shape_.seed,
                                              .columns = shape_.columns,
                                              .first_sample = first_sample_,
                                              .sample_count = count_});
  again("make_surface");
  own_points_ = false;
  return surface_.read_all();
}

namespace {
shared::rc_float4 skyline_frame(const scene::Skyline& skyline) {
  return {skyline.x_m, skyline.y_m, skyline.per_cell, 0};
}
}  // namespace

/// Points of a test's own are on no ground.
std::uint32_t TraceChain::skyline_instance() const { return own_points_ ? RC_NONE : scene_.skyline.instance; }

void TraceChain::set_surface(std::span<const float> points) {
  surface_.write(points);
  own_points_ = true;
}

std::vector<std::uint16_t> TraceChain::sun_alone(const shared::rc_float4& direction) {
  const auto program = probes(context_, scene_.options);
  cl::Kernel alone(*program, "sun_alone");
  const cl::Buffer<std::uint32_t> no_ranges(context_, 1, cl::Access::read_only, "no blocks");
  alone.arguments(scene_.nodes, scene_.blocks, scene_.instances, no_ranges, cl_uint{0}, cl_uint{0}, surface_, sun_mask_,
                  shape_.arguments(), direction);
  context_.launch(alone, shape_.pixels());
  context_.finish();
  return sun_mask_.read_all();
}

std::vector<std::uint16_t> TraceChain::sun(const shared::rc_float4& direction) {
  if (!shape_.bundle) return sun_alone(direction);
  kernel("trace_sun")
      .arguments(render::TraceSunArguments{.tile = shape_.arguments(),
                                           .nodes = scene_.nodes,
                                           .blocks = scene_.blocks,
                                           .instances = scene_.instances,
                                           .groups = groups_,
                                           .hits = hits_,
                                           .surface = surface_,
                                           .skyline_cells = scene_.skyline_cells,
                                           .skyline_frame = skyline_frame(scene_.skyline),
                                           .skyline_instance = skyline_instance(),
                                           .skyline_columns = scene_.skyline.columns,
                                           .skyline_rows = scene_.skyline.rows,
                                           .direction = direction,
                                           .sun = sun_mask_,
                                           .columns = shape_.columns});
  again("trace_sun");
  return sun_mask_.read_all();
}

std::vector<float> TraceChain::sky(const plan::Plan& plan) {
  if (plan.components() != shape_.components || plan.thermal.components() != shape_.thermal_components)
    throw base::Error(base::Fault::bug, "the plan's sky has other components than the shape's kernels");
  maps_ = std::make_unique<SkyMaps>(context_, plan);
  const SkyDensity law = plan::sky_density(plan);
  const auto sine = static_cast<float>(std::sin(plan.sky.sun_azimuth_rad)),
             cosine = static_cast<float>(std::cos(plan.sky.sun_azimuth_rad));
  kernel("trace_sky")
      .arguments(
          render::TraceSkyArguments{.tile = shape_.arguments(),
                                    .nodes = scene_.nodes,
                                    .blocks = scene_.blocks,
                                    .instances = scene_.instances,
                                    .lobes = scene_.lobes,
                                    .groups = groups_,
                                    .hits = hits_,
                                    .surface = surface_,
                                    .skyline_cells = scene_.skyline_cells,
                                    .skyline_frame = skyline_frame(scene_.skyline),
                                    .skyline_instance = skyline_instance(),
                                    .skyline_columns = scene_.skyline.columns,
                                    .skyline_rows = scene_.skyline.rows,
                                    .open_share = maps_->open_share,
                                    .sky_map = maps_->solar,
                                    .sky_zenith = maps_->zenith,
                                    .sky_azimuth = maps_->azimuth,
                                    .zeniths = static_cast<std::uint32_t>(plan.sky_basis.zenith_rad.size()),
                                    .azimuths = static_cast<std::uint32_t>(plan.sky_basis.azimuth_rad.size()),
                                    .thermal_map = maps_->thermal,
                                    .thermal_zenith = maps_->thermal_zenith,
                                    .thermal_zeniths = static_cast<std::uint32_t>(plan.thermal.basis.zenith_rad.size()),
                                    .sun_azimuth = shared::rc_float4{sine, cosine, 0, 0},
                                    .density = shared::rc_float4{law.cosine, law.sun, law.g, 0},
                                    .sun_direction = shared::rc_float4{law.sun_x, law.sun_y, law.sun_z, 0},
                                    .rays = static_cast<std::uint32_t>(plan.sky.rays),
                                    .sampler = static_cast<std::uint32_t>(shape_.sampler),
                                    .samples_u = static_cast<std::uint32_t>(shape_.nu),
                                    .samples_v = static_cast<std::uint32_t>(shape_.nv),
                                    .sample_support = shape_.support,
                                    .seed = plan.sky.hash_seed(shape_.seed),
                                    .columns = shape_.columns,
                                    .first_sample = first_sample_,
                                    .sample_count = count_,
                                    .met_sky = met_sky_});
  again("trace_sky");
  return met_sky_.read_all();
}

void TraceChain::again(const std::string& stage) {
  context_.launch(kernel(stage), shape_.groups());
  context_.finish();
}

}  // namespace raycube::test
