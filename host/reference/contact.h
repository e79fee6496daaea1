// One ray against one triangle in double, with the rounding that fp32 arithmetic may have put into the answer.
#pragma once

#include <glm/vec3.hpp>
#include <glm/mat3x3.hpp>

#include "host/reference/ray.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::reference {

/// Unit round-off of float, 2^-24. Every bound below is a count of these ("ulp") times a magnitude.
inline constexpr double kUlp = 5.9604644775390625e-8;

/// Rounding of a vertex relative to the ray's origin, in ulp of its distance: one subtraction in the Pluecker form;
/// three more for forms that project the vertex onto the image plane (two dot products and a division).
inline constexpr double kVertexUlp = 4;
/// Rounding of an edge function d . (e x s), e = edge, s = sum of its two vertices relative to the origin, in ulp of
/// |d| |e| |s|: one each for e and s, two for the cross product, three for the dot product, one spare.
inline constexpr double kEdgeUlp = 8;
/// Rounding of the ray's direction, in ulp of |d|: two fused multiply-adds, or none where edge functions are linear in
/// the image plane.
inline constexpr double kDirectionUlp = 2;
/// Rounding of a point or vector carried into an instance's frame, in ulp of |M| |x| + |translation|: four for the
/// affine product, one for rounding the stored inverse, and eleven for Embree, which inverts world_from_local in fp32
/// itself.
inline constexpr double kTransformUlp = 16;
/// Rounding of a hit's depth beside that of the vertices, in ulp of the depth: triple product, division, refinement.
inline constexpr double kDepthUlp = 16;

/// A ray in double. `origin_slack_m`: how far another computation's origin may lie from this one (spawned rays).
struct DoubleRay {
  glm::dvec3 origin{0}, direction{0};
  double origin_slack_m = 0;
};

/// A ray with an offset may start where others round the sum of origin and offset to.
inline DoubleRay to_double(const Ray& ray) {
  const bool rounded = ray.offset != std::array<float, 3>{};
  return {start_of(ray), to_double(ray.direction), rounded ? 2 * kUlp * glm::length(start_of(ray)) : 0};
}

/// A ray in the frame of an instance, with isotropic bounds of the rounding done on the way there.
struct LocalRay {
  glm::dvec3 origin{0}, direction{0};
  double origin_error_m = 0, direction_error = 0;
};

/// By the stored local_from_world matrix, the one the device uses. t is shared between the frames.
LocalRay to_local(const shared::Instance& instance, const DoubleRay& ray);

/// Where a ray stands to a triangle once every value within the bounds is considered.
enum class Side { outside, uncertain, inside };

/// Closest-approach record of one ray and one triangle.
struct Contact {
  Side side = Side::outside;
  bool grazing = false;  ///< the plane is edge-on within the bound: depth means nothing
  bool hit = false;      ///< double arithmetic says: inside or on an edge, t >= 0, not edge-on
  double t = 0;          ///< of the plane, in units of the direction's length
  double t_bound = 0;    ///< half width of the interval that fp32 may report; infinite when grazing
  double edge_ulp = 0;   ///< smallest |edge function| in units of its bound: < 1 is an edge tie
  bool certain() const { return side == Side::inside && !grazing && t - t_bound > 0; }
  bool possible() const { return side != Side::outside && t + t_bound >= 0; }
};

/// Vertex `corner` (0..2) of a primitive, mesh frame, m.
glm::dvec3 vertex(const scene::CompiledScene& scene, std::uint32_t primitive, int corner);

Contact contact(const scene::CompiledScene& scene, std::uint32_t primitive, const LocalRay& ray);

/// Unit geometric normal in the scene frame, outward by winding (inverse transpose of world_from_local).
glm::dvec3 world_normal(const scene::CompiledScene& scene, const Hit& hit);

}  // namespace raycube::reference
