// raycube sweep FILE: what results make of a study's parameters.
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/cli/services.h"
#include "host/cli/verb.h"
#include "host/experiment/sweep_points.h"
#include "host/run/python_chart.h"

namespace raycube::cli {
namespace {

struct SweepRequest {
  std::string file;
  bool no_picture = false;
};

int run_sweep(const SweepRequest& request, Invocation& invocation) {
  const experiment::Sweep sweep = experiment::read_sweep(request.file);
  const auto points = experiment::points_of(sweep);
  if (invocation.common.dry_run) {
    invocation.out << experiment::sweep_csv(sweep, points,
                                            {points.size(), std::vector<double>(sweep.metrics.size(), NAN)});
    return 0;
  }
  experiment::KeptSteps steps(invocation.common.output.empty() ? "sweep" : invocation.common.output, sweep.folder,
                              request.file);
  steps.forget_reports({"sweep.csv", "sweep.json", "sweep.png"});  // of other levels, perhaps
  const run::Services services = services_of(invocation);
  std::vector<std::vector<double>> metrics;
  {
    const run::Step progress(services, sweep.title, points.size(), "points");
    metrics = experiment::run_points(sweep, points, steps, [&] { progress.advance(); });
  }
  const std::string figures = experiment::sweep_json(sweep, points, metrics).dump(2) + "\n";
  base::write_output_file(steps.folder() + "/sweep.csv", experiment::sweep_csv(sweep, points, metrics),
                          base::IfExists::replace);
  if (request.no_picture)
    base::write_output_file(steps.folder() + "/sweep.json", figures, base::IfExists::replace);
  else
    run::draw_chart("sweep.py", figures, steps.folder() + "/sweep.png", base::IfExists::replace);
  invocation.out << (invocation.common.json ? figures : steps.folder() + "/sweep.csv\n");
  return 0;
}

}  // namespace

Verb verb_sweep() {
  auto o = std::make_shared<SweepRequest>();
  Verb verb("sweep", "Run a study over its parameters, and say which of them its results hang on");
  verb.description =
      "FILE has parameters (lists or ranges), steps that are run for each point, with {PARAMETER} in their commands, "
      "and "
      "metrics, numbers of what they leave. One at a time, all combinations, or variance-based (Sobol) indices with "
      "intervals. Points that share a step share its results; finished ones are kept, also after a run that was "
      "killed. "
      "sweep.csv has a row a point, sweep.json the indices, sweep.png a chart. The file's keys are in docs/studies.md.";
  verb.examples = {"raycube sweep study.toml -o sweep", "raycube sweep study.toml --dry-run"};
  verb.common = kOutput | kDryRun;
  verb.output_default = "sweep";
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "The sweep, TOML", o->file);
    table.flag("--no-picture", "Draw no chart", o->no_picture);
  };
  verb.run = [o](Invocation& invocation) { return run_sweep(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
