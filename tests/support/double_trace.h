// Brute force in double on the very fp32 rays (an origin may be the exact sum of two floats): the oracle of the tracing
// kernels. Edge functions are evaluated on the stored fp32 vertices and matrices, so a difference is the kernel's or
// lies inside a rounding bound stated here.
#pragma once

#include <cstdint>
#include <vector>

#include "scene_compiler/compiled_scene.h"

namespace raycube::test {

struct DoubleHit {
  double t = 1e300;  ///< in units of the direction's length
  std::uint32_t instance = RC_NONE, primitive = RC_NONE;
};

/// One triangle against one ray in double.
struct DoubleTest {
  bool hit = false;
  double t = 0;
  double edge_ulp =
      0;             ///< distance of the ray from the nearest edge line, in units of 2^-24 times the coordinates' size
  double t_ulp = 0;  ///< error bound of t in double's view of a single-precision evaluation, relative 2^-24
};

class DoubleTracer {
 public:
  explicit DoubleTracer(const scene::CompiledScene& scene) : scene_(scene) {}
  DoubleTest test(std::uint32_t instance, std::uint32_t primitive, const double (&origin)[3],
                  const float (&direction)[3]) const;
  /// Over all triangles of all instances.
  DoubleHit closest(const double (&origin)[3], const float (&direction)[3]) const;
  bool blocked(const double (&origin)[3], const float (&direction)[3]) const;

  /// Is the kernel's answer (instance, primitive; RC_NONE = miss) right, or explained by rounding? The oracle's own hit
  /// must lie within `bound_ulp` of the triangle's edge or the two distances within their bounds.
  enum class Verdict { same, explained, wrong };
  Verdict judge(const DoubleHit& truth, std::uint32_t instance, std::uint32_t primitive, const double (&origin)[3],
                const float (&direction)[3], double bound_ulp) const;

 private:
  template <typename Take>
  void for_hits(const double (&origin)[3], const float (&direction)[3], Take take) const;
  const scene::CompiledScene& scene_;
};

}  // namespace raycube::test
