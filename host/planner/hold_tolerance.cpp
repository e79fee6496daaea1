// What the nodes and components of a plan leave out, against the whole tables, and whether the tolerance holds it.
#include <fmt/format.h>

#include "host/base/error.h"
#include "host/planner/model_trial.h"
#include "host/planner/planner.h"

namespace raycube::planner {
namespace {

constexpr int kFineDirections = 1024;  ///< of a plan that would not hold its tolerance by fewer: as `check` looks in

}  // namespace

void measure_plan(Decision& out, const scene::Simulation& simulation, const scene::Instrument& instrument,
                  const plan::Plan& plan, const atmos::RenderTable& table, int threads) {
  ModelError error = model_error(simulation, instrument, plan, table, threads);
  if (error.total.bound > simulation.tolerance)
    error = model_error(simulation, instrument, plan, table, threads, kFineDirections);
  out.plan_error = error.total.bound;
  out.model_pixels = error.pixels;
  out.measured.push_back(fmt::format(
      "nodes and components: {:.2g} %, at most {:.2g} % (sun {:.2g}, sky {:.2g}, path {:.2g}, ground around {:.2g}, "
      "emission {:.2g}), {} pixels against the whole tables",
      100 * error.total.estimate, 100 * error.total.bound, 100 * error.sun.estimate, 100 * error.sky.estimate,
      100 * error.path.estimate, 100 * error.environment.estimate, 100 * error.emission.estimate, error.pixels));
}

void hold_tolerance(Decision& decision, const scene::Simulation& simulation, const scene::Instrument& instrument,
                    const plan::Plan& plan, const atmos::RenderTable& table, int threads) {
  if (plan.refusal.empty()) return;
  measure_plan(decision, simulation, instrument, plan, table, threads);
  if (decision.plan_error > simulation.tolerance)
    throw base::Error(base::Fault::input, fmt::format("{}; measured on {} pixels of this scene: {:.3g}; raise the "
                                                      "tolerance, narrow the field of view or split the scene's relief",
                                                      plan.refusal, decision.model_pixels, decision.plan_error));
}

void take_held(Decision& decision, const Decision& held) {
  if (held.model_pixels == 0) return;  // nothing was measured
  decision.plan_error = held.plan_error, decision.model_pixels = held.model_pixels;
  decision.measured.insert(decision.measured.end(), held.measured.begin(), held.measured.end());
}

}  // namespace raycube::planner
