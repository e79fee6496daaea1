// Which pixels the tolerance is of, and by how much each counts (scene::ToleranceMeasure); what is left of it.
#pragma once

#include <vector>

#include "host/plan/plan.h"
#include "host/render/renderer.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

/// Weight of each material of the scene in the figure that the tolerance is of: 1 of those that are listed and of the
/// members of their families, else 0. Empty: all pixels count alike.
std::vector<double> material_weights(const scene::Simulation& simulation);

/// Weight of each pixel of the tiles, in their order: the share of it that the listed materials cover, as a lattice of
/// 34 samples (cells under a point spread) finds it on the device. Empty where all pixels count alike.
std::vector<float> pixel_weights(render::Renderer& renderer, const scene::Simulation& simulation,
                                 const scene::Instrument& instrument, const plan::Plan& plan,
                                 const std::vector<render::Tile>& tiles);

/// Errors of two independent causes together, 1, each by the figure: roots of mean squares add in squares, other
/// figures at most as they are.
double together(scene::ErrorFigure figure, double one, double other);
/// What one of them leaves of `all` to the other.
double left_beside(scene::ErrorFigure figure, double all, double one);

}  // namespace raycube::planner
