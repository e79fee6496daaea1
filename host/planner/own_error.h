// What is known of a render's error, whoever chose its settings (S60).
//
// Where the planner made a trial, that. Of an image that is a mean of replicates their spread.
// Where the file gives samples and directions, a few hundred pixels
// picked by hash (all of a small image) are rendered as the image is and twice more with as many samples at
// random (a lattice's shift; jittered cells under a point spread) and other rays into the sky: no reference,
// and still without bias. Like every rms over pixels it says nothing of a few pixels with targets; those are
// the small objects' matter.
#pragma once

#include <string>

#include "atmos_tables/render_table.h"
#include "host/planner/planner.h"

namespace raycube::planner {

/// Parts and total as the tolerance means them: the figure over pixels of the worst band over that band's mean;
/// below 0: not known apart. Like the plan's they are bounds, with one standard error on top; `likely` has none. A few
/// pixels at the edges of crowns carry most of a park's error: of 1024 pixels the likely one scatters by a third (2.3
/// to 4.3 % over three seeds where its chart has 3.1 %), and the bound with it.
struct OwnError {
  double total = -1, likely = -1;
  double drawn = -1;              ///< of samples and sky directions together, of their worst band
  double samples = -1, sky = -1;  ///< of either, of its own worst band
  double plan = 0;                ///< of nodes and components, as the plan has it, or measured
  std::size_t plan_pixels = 0;    ///< that were measured; 0: none
  double tolerance = 0;
  scene::ToleranceMeasure measure;
  std::string from;  ///< how it is known
  bool kept() const { return total <= tolerance; }
};

/// Of an instrument as `apply` left it. Renders only where the decision was not made by a trial. The plan's share
/// is its bound for the worst place and obstacle; where the verdict hangs on it, it is measured on the scene's own
/// pixels (model_trial.h), by as many threads, as `raycube plan` does. `spread`: of the image's replicates, if any.
OwnError own_error(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument,
                   const plan::Plan& plan, const atmos::RenderTable& table, const Decision& decision,
                   const render::ReplicateSpread& spread, int threads);

/// One line: total against tolerance, parts, how it is known.
std::string own_error_text(const OwnError& error);
/// The same as a JSON object.
std::string own_error_json(const OwnError& error);

}  // namespace raycube::planner
