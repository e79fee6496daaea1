#include "host/reference/spread.h"

#include <numbers>
#include <span>

#include <glm/geometric.hpp>

#include "kernels/shared/tile_layout.h"
#include "scene_compiler/lobe_albedo.h"
#include "scene_compiler/matter.h"

namespace raycube::reference {

const scene::Shape* shape_of(const scene::CompiledScene& scene, const Sample& sample) {
  if (sample.side == RC_FAR_SIDE) return nullptr;
  const std::uint32_t first = scene::matter_of(scene, sample.hit.primitive).material[0];
  if (first == 0) return nullptr;
  if (sample.side == RC_GLOSS_SIDE) return scene::gloss_of(scene, sample.hit.primitive);
  if (sample.side == RC_NEAR_SIDE) return &scene.materials[first - 1].front;
  return &scene::further_of(scene, sample.hit.primitive, sample.side - RC_FURTHER_SIDE)->shape;
}

double spread(const scene::CompiledScene& scene, const Sample& sample, const glm::dvec3& direction) {
  const scene::Shape* shape = shape_of(scene, sample);
  return shape ? spread(*shape, sample, direction) : 1;
}

glm::dvec3 viewer_of(const Sample& sample) {
  return -glm::normalize(glm::dvec3(sample.ray.direction[0], sample.ray.direction[1], sample.ray.direction[2]));
}

double spread(const scene::Shape& shape, const Sample& sample, const glm::dvec3& direction) {
  if (shape.number == RC_SHAPE_lambert) return 1;
  const auto local = [](const glm::dvec3& v) { return RcLocal{v.x, v.y, v.z}; };
  return rc_shape_eval(shape.number, std::numbers::pi, shape.parameters(),
                       rc_angles(local(sample.normal), local(direction), local(viewer_of(sample))));
}

RcLocal on_surface(const glm::dvec3& n, const glm::dvec3& v) {
  const double turned = v.z + rc_turned(v.x * n.x + v.y * n.y, n.z, n.x * n.x + n.y * n.y);
  return {v.x - n.x * turned, v.y - n.y * turned, glm::dot(n, v)};
}

double even_light(const scene::CompiledScene& scene, const plan::Thermal& thermal, const Sample& sample,
                  std::size_t record) {
  if (thermal.albedo_at.empty()) return 1;
  const std::size_t surface = scene::surface_of(scene, sample.hit.primitive);
  const std::size_t records = thermal.albedo_at.size() / scene.surfaces.size();
  const std::uint32_t table = thermal.albedo_at[surface * records + record];
  if (table == 0) return 1;
  constexpr std::size_t size = RC_ALBEDO_ZENITHS * RC_ALBEDO_AZIMUTHS;
  return scene::between_albedos(std::span(thermal.albedo).subspan((table - 1) * size, size), RC_ALBEDO_ZENITHS,
                                RC_ALBEDO_AZIMUTHS, on_surface(sample.normal, viewer_of(sample)));
}

double even_light(const scene::CompiledScene& scene, const plan::Thermal& thermal, const Sample& sample) {
  if (sample.side == RC_FAR_SIDE) return 1;
  std::size_t record = 0;
  if (sample.side == RC_GLOSS_SIDE) {
    const shared::Surface& surface = scene::matter_of(scene, sample.hit.primitive);
    for (std::size_t i = 0; i < 4; ++i)
      if (surface.material[i] != 0 && scene.materials[surface.material[i] - 1].gloss.number != RC_SHAPE_none)
        record = 1 + i;
  } else if (sample.side >= RC_FURTHER_SIDE) {
    record = RC_LOBES + sample.side - RC_FURTHER_SIDE;
  }
  return even_light(scene, thermal, sample, record);
}

}  // namespace raycube::reference
