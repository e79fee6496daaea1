#include "host/reference/spread.h"

#include <numbers>

#include <glm/geometric.hpp>

#include "scene_compiler/matter.h"

namespace raycube::reference {

double spread(const scene::CompiledScene& scene, const Sample& sample, const glm::dvec3& direction) {
  if (sample.side == RC_FAR_SIDE) return 1;
  const std::uint32_t first = scene::matter_of(scene, sample.hit.primitive).material[0];
  if (first == 0) return 1;
  if (sample.side == RC_GLOSS_SIDE) return spread(*scene::gloss_of(scene, sample.hit.primitive), sample, direction);
  if (sample.side == RC_NEAR_SIDE) return spread(scene.materials[first - 1].front, sample, direction);
  return spread(scene::further_of(scene, sample.hit.primitive, sample.side - RC_FURTHER_SIDE)->shape, sample,
                direction);
}

double spread(const scene::Shape& shape, const Sample& sample, const glm::dvec3& direction) {
  if (shape.number == RC_SHAPE_lambert) return 1;
  const glm::dvec3 viewer =
      -glm::normalize(glm::dvec3(sample.ray.direction[0], sample.ray.direction[1], sample.ray.direction[2]));
  const auto local = [](const glm::dvec3& v) { return RcLocal{v.x, v.y, v.z}; };
  return rc_shape_eval(shape.number, std::numbers::pi, shape.parameters(),
                       rc_angles(local(sample.normal), local(direction), local(viewer)));
}

}  // namespace raycube::reference
