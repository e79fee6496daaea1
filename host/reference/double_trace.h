// Traversal in double on the same fp32 rays, vertices and matrices: the judge where Embree and the device disagree.
#pragma once

#include <limits>
#include <string>

#include "host/reference/contact.h"

namespace raycube::reference {

/// What double arithmetic says about one ray.
struct Trace {
  Hit hit;       ///< smallest t, then the first in the user's order; edges belong to both their triangles
  double t = 0;  ///< of that hit; infinite for a miss
  /// No correct fp32 traversal can report anything beyond this depth: the nearest certain hit's t + bound.
  double certain_t = 0;
  Hit certain;  ///< that hit; a miss when no hit is certain
};

/// Why two first hits of one ray differ.
enum class Cause { agree, exact_tie, edge_tie, depth_tie, grazing, unexplained };
inline constexpr std::size_t kCauses = 6;
const char* cause_name(Cause cause);

/// Can the point be seen along a shadow ray? `uncertain`: some triangle is met or missed within the bounds.
enum class Visibility { visible, blocked, uncertain };

class DoubleTracer {
 public:
  /// Keeps a reference to the scene. Its own walk over scene.nodes, recursive, boxes padded by more than any rounding.
  explicit DoubleTracer(const scene::CompiledScene& scene) : scene_(scene) {}

  Trace trace(const Ray& ray) const { return trace(to_double(ray)); }
  Trace trace(const DoubleRay& ray) const;
  /// Every triangle of every instance, no tree: the oracle of the walk above.
  Trace trace_brute_force(const Ray& ray) const;

  /// A hit is admissible when fp32 arithmetic within the bounds of contact.h may report it: not clearly outside its
  /// triangle and not clearly behind a certain hit; a miss, when no hit is certain. Two different admissible answers
  /// are explained, and the class names the first that applies: exact tie (in double the ray meets both triangles at
  /// one depth and nothing before: two right answers), grazing, edge tie, depth tie.
  Cause explain(const Ray& ray, const Hit& a, const Hit& b) const { return explain(to_double(ray), a, b); }
  /// The same for a ray that each side rounded its own way, within the ray's slack.
  Cause explain(const DoubleRay& ray, const Hit& a, const Hit& b) const;

  /// Does the ray meet any triangle in double? `guess`: a hit tried first, which spares the walk where it is one.
  bool hits_anything(const Ray& ray, const Hit& guess) const;

  /// For a spawned ray (direction towards the light); `from` is the surface it leaves and is never its blocker; nothing
  /// beyond t_far counts, in units of the direction.
  Visibility visibility(const DoubleRay& ray, const Hit& from,
                        double t_far = std::numeric_limits<double>::infinity()) const;

 private:
  const scene::CompiledScene& scene_;
};

/// Hit point of the primitive's plane, scene frame, m, in double.
glm::dvec3 hit_point(const scene::CompiledScene& scene, const Ray& ray, const Hit& hit);

}  // namespace raycube::reference
