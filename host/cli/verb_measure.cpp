// `raycube measure`: reflectance factors of an area towards many directions, without air.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/cli/services.h"
#include "host/cli/verb.h"
#include "host/run/load_job.h"
#include "host/run/measure.h"

namespace raycube::cli {
namespace {

struct MeasureRequest {
  std::string file, name;
};

std::vector<scene::Measure> picked(const scene::Simulation& simulation, const std::string& name) {
  std::vector<scene::Measure> out;
  std::string known;
  for (const scene::Measure& one : simulation.measures) {
    if (name.empty() || one.name == name) out.push_back(one);
    known += (known.empty() ? "" : ", ") + one.name;
  }
  if (out.empty())
    throw base::Error(base::Fault::input,
                      simulation.file + (known.empty() ? ": no [[measure]] to take; add one"
                                                       : ": no measure is called '" + name + "'; there are: " + known));
  return out;
}

/// A measure's files, claimed before anything is traced: the table, and of each band of a plane what RAMI exchanges.
class MeasureFiles {
 public:
  MeasureFiles(const std::string& folder, base::IfExists if_exists, const scene::Simulation& simulation,
               const scene::Measure& measure)
      : files_(folder, if_exists) {
    if (measure.views != scene::MeasureViews::hemisphere)
      for (const scene::Band& band : run::measure_bands(simulation, measure)) {
        const std::string plane = measure.views == scene::MeasureViews::principal ? "brfpp" : "brfop",
                          of = fmt::format("_raycube-{}_band{}_{:.0f}nm.mes", measure.name, all_.size() + 1,
                                           1e3 * band.center_um);
        all_.push_back(&files_.add(plane + of)), multiple_.push_back(&files_.add(plane + "_mlt" + of));
      }
    table_ = &files_.add("measure.csv");
  }

  void write(const scene::Measure& measure, const run::MeasureResult& result, const scene::Sun& sun) {
    for (std::size_t b = 0; b < all_.size(); ++b) {
      all_[b]->append(run::measure_mes(result, sun, b, &run::ReflectanceFactor::all));
      multiple_[b]->append(run::measure_mes(result, sun, b, &run::ReflectanceFactor::multiple));
    }
    table_->append(run::measure_csv(measure, result));
    files_.publish();
  }

 private:
  base::OutputSet files_;
  std::vector<base::OutputFile*> all_, multiple_;
  base::OutputFile* table_ = nullptr;
};

int run(Invocation& invocation, const MeasureRequest& request) {
  run::Services services = services_of(invocation);
  scene::Simulation simulation = run::load_job(request.file, invocation.common.seed, services);
  const auto measures = picked(simulation, request.name);
  for (const scene::Measure& measure : measures) run::check_measure(simulation, measure);
  const render::RenderOptions options = render_options(invocation.common);
  render::Renderer renderer(simulation.scene, options);
  if (simulation.bounces < scene::kMostChosenBounces)
    services.log.warning(
        fmt::format("light between surfaces comes by {} at most after the first, as the file's "
                    "'bounces' has it; without it by {}",
                    simulation.bounces, scene::kMostChosenBounces));
  const std::string folder = invocation.common.output.empty() ? "measures" : invocation.common.output;
  nlohmann::ordered_json all = nlohmann::json::array();
  std::vector<std::unique_ptr<MeasureFiles>> files;
  for (const scene::Measure& measure : measures)
    files.push_back(
        std::make_unique<MeasureFiles>(folder + "/" + measure.name, if_exists(invocation.common), simulation, measure));
  for (std::size_t i = 0; i < measures.size(); ++i) {
    const scene::Measure& measure = measures[i];
    const run::MeasureResult result = run::measure(renderer, options, simulation, measure, services);
    files[i]->write(measure, result, simulation.sun);
    all.push_back(run::measure_json(measure, result));
    if (invocation.common.json) continue;
    for (std::size_t b = 0; b < result.albedo.size(); ++b)
      invocation.out << fmt::format("{}: {:.1f} nm: albedo {:.5f} +- {:.5f}\n", measure.name,
                                    1e3 * result.wavelength_um[b], result.albedo[b].all.mean,
                                    result.albedo[b].all.error);
    invocation.out << folder << "/" << measure.name << "/measure.csv\n";
  }
  if (invocation.common.json) invocation.out << all.dump(2) << "\n";
  return 0;
}

}  // namespace

Verb verb_measure() {
  auto o = std::make_shared<MeasureRequest>();
  Verb verb("measure", "Take the reflectance factors of an area towards many directions");
  verb.description =
      "Each [[measure]] of the file is taken under the sun alone, without air: what a level area of the scene sends "
      "in each direction over what an ideal white panel there would send, in the plane of the sun, across it, or over "
      "the hemisphere, whose mean is the albedo. Light between surfaces is in it and told apart; errors are standard "
      "errors of 16 batches. A scene with [scene] periodic has no edges.\n\n"
      "A folder for each measure gets measure.csv and, of a plane, a file for each band in the form in which the RAMI "
      "exercises exchange results (brfpp, brfop and their parts of multiple scattering).";
  verb.examples = {"raycube measure canopy.toml -o out", "raycube measure canopy.toml --name albedo --json"};
  verb.common = kOutput | kCompute;
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "A simulation file", o->file);
    table.text("--name", "NAME", "Only the measure of this name", o->name);
  };
  verb.run = [o](Invocation& invocation) { return run(invocation, *o); };
  return verb;
}

}  // namespace raycube::cli
