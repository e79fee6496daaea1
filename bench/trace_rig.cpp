#include "bench/trace_rig.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

#include "bench/device.h"
#include "host/lidar/vec3.h"
#include "host/render/trace_stages.h"
#include "host/sensors/ray_groups.h"
#include "kernels/sampling/sampler.h"

namespace raycube::bench {
namespace {

plan::Plan sun_only_plan(const std::array<float, 3>& sun) {
  plan::Plan plan;
  plan.sun_direction = sun;
  plan.sun_up = true;
  plan.sky_components = 0;
  return plan;
}

}  // namespace

struct TraceRig::State {
  State(const scene::CompiledScene& scene, const scene::Instrument& instrument, std::size_t max_groups,
        const std::array<float, 3>& sun, int threads)
      : context(pick_device(threads)),
        buffers(context, scene),
        plan(sun_only_plan(sun)),
        shape(render::make_stage_shape(instrument, plan, sensors::pixels_per_group(instrument))),
        stages(context, scene, buffers, plan, shape, 1),
        width(static_cast<std::size_t>(shape.pixels_per_group)),
        traced(context, shape, max_groups * width, max_groups),
        line_pixels(static_cast<std::size_t>(instrument.pixels)) {}

  std::size_t pixels() const { return group_count * width; }

  cl::Context context;
  render::SceneBuffers buffers;
  plan::Plan plan;
  render::StageShape shape;
  render::TraceStages stages;
  std::size_t width;
  render::TraceBuffers traced;
  std::size_t line_pixels, group_count = 0;
  std::vector<shared::RayGroup> groups;
};

TraceRig::TraceRig(const scene::CompiledScene& scene, const scene::Instrument& instrument, std::size_t max_groups,
                   const std::array<float, 3>& sun, int threads)
    : state_(std::make_unique<State>(scene, instrument, max_groups, sun, threads)) {}
TraceRig::~TraceRig() = default;

void TraceRig::set_groups(const std::vector<shared::RayGroup>& groups) {
  state_->group_count = groups.size();
  state_->groups = groups;
}

TraceRig::Times TraceRig::run(std::uint32_t first_line) {
  State& s = *state_;
  // One long line: the groups need not be neighbours.
  const render::TileLayout layout{static_cast<std::uint32_t>(s.pixels()), 1, static_cast<std::uint32_t>(s.width)};
  for (std::size_t g = 0; g < s.groups.size(); ++g)
    s.groups[g].origin.w = std::bit_cast<float>(static_cast<std::uint32_t>(first_line * s.line_pixels + g * s.width));
  s.traced.groups.write(s.groups);
  std::map<std::string, double> stage_s;
  s.stages.run(layout, 0, s.traced, stage_s);
  Times times;
  for (const auto& [stage, seconds] : stage_s) {
    if (stage.find("primary") != std::string::npos) times.primary_s += seconds;
    if (stage.find("sun") != std::string::npos) times.sun_s += seconds;
  }
  return times;
}

std::vector<RayResult> TraceRig::hits() const {
  const State& s = *state_;
  const auto samples = static_cast<std::size_t>(s.shape.samples);
  const shared::TileElements& of_pixel = s.traced.elements;
  std::vector<std::uint32_t> raw(s.pixels() * of_pixel.hits);
  s.traced.hits.read(raw);
  std::vector<RayResult> results(s.pixels() * samples);
  for (std::size_t p = 0; p < s.pixels(); ++p)
    for (std::size_t k = 0; k < samples; ++k)
      results[p * samples + k] = {raw[p * of_pixel.hits + of_pixel.hits_at(RC_HIT_INSTANCE, k)],
                                  raw[p * of_pixel.hits + of_pixel.hits_at(RC_HIT_PRIMITIVE, k)]};
  return results;
}

std::vector<RayResult> TraceRig::sun() const {
  const State& s = *state_;
  const auto samples = static_cast<std::size_t>(s.shape.samples), words = s.traced.elements.sun;
  std::vector<std::uint16_t> mask(s.pixels() * words);
  s.traced.sun.read(mask);
  const ShadowRays rays = shadow_rays();
  std::vector<RayResult> results(s.pixels() * samples);
  for (std::size_t p = 0; p < s.pixels(); ++p)
    for (std::size_t k = 0; k < samples; ++k) {
      const bool traced = !std::isnan(rays.x[p * samples + k]),
                 seen = mask[p * words + k / RC_WORD] >> (k % RC_WORD) & 1u;
      results[p * samples + k] = {traced && !seen ? RC_NONE : 0u, 0};
    }
  return results;
}

ShadowRays TraceRig::shadow_rays() const {
  const State& s = *state_;
  const auto samples = static_cast<std::size_t>(s.shape.samples);
  constexpr std::size_t apart = RC_WORD;  // of a word's planes
  std::vector<float> surface(s.pixels() * s.traced.elements.surface);
  s.traced.surface.read(surface);
  ShadowRays rays;
  for (int i = 0; i < 3; ++i) rays.direction[i] = s.plan.sun_direction[static_cast<std::size_t>(i)];
  const std::size_t count = s.pixels() * samples;
  rays.x.resize(count);
  rays.y.resize(count);
  rays.z.resize(count);
  const auto& d = rays.direction;
  for (std::size_t p = 0; p < s.pixels(); ++p)
    for (std::size_t k = 0; k < samples; ++k) {
      const float* at = surface.data() + p * s.traced.elements.surface + s.traced.elements.surface_at(0, k);
      const float cosine = std::fma(at[RC_NORMAL_X * apart], d[0],
                                    std::fma(at[RC_NORMAL_Y * apart], d[1], at[RC_NORMAL_Z * apart] * d[2]));
      const std::size_t i = p * samples + k;
      rays.x[i] = cosine > 0.0f ? at[RC_POINT_X * apart] : std::numeric_limits<float>::quiet_NaN();
      rays.y[i] = at[RC_POINT_Y * apart];
      rays.z[i] = at[RC_POINT_Z * apart];
    }
  return rays;
}

ShadowRays TraceRig::sky_rays() const {
  const State& s = *state_;
  const auto samples = static_cast<std::size_t>(s.shape.samples);
  constexpr std::size_t apart = RC_WORD;  // of a word's planes
  std::vector<float> surface(s.pixels() * s.traced.elements.surface);
  s.traced.surface.read(surface);
  ShadowRays rays;
  const std::size_t count = s.pixels() * samples;
  for (std::vector<float>* of : {&rays.x, &rays.y, &rays.z, &rays.dx, &rays.dy, &rays.dz}) of->resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t pixel = i / samples, k = i % samples;
    const float* at = surface.data() + pixel * s.traced.elements.surface + s.traced.elements.surface_at(0, k);
    const lidar::Vec3 normal{at[RC_NORMAL_X * apart], at[RC_NORMAL_Y * apart], at[RC_NORMAL_Z * apart]};
    const auto draw = [&](std::uint32_t dimension) {
      return static_cast<double>(
          rc_unit_float(rc_hash(7u, static_cast<std::uint32_t>(pixel), static_cast<std::uint32_t>(k), dimension)));
    };
    const double square = draw(0), turn = 2 * std::numbers::pi * draw(1);
    const lidar::Vec3 other = std::abs(normal[0]) < 0.7 ? lidar::Vec3{1, 0, 0} : lidar::Vec3{0, 1, 0};
    lidar::Vec3 across = lidar::cross(normal, other);
    for (double& part : across) part /= std::max(lidar::length(lidar::cross(normal, other)), 1e-30);
    const lidar::Vec3 along = lidar::cross(normal, across);
    const double a = std::sqrt(square) * std::cos(turn), b = std::sqrt(square) * std::sin(turn),
                 up = std::sqrt(1 - square);
    rays.x[i] = lidar::length(normal) > 0.5 ? at[RC_POINT_X * apart] : std::numeric_limits<float>::quiet_NaN();
    rays.y[i] = at[RC_POINT_Y * apart];
    rays.z[i] = at[RC_POINT_Z * apart];
    std::vector<float>* to[] = {&rays.dx, &rays.dy, &rays.dz};
    for (std::size_t j = 0; j < 3; ++j) (*to[j])[i] = static_cast<float>(a * across[j] + b * along[j] + up * normal[j]);
  }
  return rays;
}

std::string TraceRig::program_hash() const { return state_->stages.program_hash(); }
std::string TraceRig::device_name() const { return state_->context.device().name(); }

}  // namespace raycube::bench
