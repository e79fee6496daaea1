// Launches the tracing kernels on a compiled scene, for tests: one call per stage, results on the host.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/cl/kernel.h"
#include "host/plan/plan.h"
#include "host/render/scene_buffers.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::test {

/// What a launch works on; see kernels/geometry/trace_args.h.
struct TraceShape {
  int nu = 4, nv = 4;
  int chunk = 0;    ///< 0: nu * nv
  int sampler = 0;  ///< RC_SAMPLER_*
  float support = 1;
  int pixels_per_group = RC_GROUP_WIDTH;
  bool moving = false;
  bool bundle = true;  ///< false: every ray by itself, first ones and those to the sun
  int visits = 0;  ///< after which a bundle of primary rays gives way to single rays; 0: as the kernels have it
  int components = 0, thermal_components = 0;  ///< of the sky, all; of them the thermal ones, surroundings last
  std::uint32_t seed = 1;
  std::uint32_t first_line = 0, first_column = 0, columns = 0, pixels_per_line = 0, lines = 0;
  std::uint32_t page_bytes = 0;  ///< largest page of the scene's arrays; 0: as the device allows

  std::uint32_t samples() const { return static_cast<std::uint32_t>(nu * nv); }
  std::uint32_t chunk_samples() const { return chunk ? static_cast<std::uint32_t>(chunk) : samples(); }
  /// Elements of a pixel in the stages' buffers.
  shared::TileElements elements() const {
    return {chunk_samples(), static_cast<std::size_t>(RC_SKY_PLANES_OF(components))};
  }
  /// A plane of a pixel's slot in hits, surface and met sky.
  std::size_t hits_at(std::size_t pixel, std::size_t plane, std::size_t slot = 0) const {
    return pixel * elements().hits + shared::TileElements::hits_at(plane, slot);
  }
  std::size_t surface_at(std::size_t pixel, std::size_t plane, std::size_t slot = 0) const {
    return pixel * elements().surface + elements().surface_at(plane, slot);
  }
  std::size_t met_sky_at(std::size_t pixel, std::size_t plane, std::size_t slot = 0) const {
    return pixel * elements().met_sky + elements().met_sky_at(plane, slot);
  }
  /// The same as kernels are told.
  shared::TileShape arguments() const;
  /// Whether the mask has sample s of a pixel see the sun.
  bool sees_sun(const std::vector<std::uint16_t>& mask, std::size_t pixel, std::size_t s) const {
    return mask[pixel * elements().sun + s / RC_WORD] >> (s % RC_WORD) & 1;
  }
  std::uint32_t groups_per_line() const {
    return shared::rc_groups_per_line(columns, static_cast<std::uint32_t>(pixels_per_group));
  }
  std::uint32_t groups() const { return groups_per_line() * lines; }
  std::uint32_t pixels() const { return columns * lines; }
};

/// (a, b) and the very ray of sample s of pixel p of a group, as trace_args.h defines them. The origin is the exact sum
/// of two floats.
struct HostRay {
  double origin[3];
  float direction[3];
};
HostRay host_ray(const shared::RayGroup& group, const TraceShape& shape, std::uint32_t pixel_number, std::uint32_t p,
                 std::uint32_t s);

/// A nadir-like framing camera: groups of a tile of `shape`, looking along -z from (x, y, z), pixel pitch `gsd` at
/// distance `distance` (m), tilted by `tilt` (m sideways per m of depth) to keep rays off the axes.
std::vector<shared::RayGroup> nadir_groups(const TraceShape& shape, double x, double y, double z, double gsd,
                                           double distance, double tilt);

/// The groups of a tile of `shape` with their pixels' numbers.
std::vector<shared::RayGroup> numbered(std::span<const shared::RayGroup> groups, const TraceShape& shape);

/// The compiler options of a shape.
std::string trace_options(const TraceShape& shape, const scene::CompiledScene& scene, const std::string& kernel);

class TraceChain {
 public:
  TraceChain(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape);
  ~TraceChain();
  /// hits of all pixels (kernels/shared/tile_layout.h)
  std::vector<std::uint32_t> primary(std::span<const shared::RayGroup> groups, std::uint32_t first_sample = 0);
  /// surface of the last primary()
  std::vector<float> surface();
  /// Puts points of the test's own where surface() would leave its own; none of the two before is
  /// needed.
  void set_surface(std::span<const float> points);
  /// sun bits of the last surface() or set_surface()
  std::vector<std::uint16_t> sun(const shared::rc_float4& direction);
  /// met sky of the last surface() or set_surface(), under the plan's sky; of a plan its maps, components, rays and sun
  /// are read
  std::vector<float> sky(const plan::Plan& plan);
  /// Enqueue one stage again with the arguments of the last call and wait: for timing.
  void again(const std::string& stage);

 private:
  cl::Kernel& kernel(const std::string& name);
  std::vector<std::uint16_t> sun_alone(const shared::rc_float4& direction);
  std::uint32_t skyline_instance() const;
  const cl::Context& context_;
  TraceShape shape_;
  std::uint32_t first_sample_ = 0, count_ = 0;
  render::SceneBuffers scene_;
  bool own_points_ = false;  ///< what lies in surface_ is of no triangle
  std::string primary_options_, options_;
  cl::Buffer<shared::RayGroup> groups_;
  cl::Buffer<std::uint32_t> hits_;
  cl::Buffer<float> surface_, lift_, met_sky_;
  cl::Buffer<std::uint16_t> sun_mask_;
  struct SkyMaps;
  std::unique_ptr<SkyMaps> maps_;
  std::vector<std::pair<std::string, cl::Kernel>> kernels_;
};

}  // namespace raycube::test
