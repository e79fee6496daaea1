// Rays of pulses: Embree finds the primitive on an fp32 ray that starts where the ray enters the scene's box, double
// says where it lies.
#pragma once

#include <limits>
#include <optional>
#include <utility>

#include "host/reference/contact.h"
#include "host/reference/embree_scene.h"

namespace raycube::reference {

struct LidarHit {
  Hit hit;
  double t_m = 0;  ///< on the double ray, to the triangle's plane
  glm::dvec3 point{0};
  glm::dvec3 normal{0};  ///< unit, turned against the ray
  std::uint32_t surface = 0;
  double clear_m = 0;  ///< how far off the surface a ray must start to be rid of it (sampled_pixel.h, kOffsetUlp)
};

class LidarTracer {
 public:
  /// Keeps references.
  LidarTracer(const scene::CompiledScene& scene, const EmbreeScene& embree) : scene_(scene), embree_(embree) {}

  /// First surface between from_m and to_m of a ray with a unit direction. `leaving`: never met again. `lift_m`: shift
  /// of the fp32 ray's origin, the double ray's stays.
  std::optional<LidarHit> next(const glm::dvec3& origin, const glm::dvec3& direction, double from_m, double to_m,
                               const Hit& leaving, const glm::dvec3& lift_m) const;
  /// Where a ray enters the scene's box; infinite when it misses it.
  double entry_m(const glm::dvec3& origin, const glm::dvec3& direction) const {
    return inside(origin, direction, 0, std::numeric_limits<double>::infinity()).first;
  }

 private:
  /// The part of a ray in the scene's box, a little more; infinite when there is none.
  std::pair<double, double> inside(const glm::dvec3& origin, const glm::dvec3& direction, double from_m,
                                   double to_m) const;

  const scene::CompiledScene& scene_;
  const EmbreeScene& embree_;
};

}  // namespace raycube::reference
