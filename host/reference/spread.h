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

}  // namespace raycube::reference
