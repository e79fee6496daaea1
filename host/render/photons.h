// Light followed from a source on, surface by surface: kernels/entry/trace_photons.cl on a device.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "host/render/types.h"
#include "kernels/shared/structs.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::render {

class PhotonTracer {
 public:
  static constexpr std::size_t kAtOnce = std::size_t{1} << 14;  ///< photons of a launch at most

  /// Uploads the scene. scattering: of every surface (plan::surface_scattering).
  PhotonTracer(const scene::CompiledScene& scene, const RenderOptions& options,
               const std::vector<shared::rc_float4>& scattering);
  ~PhotonTracer();

  /// Takes photons, kAtOnce at most, to what their rays meet and chooses how light goes on from there. level: surfaces
  /// that they have met then, from 1 on. What a photon does depends on the seed, its number and the level.
  void step(std::vector<shared::Photon>& photons, std::uint32_t level, std::uint32_t seed);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::render
