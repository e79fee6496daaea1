// Light that came by two surfaces and more (docs/light.md, Light between surfaces), by paths of the reference's own:
// other draws than the device's, in double, by Embree, whole spectra along them, each followed to its last surface.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reference/path_light.h"

namespace raycube::reference {

class BouncedLight {
 public:
  /// Keeps references; levels: surfaces after the first, at least 1.
  BouncedLight(const ReferenceScene& scene, const plan::Plan& plan, int levels);

  /// By one path of a pixel: W m-2 sr-1 um-1 at the sensor, [band]. Its mean over paths is the pixel's light without
  /// that which was scattered once; its spread is that of one path. All sources, as the plan has them; of thermal light
  /// what the surroundings, which stand for what hides the sky, do not count yet.
  std::vector<double> by_path(const SampledPixel& pixel, std::uint64_t seed, std::uint32_t path) const;

 private:
  struct Walk;
  /// Through plates too, which hide it from all else; seen_too: what nothing hides.
  void add_sun(const SampledPixel& at, Walk& walk, bool seen_too) const;
  /// Whether nothing but plates lies ahead; multiplies `let` by what they let through.
  bool behind_plates(Sample from, const glm::dvec3& way, Spectrum& let) const;
  /// Whether a path that met a plate goes straight on through it, which chance decides; of all else it does not.
  bool pass(const SampledPixel& at, Walk& walk) const;
  /// What the path meets next, beyond plates that it passes; passed: whether it did.
  Hit ahead(Walk& walk, bool& passed) const;
  void add_lamps(const SampledPixel& at, Walk& walk) const;
  /// Sky from the last surface, where nothing but plates hides it.
  void add_last_sky(Walk& walk) const;
  /// Chooses side and direction in which the path goes on; false: it does not.
  bool turn(const SampledPixel& at, Walk& walk) const;
  /// The same by the gloss of the surface.
  bool mirror(const Sample& gloss, Walk& walk) const;
  /// The sides of the surface that a path's ray met, lit or not by the sun, as of a pixel with one sample.
  SampledPixel stand(const Sample& from, const glm::dvec3& way, const Hit& hit) const;
  /// Radiance of the bands at the pixel's sensor, by the nodes of the point that it sees.
  std::vector<double> at_sensor(const SampledPixel& pixel, const Sample& first, const Walk& walk) const;

  const ReferenceScene& scene_;
  const plan::Plan& plan_;
  int levels_;
  PathLight light_;
};

}  // namespace raycube::reference
