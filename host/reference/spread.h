// How a surface spreads what it reflects, by the closed forms of kernels/materials, in double.
#pragma once

#include "host/reference/sampled_pixel.h"

namespace raycube::reference {

/// How many times the radiance of Lambert's law goes from `direction` (unit, away from the surface) back along the
/// sample's ray by the sample's side: pi f of its shape or its gloss. 1 for Lambert's law itself, and for what comes
/// through from the far side.
double spread(const scene::CompiledScene& scene, const Sample& sample, const glm::dvec3& direction);
/// The same by a shape.
double spread(const scene::Shape& shape, const Sample& sample, const glm::dvec3& direction);

/// A direction, unit, along what is east and north on a surface and its normal (RcAngles).
RcLocal on_surface(const glm::dvec3& normal, const glm::dvec3& direction);
/// Unit vector from a sample back along its ray.
glm::dvec3 viewer_of(const Sample& sample);
/// Shape of a sample's side; null: Lambert's law, or what comes through.
const scene::Shape* shape_of(const scene::CompiledScene& scene, const Sample& sample);

/// Of an even light what the lobe of a sample's side, or another record of its surface's lobes, sends back along the
/// sample's ray, by the plan's tables: 1 by Lambert's law.
double even_light(const scene::CompiledScene& scene, const plan::Thermal& thermal, const Sample& sample);
double even_light(const scene::CompiledScene& scene, const plan::Thermal& thermal, const Sample& sample,
                  std::size_t record);

}  // namespace raycube::reference
