// Where a whole render costs less than a trial it is rendered at once, as replicates with few samples and sky rays
// each, all kept: their mean is the image, their spread its error. Twice as many are taken until the error fits twice
// running, so that no lucky draw ends it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/planner/cost_model.h"
#include "host/planner/trial_pixels.h"
#include "host/render/renderer.h"

namespace raycube::planner {

/// Samples (a lattice) and sky directions of the smallest replicates. A lattice of as many points as all replicates
/// have errs less than they do, so few are right where few replicates do; where more would cost more than larger ones,
/// these are rendered in their place.
inline constexpr int kReplicateSamples = 13, kReplicateDirections = 8;
inline constexpr int kMostReplicates = 64;

struct ReplicateSize {
  int samples = kReplicateSamples, directions = kReplicateDirections;
  bool operator==(const ReplicateSize&) const = default;
};

/// What is known of a mean over replicates, by their spread over all its pixels.
TrialError error_of(const render::ReplicateSpread& spread);

struct Replicates {
  ReplicateSize size;
  int count = 0;  ///< 0: so many would take more than a trial and a render by its choice
  std::shared_ptr<const render::RenderedImage> image;  ///< null: there is not memory enough to keep it
  TrialError error;
  std::vector<std::string> measured;  ///< every number of replicates that was judged
};

/// Whether an image of this plan is one for replicates: its samples and directions are the planner's, a pixel is the
/// square of its samples, the tolerance is of the rms over all of them, and four replicates take less than a trial.
bool may_replicate(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan);

/// The size that is begun with: of which two to four would fit in an image full of small things, as far as four take no
/// more than a trial.
ReplicateSize first_size(const scene::Instrument& instrument, const plan::Plan& plan, double tolerance);

/// Replicates whose mean errs by at most `budget`, as many whatever the memory.
Replicates render_replicates(render::Renderer& renderer, const scene::Simulation& simulation,
                             const scene::Instrument& instrument, const plan::Plan& plan, double budget);

}  // namespace raycube::planner
