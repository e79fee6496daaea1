// What becomes of photons (render::PhotonTracer), wavelength by wavelength in double: a photon carries a share of the
// light at every wavelength of a plan's grid, and where it goes knows none of them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/shared/product_key.h"
#include "kernels/shared/structs.h"
#include "host/plan/quadrature.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::run {

using Spectrum = std::vector<double>;  ///< [wavelength]

/// A lobe that a material scatters by, of shapes that change with wavelength.
struct LobeLight {
  scene::Shape shape;
  Spectrum curve;
};

/// What a material does with light that falls onto it.
struct MaterialLight {
  const Spectrum& leaving(std::uint32_t side) const {
    return side == RC_NEAR_SIDE ? reflected : side == RC_FAR_SIDE ? through : mirrored;
  }
  Spectrum reflected, through, mirrored;  ///< by its front, its far side, its gloss: curves of each
  std::uint32_t named = 0;                ///< which of the materials that the user named
  bool ground = false;
  /// Of a material whose shapes change with wavelength all lobes of its front and of its gloss, instead of the first.
  std::vector<LobeLight> front_lobes, gloss_lobes;
};

/// The scene as photons know it.
struct PhotonScene {
  const scene::CompiledScene& compiled;
  std::size_t wavelengths = 0;
  std::vector<MaterialLight> material;  ///< [material]
  std::size_t named = 0;
  std::vector<bool> shaped;                ///< [surface]: does not reflect by Lambert's law, or is glossy too
  std::vector<plan::BandQuadrature> band;  ///< by response and sunlight
  std::vector<double> levels;              ///< heights at which light is counted, m; on a surface, that just above it
  bool repeats = false;                    ///< then what leaves through a side is lost
  bool changing = false;                   ///< some shape changes with wavelength: photons leave the shapes to us
};

/// Sums over photons, each of them 1 at every wavelength when it starts.
struct PhotonLedger {
  explicit PhotonLedger(const PhotonScene& scene);
  Spectrum reflected;                       ///< left upwards
  Spectrum lost;                            ///< past the scene's edge
  Spectrum unfinished;                      ///< still on its way at the last surface that is counted
  Spectrum ground, ground_first;            ///< fell onto the ground; without having met anything before
  std::vector<Spectrum> arrived, absorbed;  ///< [named material]
  std::vector<Spectrum> down, up;           ///< [level]
  void add(const PhotonLedger& other);
};

/// Light that a facet absorbed, by band.
struct FacetDeposit {
  std::uint32_t primitive = 0;
  std::vector<double> band;
};

/// Counts photons step by step.
class PhotonCount {
 public:
  /// Keeps the reference. facets: what they absorb is kept in deposits.
  PhotonCount(const PhotonScene& scene, bool facets);

  PhotonLedger ledger;
  std::vector<FacetDeposit> deposits;  ///< of the last step

  /// So many start now, from above all of the scene.
  void start(std::size_t count);
  /// The photons as they are before a step.
  void set_off(const std::vector<shared::Photon>& photons);
  /// What PhotonTracer::step made of them. first: that it was the first. Leaves those that go on, in their order.
  void step(std::vector<shared::Photon>& photons, bool first);
  /// The `count` photons that still go on are given up.
  void give_up(std::size_t count);

 private:
  void leave(const shared::Photon& photon, double from_z_m, const Spectrum& carried);
  void meet(const shared::Photon& photon, const shared::rc_float4& came, const Spectrum& carried, bool first);
  void cross(double from_m, double to_m, const Spectrum& carried);
  void go_on(const shared::Photon& photon, const shared::rc_float4& came, Spectrum& carried);
  /// What leaves a material by a photon's side and direction, over its factor; it came along `came`.
  const Spectrum& leaving(const MaterialLight& material, const shared::Photon& photon, const shared::rc_float4& came);

  const PhotonScene& scene_;
  bool facets_;
  std::vector<double> level_;  ///< above what rounding lifts surfaces on them
  std::vector<Spectrum> carried_;
  std::vector<double> from_z_m_;         ///< where their segments begin: just below the surface
  std::vector<shared::rc_float4> came_;  ///< their ways before the step
  Spectrum kept_, leaves_, by_lobes_;    ///< of one photon, kept for their memory
};

}  // namespace raycube::run
