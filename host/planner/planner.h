// The planner: the cheapest samples of a pixel and sky directions whose errors, with those of the plan's nodes and
// components, fit the tolerance (DESIGN 6). What the file gives is kept and its error estimated.
//
//   figure    errors are those that the tolerance is of (scene::ToleranceMeasure), the rms over all pixels by default
//   budget    of every band s^2 + k^2 + kSure sqrt(ds^2 + dk^2 + 2 kTogether ds dk) + plan^2 <= (kUse tolerance)^2:
//             errors of samples (s), directions (k) and plan are independent of each other; ds and dk are one standard
//             error of s^2 and k^2 (band_errors.h); plan is the bound of its worst band; figures
//             other than the rms are scaled from it (TrialError), and that of plan is added as it is
//   errors    of each band over its mean radiance, measured on the trial's pixels; by power laws between levels
//   cost      CostModel; two runs give one plan
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "host/plan/plan.h"
#include "host/planner/cost_model.h"
#include "host/planner/error_law.h"
#include "host/planner/pixel_trial.h"
#include "host/sensors/small_objects.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

/// Part of the tolerance that is spent: a trial's pixels are not the image's.
inline constexpr double kUse = 0.95;

/// One row of the table of `raycube plan`.
struct PlanLine {
  std::string block, level;
  double error = -1;  ///< estimated, of the level chosen; below 0: not estimated
  double next_error =
      /// of leaving the next level out, that is of the level before this one; below 0: there is none, or not estimated
      -1;
  std::string cost, why;
  bool given = false;  ///< by the file, not chosen
};

/// What the planner settles besides the plan itself.
struct Sampling {
  scene::SamplerKind sampler = scene::SamplerKind::grid;
  int samples_u = 1, samples_v = 1, directions = 1;  ///< of each replicate
  int replicates = 1;
  int first_samples = 0;  ///< of adaptive samples, as the file has them; errors are judged without
  int paths_per_two = 1;  ///< paths between surfaces that go with two directions
};

struct Decision {
  Sampling sampling;
  bool samples_given = false, directions_given = false;
  bool estimated = false;        ///< a trial was made; false: everything was given and none was asked for
  double plan_error = 0;         ///< of nodes and components: as make_plan has it, or measured
  double plan_estimate = 0;      ///< as make_plan has it: worst places and obstacles
  std::size_t model_pixels = 0;  ///< that met the whole tables; 0: not measured
  /// Bound of the level chosen, and estimate of the one before, each of its own worst band.
  double samples_error = -1, samples_less_error = -1;
  double sky_error = -1, sky_less_error = -1;
  double total_error = -1;  ///< bound of all together, of the worst band
  double tolerance = 0.01;
  scene::ToleranceMeasure measure;  ///< what the errors below it and above it are of
  bool within = true;               ///< total_error <= tolerance
  PixelCounts counts;
  double s_per_megapixel = 0;                   ///< nominal, by the cost model
  bool dear = false;                            ///< above kDear_s_per_megapixel
  std::size_t trial_pixels = 0, looked_at = 0;  ///< pixels of the trial, and of the first look
  std::uint64_t trial_rays = 0;
  sensors::SmallObjectSurvey small;  ///< objects that an rms over pixels does not see
  /// The image itself, small objects aside, where its replicates were the trial.
  std::shared_ptr<const render::RenderedImage> image;
  std::vector<std::string> measured;  ///< each setting that the trial rendered, with estimate and bound of its error
  std::vector<std::string> notes;     ///< what the user must know: a tolerance that is not kept, one that is dear
};

/// A pair of levels with its errors, and what choose() saw.
struct Choice {
  int samples = 1, directions = 1;
  bool within = false;
};

/// Directions of a set that are tried; samples: SamplePattern::levels.
const std::vector<int>& direction_levels();

/// Nominal seconds of a pixel.
using PixelCost = std::function<double(int samples, int directions)>;

/// Errors of a level in every band.
using LevelErrors = std::function<BandErrors(int level)>;

/// The cheapest pair whose errors together (bound_together) are at most `budget`; where none of at most
/// kMost_s_per_megapixel has that, the pair of those with the least error, and where none is that cheap, the cheapest.
/// Fixed levels: one-element lists.
Choice choose(const LevelErrors& of_samples, const LevelErrors& of_directions, double budget, const PixelCost& cost_s,
              const std::vector<int>& samples, const std::vector<int>& directions);

/// Makes the decision for an instrument. `plan`: of make_plan with `table`, any directions. With samples and directions
/// both given nothing is tried unless `estimate_given`; else the nodes' and components' error is measured too where its
/// estimate takes much of the tolerance. `threads`: of what is computed on the host; 0: all. `progress`: told of
/// trials. `held`: of hold_tolerance for the same plan, where that has been asked. Throws Error(input) as
/// hold_tolerance does.
Decision decide(render::Renderer& renderer, const scene::Simulation& simulation, const scene::Instrument& instrument,
                const plan::Plan& plan, const atmos::RenderTable& table, bool estimate_given, int threads = 0,
                TrialProgress progress = {}, const Decision* held = nullptr);

/// What the decision's settings cost, all replicates together.
void count_cost(Decision& decision, const plan::Plan& plan);

/// The decision where nothing may be tried (no device, an internal camera): what the file or the defaults say.
Decision as_given(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan);

/// Puts what is measured against the whole tables in place of the estimate of nodes and components.
void measure_plan(Decision& out, const scene::Simulation& simulation, const scene::Instrument& instrument,
                  const plan::Plan& plan, const atmos::RenderTable& table, int threads);

/// Measures a plan that by its estimates may not hold the tolerance (Plan::refusal); throws Error(input) where it does
/// not.
void hold_tolerance(Decision& decision, const scene::Simulation& simulation, const scene::Instrument& instrument,
                    const plan::Plan& plan, const atmos::RenderTable& table, int threads = 0);

/// What hold_tolerance has measured for another decision of the same plan.
void take_held(Decision& decision, const Decision& held);

/// Surveys the instrument's small objects for the decision's samples; those that its image will miss become a
/// note.
void add_small_objects(Decision& decision, const scene::Instrument& instrument, sensors::SmallObjectPixels small);

/// The instrument and the plan with the decision's settings, small objects included.
void apply(const Decision& decision, scene::Instrument& instrument, plan::Plan& plan);

}  // namespace raycube::planner
