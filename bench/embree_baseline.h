// The opponent: Embree 3 as its authors would use it. Medium quality, default (not robust) flags, -O3 -march=native,
// native 16-wide packets; ray generation and 8-byte result stores inside the timed call.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "kernels/shared/structs.h"
#include "scene_compiler/compiled_scene.h"

struct RTCSceneTy;

namespace raycube::bench {

/// Result of one ray, 8 bytes. Primitive as Embree numbers it until EmbreeBaseline::to_scene() translates.
struct RayResult {
  std::uint32_t instance = RC_NONE, primitive = RC_NONE;
};

/// Pixels to trace: groups as render makes them, all `width` pixels of each, samples (u, v) shared by all pixels.
struct PrimaryRays {
  const shared::RayGroup* groups = nullptr;
  std::size_t group_count = 0;
  int width = RC_GROUP_WIDTH;
  std::vector<float> u, v;  ///< samples of a pixel
  std::size_t samples() const { return u.size(); }
  std::size_t pixels() const { return group_count * static_cast<std::size_t>(width); }
  std::size_t rays() const { return pixels() * samples(); }
};

/// Shadow rays: one origin each (x, y, z apart), and one direction for all, or one each. An origin with x = NaN is a
/// ray that missed: skipped.
struct ShadowRays {
  std::vector<float> x, y, z;
  float direction[3] = {0, 0, 1};
  std::vector<float> dx, dy, dz;  ///< each ray's own direction; empty: all go in `direction`
};

enum class EmbreeMode { packet16_coherent, packet16, single };
inline constexpr EmbreeMode kEmbreeModes[] = {EmbreeMode::packet16_coherent, EmbreeMode::packet16, EmbreeMode::single};
const char* mode_name(EmbreeMode mode);

/// placed: two levels as the scene has them, or one where it is one unmoved tree. merged: every placed triangle in one
/// tree, its corners rounded to fp32 in the scene's frame; 48 bytes a placed triangle and Embree's tree.
enum class EmbreeForm { placed, merged };
inline constexpr EmbreeForm kEmbreeForms[] = {EmbreeForm::placed, EmbreeForm::merged};
const char* form_name(EmbreeForm form);
std::size_t placed_triangles(const scene::CompiledScene& scene);

class EmbreeBaseline {
 public:
  explicit EmbreeBaseline(const scene::CompiledScene& scene, EmbreeForm form = EmbreeForm::placed);
  ~EmbreeBaseline();
  EmbreeBaseline(const EmbreeBaseline&) = delete;
  EmbreeBaseline& operator=(const EmbreeBaseline&) = delete;

  /// result[pixel * samples + sample], pixel = group * width + i.
  void primary(const PrimaryRays& rays, EmbreeMode mode, int threads, RayResult* result) const;
  /// result[i].instance: 0 = lit, RC_NONE = in shadow; rays skipped get 0.
  void shadow(const ShadowRays& rays, EmbreeMode mode, int threads, RayResult* result) const;

  /// The closest hit of rays with a direction each, as primary() tells it; rays skipped are misses.
  void closest(const ShadowRays& rays, EmbreeMode mode, int threads, RayResult* result) const;

  /// Embree's primitive numbers (which leave out the blocks' unused lanes) to the scene's.
  void to_scene(RayResult* results, std::size_t count) const;
  /// Bytes Embree holds for its trees and triangles.
  std::size_t memory_bytes() const;

  /// For others who trace in the same scene: its handle, whether it is one flat tree, and the scene's number of a
  /// tree's triangle (placed form).
  RTCSceneTy* handle() const;
  bool flat() const;
  std::uint32_t scene_primitive(std::uint32_t tree, std::uint32_t primitive) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raycube::bench
