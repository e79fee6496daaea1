// The compiled scene in Embree 3, robust mode: the reference's own intersection, sharing nothing with the device but
// data.
#pragma once

#include <limits>
#include <memory>

#include "host/reference/ray.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::reference {

/// One Embree scene per tree (its blocks' triangles), one Embree instance per placed tree, with the stored fp32
/// matrices. Safe to query from several threads.
class EmbreeScene {
 public:
  /// Reads the scene once; keeps nothing of it. Throws Error(environment) when Embree cannot start or runs out of
  /// memory.
  explicit EmbreeScene(const scene::CompiledScene& scene);
  ~EmbreeScene();
  EmbreeScene(const EmbreeScene&) = delete;
  EmbreeScene& operator=(const EmbreeScene&) = delete;

  /// `t_far`: nothing beyond counts, in units of the direction.
  Hit intersect(const Ray& ray, float t_far = std::numeric_limits<float>::infinity()) const;
  /// Anything along the direction? `t_far` as above.
  bool occluded(const Ray& ray, float t_far = std::numeric_limits<float>::infinity()) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace raycube::reference
