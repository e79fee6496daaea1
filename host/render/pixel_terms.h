// What a pixel's radiance is the sum of, by rows of the band table.
#pragma once

#include <cstdint>
#include <vector>

#include "host/plan/plan.h"
#include "host/render/types.h"

namespace raycube::render {

/// Radiance of each band, W m-2 sr-1 um-1: terms in their order, in double.
std::vector<double> sum_of_terms(const plan::Plan& plan, const scene::CompiledScene& scene, const PixelTerms& terms);

}  // namespace raycube::render
