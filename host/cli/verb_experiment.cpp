// raycube experiment FILE: a study's steps, kept, and its report.
#include <memory>
#include <ostream>

#include <fmt/format.h>

#include "host/cli/services.h"
#include "host/cli/verb.h"
#include "host/experiment/html_report.h"

namespace raycube::cli {
namespace {

struct ExperimentRequest {
  std::string file;
};

int dry_run(const experiment::Experiment& study, experiment::KeptSteps& steps, Invocation& invocation) {
  for (const experiment::StepPlan& step : study.steps) {  // what builds on one that runs finds no such name, and runs
    const bool kept = steps.is_kept(step);
    if (kept) steps.make(step);
    invocation.out << step.name << (kept ? ": kept\n" : ": to run\n");
  }
  return 0;
}

int run_experiment(const ExperimentRequest& request, Invocation& invocation) {
  const experiment::Experiment study = experiment::read_experiment(request.file);
  experiment::KeptSteps steps(invocation.common.output.empty() ? "experiment" : invocation.common.output, study.folder,
                              request.file, invocation.common.dry_run);
  if (invocation.common.dry_run) return dry_run(study, steps, invocation);
  steps.forget_reports({"report.html", "numbers.json"});
  const run::Services services = services_of(invocation);
  std::vector<std::pair<std::string, experiment::KeptStep>> made;
  {
    const run::Step progress(services, study.title, study.steps.size(), "steps");
    for (const experiment::StepPlan& step : study.steps) {
      invocation.log.set_status("step " + step.name);
      made.emplace_back(step.name, steps.make(step));
      const experiment::KeptStep& one = made.back().second;
      invocation.log.info(one.run ? fmt::format("{}: {:.1f} s", step.name, one.seconds) : step.name + ": kept");
      progress.advance();
    }
  }
  invocation.log.set_status("");
  const auto figures = experiment::told_figures(study, steps.folders());
  const nlohmann::ordered_json numbers = experiment::numbers_json(study, figures, made);
  const std::string report = steps.folder() + "/report.html", beside = steps.folder() + "/numbers.json";
  base::write_output_file(beside, numbers.dump(2) + "\n", base::IfExists::replace);
  base::write_output_file(report, experiment::report_html(study, figures, made), base::IfExists::replace);
  if (invocation.common.json)
    invocation.out << numbers.dump(2) << "\n";
  else
    invocation.out << report << "\n";
  return 0;
}

}  // namespace

Verb verb_experiment() {
  auto o = std::make_shared<ExperimentRequest>();
  Verb verb("experiment", "Run a study's steps, keep them, and report its figures beside what was published");
  verb.description =
      "FILE lists steps (commands, each with a folder of its own) and figures (pictures and numbers of their results, "
      "with what was published). Steps whose commands, inputs, foregoing steps and program have not changed are kept "
      "and "
      "not run again, also after a run that was killed; report.html holds everything it shows, numbers.json has every "
      "number. The file's keys are in docs/studies.md.";
  verb.examples = {"raycube experiment scenes/avon/experiment.toml -o avon", "raycube experiment study.toml --dry-run"};
  verb.common = kOutput | kDryRun;
  verb.output_default = "experiment";
  verb.add_options = [o](base::OptionTable& table) { table.argument("FILE", "The experiment, TOML", o->file); };
  verb.run = [o](Invocation& invocation) { return run_experiment(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
