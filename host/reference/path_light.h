// What light does at the surfaces of a path between surfaces (docs/light.md), in double, on the wavelengths of a plan's
// grid: what reference paths of its own (bounced_light.h) and the device's (path_replay.h) gain step by step.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "host/reference/radiance.h"

namespace raycube::reference {

using Spectrum = std::vector<double>;  ///< on the plan's grid

struct PathGains {
  Spectrum carried;              ///< what the viewer sees of a unit of radiance that comes back
  Spectrum emitted;              ///< by surfaces beyond the surroundings, W m-2 sr-1 um-1
  std::vector<Spectrum> gained;  ///< [source], as the plan counts them, emission left out: of a unit of each

  /// False: nothing is left to carry.
  bool carry(double factor, const Spectrum& times);
  void add(std::size_t source, double scalar, const Spectrum& times);
};

/// The side of a surface that a ray came to, the one behind it where something goes through, and the gloss of the
/// first where it has one.
std::vector<const Sample*> sides_of(const SampledPixel& at);

class PathLight {
 public:
  /// Keeps references; the grid may be another than the one the plan was made for, all else of it the same.
  PathLight(const ReferenceScene& scene, const plan::Plan& plan);

  PathGains unit() const;
  /// Of light that falls onto a side from a direction, what goes to the path's viewer over Lambert's law: its
  /// materials' curves by their fractions and shapes.
  Spectrum scattered(const Sample& side, const glm::dvec3& from) const;
  /// Transmittance of the plate that a sample lies on.
  Spectrum let_through(const Sample& at) const;
  /// What a surface sends by itself beyond the surroundings.
  void add_heat(const Sample& at, PathGains& light) const;
  /// Takes away what the plate that a pixel sees counts for what it lets through, its own light, and not that of the
  /// surroundings.
  void take_own_for_through(const Sample& at, PathGains& light) const;
  /// From an open direction; of the surroundings what the sky takes from them.
  void add_sky(const glm::dvec3& way, PathGains& light) const;
  /// Open level ground around the scene, of its mean reflectance, as seen from a point.
  void add_ground(const glm::dvec3& from, PathGains& light) const;
  /// The sides of the surface that a ray met, lit or not by the sun, as of a pixel with one sample.
  SampledPixel stand(const Ray& ray, const Hit& hit) const;

 private:
  /// Of a material, by its index, the part of a black body's light that it sends.
  using OwnLight = std::function<Spectrum(std::size_t material)>;
  /// Adds that part of what a black body sends beyond the surroundings, of each material.
  void add_excess(const Sample& at, PathGains& light, const OwnLight& own) const;

  const ReferenceScene& scene_;
  const plan::Plan& plan_;
  std::vector<Spectrum> curve_;   ///< [curve - 1], curves_on
  Spectrum ground_;               ///< reflectance around; empty where light between ground and air is off
  std::array<double, 4> open_{};  ///< irradiance of level ground by each component, per unit of its spectrum
};

/// Unit vector by the cosine about a normal, for u and v uniform in [0, 1).
glm::dvec3 by_cosine(const glm::dvec3& normal, double u, double v);

}  // namespace raycube::reference
