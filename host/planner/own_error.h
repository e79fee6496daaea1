// What is known of a render's error, whoever chose its settings (S60).
//
// Where the planner made a trial, that. Where the file gives samples and directions no reference is rendered:
// a few hundred pixels picked by hash are rendered twice as the image is, with two seeds. The spread of each
// pixel's samples tells their error (host/render/standard_error.h: right within a factor of two for a grid),
// half the mean square between the seeds what they draw: of a grid the sky's directions alone, of lattice and
// jittered samples both together. Like every rms over pixels it says nothing of a few pixels with targets;
// those are the small objects' matter.
#pragma once

#include <string>

#include "host/planner/planner.h"

namespace raycube::planner {

/// Parts and total as the tolerance means them: rms over pixels of the worst band over that band's mean;
/// below 0: not known.
struct OwnError {
  double total = -1, samples = -1, sky = -1, plan = 0;
  double tolerance = 0;
  std::string from;  ///< how it is known
  bool known() const { return total >= 0; }
  bool kept() const { return known() && total <= tolerance; }
};

/// Of an instrument as `apply` left it. Renders only where the decision was not made by a trial.
OwnError own_error(render::Renderer& renderer, const scene::Simulation& simulation,
                   const scene::Instrument& instrument, const plan::Plan& plan, const Decision& decision);

/// One line: total against tolerance, parts, how it is known.
std::string own_error_text(const OwnError& error);
/// The same as a JSON object.
std::string own_error_json(const OwnError& error);

}  // namespace raycube::planner
