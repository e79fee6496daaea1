#include "tests/support/trace_chain.h"

#include <bit>
#include <cmath>

#include "host/render/camera_arguments.h"
#include "host/render/tile_shape.h"
#include "kernels/kernel_source.h"
#include "kernels/sampling/sampler.h"

namespace raycube::test {

std::string trace_options(const TraceShape& s, const scene::CompiledScene& scene) {
  render::StageShape shape;
  shape.samples_u = s.nu, shape.samples_v = s.nv, shape.samples = s.nu * s.nv;
  shape.sampler = static_cast<scene::SamplerKind>(s.sampler);
  shape.support_px = s.support;
  shape.moving = s.moving;
  shape.chunk_samples = static_cast<int>(s.chunk_samples());
  shape.pixels_per_group = s.pixels_per_group;
  return render::program_options(shape, scene.stack_bound()).trace + " -Werror -DRC_BUNDLE=" + std::to_string(s.bundle);
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

TraceChain::TraceChain(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape)
    : context_(context),
      shape_(shape),
      scene_(context, scene, shape.page_bytes),
      options_(trace_options(shape, scene) + scene_.options),
      groups_(context, shape.groups(), cl::Access::read_only, "ray groups"),
      hits_(context, shape.pixels() * shape.elements().hits, cl::Access::read_write, "hits"),
      surface_(context, shape.pixels() * shape.elements().surface, cl::Access::read_write, "surface points"),
      lift_(context, shape.pixels() * shape.elements().lift, cl::Access::read_write, "lifts of surface points"),
      blocked_(context, shape.pixels() * shape.elements().blocked, cl::Access::read_write, "blocked sky"),
      sun_mask_(context, shape.pixels() * shape.elements().sun, cl::Access::read_write, "sun masks") {
  groups_.write(numbered(std::vector<shared::RayGroup>(shape.groups()), shape));
}

cl::Kernel& TraceChain::kernel(const std::string& name) {
  for (auto& [known, kernel] : kernels_)
    if (known == name) return kernel;
  const cl::Program program(context_, name, kernels::kernel_source(name), options_);
  return kernels_.emplace_back(name, cl::Kernel(program, name)).second;
}

std::vector<std::uint32_t> TraceChain::primary(std::span<const shared::RayGroup> groups, std::uint32_t first_sample) {
  groups_.write(numbered(groups, shape_));
  first_sample_ = first_sample;
  count_ = std::min(shape_.chunk_samples(), shape_.samples() - first_sample);
  kernel("trace_primary")
      .arguments(render::TracePrimaryArguments{.nodes = scene_.nodes,
                                               .blocks = scene_.blocks,
                                               .instances = scene_.instances,
                                               .groups = groups_,
                                               .hits = hits_,
                                               .seed = shape_.seed,
                                               .columns = shape_.columns,
                                               .first_sample = first_sample_,
                                               .sample_count = count_});
  again("trace_primary");
  return hits_.read_all();
}

std::vector<float> TraceChain::surface() {
  kernel("make_surface")
      .arguments(render::MakeSurfaceArguments{.blocks = scene_.blocks,
                                              .instances = scene_.instances,
                                              .lobes = scene_.lobes,
                                              .groups = groups_,
                                              .hits = hits_,
                                              .surface = surface_,
                                              .lift = lift_,
                                              .seed = shape_.seed,
                                              .columns = shape_.columns,
                                              .first_sample = first_sample_,
                                              .sample_count = count_});
  again("make_surface");
  return surface_.read_all();
}

std::vector<std::uint16_t> TraceChain::sun(const shared::rc_float4& direction) {
  sun_direction_ = std::make_unique<cl::Buffer<shared::rc_float4>>(context_, std::vector{direction},
                                                                   cl::Access::read_only, "sun direction");
  light(*sun_direction_, *sun_direction_, false, 1, 1, 1);
  return sun_mask_.read_all();
}

std::vector<float> TraceChain::sky(std::span<const shared::rc_float4> directions,
                                   std::span<const shared::rc_float4> weights, std::uint32_t sets,
                                   std::uint32_t share) {
  directions_ =
      std::make_unique<cl::Buffer<shared::rc_float4>>(context_, directions, cl::Access::read_only, "sky directions");
  weights_ = std::make_unique<cl::Buffer<shared::rc_float4>>(context_, weights, cl::Access::read_only, "sky weights");
  light(*directions_, *weights_, true, sets, static_cast<std::uint32_t>(directions.size()) / sets, share);
  return blocked_.read_all();
}

void TraceChain::light(const cl::Buffer<shared::rc_float4>& directions, const cl::Buffer<shared::rc_float4>& weights,
                       bool sky, std::uint32_t sets, std::uint32_t count, std::uint32_t share) {
  kernel("trace_light")
      .arguments(render::TraceLightArguments{.nodes = scene_.nodes,
                                             .blocks = scene_.blocks,
                                             .instances = scene_.instances,
                                             .groups = groups_,
                                             .surface = surface_,
                                             .directions = directions,
                                             .weights = weights,
                                             .sun = sun_mask_,
                                             .blocked = blocked_,
                                             .sky = std::uint32_t{sky},
                                             .sets = sets,
                                             .count = count,
                                             .share = share,
                                             .seed = shape_.seed,
                                             .columns = shape_.columns,
                                             .first_sample = first_sample_});
  again("trace_light");
}

void TraceChain::again(const std::string& stage) {
  context_.launch(kernel(stage), shape_.groups());
  context_.finish();
}

}  // namespace raycube::test
