// By how many surfaces light has to come: from a few of an image's pixels, whose paths are followed to several ends.
#pragma once

#include "host/plan/plan.h"
#include "host/render/renderer.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

/// Gives plan.bounces as many levels as leave out, in the worst band, no more than a tenth of the tolerance of what is
/// seen, or none where light scattered once is that near; what is left out joins the plan's errors. The same paths are
/// followed to 0, 1, 2, 4, 8 and 16 surfaces after the first under two draws, independent but for the pixels: what one
/// count misses of the last is, squared, the mean over pixels of the product of both draws' differences, and at least
/// their mean (the differences are never negative). What the last misses itself is taken from those before as of a
/// geometric series. The skeleton is that of the levels chosen. Returns whether there was anything to choose: the
/// plan's programs may be others then.
bool choose_bounces(render::Renderer& renderer, const scene::Simulation& simulation,
                    const scene::Instrument& instrument, plan::Plan& plan);

}  // namespace raycube::planner
