// Decisions of the planner held against a converged reference and against a brute-force sweep: what one instrument or
// LIDAR gives.
#pragma once

#include <string>
#include <vector>

#include "bench/report.h"
#include "host/render/renderer.h"
#include "host/run/services.h"
#include "scene_compiler/simulation.h"

namespace raycube::bench {

/// A reference whose own error is this part of the tolerance can judge it.
inline constexpr double kFifth = 0.2;

/// Samples of a pixel and sky directions, or the sub-rays of a pulse (in `samples`, directions below 0).
struct PlannerSetting {
  scene::SamplerKind sampler = scene::SamplerKind::grid;
  int samples = 1, directions = 0;  ///< of each replicate
  int replicates = 1;
  std::string text() const;
  auto operator<=>(const PlannerSetting&) const = default;
};

/// A setting of the sweep: its error with the finest nodes, and the cost the model gives it.
struct SweepPoint {
  PlannerSetting setting;
  double error = 0, low = 0, high = 0;
  double s_per_megapixel = 0;
};

/// One tolerance.
struct PlannerRow {
  double tolerance = 0;
  PlannerSetting chosen;
  double claimed = -1;                                         ///< the planner's own estimate; below 0: none
  double plan_error = -1, samples_error = -1, sky_error = -1;  ///< its parts
  bool within = true, dear = false;                 ///< what the planner says: kept; above 30 s per megapixel
  double s_per_megapixel = 0;                       ///< by the cost model (LIDAR: sub-rays)
  double plan_s = 0;                                ///< the decision took, trial and compilation counted
  bool tried = false;                               ///< achieved is there: the setting was cheap enough to render
  double achieved = 0, low = 0, high = 0, own = 0;  ///< error, its bar, and the reference's own error in that band
  bool judged = false;                              ///< the reference is good to a fifth of the tolerance
  bool best_known = false;                          ///< the sweep has a setting inside the tolerance
  SweepPoint best;
  double cost_over_best = 0;
  Spread time_over_best;                ///< count 0: not timed
  double together_s = -1, best_s = -1;  ///< plan and render of the whole image, and the best setting's render; below 0:
                                        ///< not timed
};

struct PlannerStudy {
  std::string scene, instrument, kind, reference, sweep, device;
  std::size_t pixels = 0;  ///< judged (LIDAR: rows of a pulse and pixel)
  double own = 0;          ///< the reference's own error, worst band, nodes of its plan counted
  double seconds = 0;      ///< the whole case took
  std::vector<SweepPoint> points;
  std::vector<PlannerRow> rows;
};

struct PlannerStudySettings {
  std::vector<double> tolerances{0.1, 0.03, 0.01, 0.003, 0.001};
  double reference_s = 8;  ///< nominal seconds that a reference may take
  int timings = 5;         ///< alternating pairs
  int threads = 0;
};

PlannerStudy study_instrument(scene::Simulation& simulation, std::size_t index, const std::string& name,
                              const PlannerStudySettings& settings, run::Services& services);
PlannerStudy study_lidar(scene::Simulation& simulation, std::size_t index, const std::string& name,
                         const PlannerStudySettings& settings, run::Services& services);

/// What the program renders with where nothing is asked for.
inline render::RenderOptions study_options() {
  render::RenderOptions options;
  options.tuned = true;
  return options;
}

/// The cheapest point inside the tolerance; null: none.
const SweepPoint* cheapest(const std::vector<SweepPoint>& points, double tolerance);

}  // namespace raycube::bench
