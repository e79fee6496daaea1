// `raycube measure`: reflectance factors of an area towards many directions, and where the light goes that falls onto
// it, without air.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>

#include "host/base/error.h"
#include "host/cli/services.h"
#include "host/cli/verb.h"
#include "host/run/input_check.h"
#include "host/run/light_budget.h"
#include "host/run/load_job.h"
#include "host/run/measure.h"

namespace raycube::cli {
namespace {

struct MeasureRequest {
  std::string file, name;
};

/// Leaves those of this name; all where it is empty.
template <class Entry>
void pick(const std::string& name, std::vector<Entry>& entries, std::string& known) {
  for (const Entry& one : entries) known += (known.empty() ? "" : ", ") + one.name;
  if (!name.empty()) std::erase_if(entries, [&](const Entry& one) { return one.name != name; });
}

/// Of the file's measures and budgets those that are asked for.
struct Picked {
  Picked(const scene::Simulation& simulation, const std::string& name)
      : measures(simulation.measures), budgets(simulation.budgets) {
    std::string known;
    pick(name, measures, known), pick(name, budgets, known);
    if (measures.empty() && budgets.empty())
      throw base::Error(
          base::Fault::input,
          simulation.file + (known.empty() ? ": no [[measure]] or [[budget]] to take; add one"
                                           : ": no measure or budget is called '" + name + "'; there are: " + known));
    run::Asked asked;
    for (const scene::Measure& measure : measures) asked.measures.push_back(&measure);
    for (const scene::LightBudget& budget : budgets) asked.budgets.push_back(&budget);
    run::check_inputs(simulation, asked);
  }
  std::vector<scene::Measure> measures;
  std::vector<scene::LightBudget> budgets;
};

/// Names of a folder's files that an earlier run may have left: they begin with one of `heads` and end with `tail`.
std::vector<std::string> earlier_files(const std::string& folder, std::initializer_list<std::string_view> heads,
                                       std::string_view tail) {
  std::vector<std::string> out;
  std::error_code none;  // no folder, no files
  for (const auto& entry : std::filesystem::directory_iterator(folder, none)) {
    const std::string name = entry.path().filename().string();
    const bool begins = std::any_of(heads.begin(), heads.end(), [&](auto head) { return name.starts_with(head); });
    if (begins && name.ends_with(tail)) out.push_back(name);
  }
  return out;
}

/// A measure's files, claimed before anything is traced: the table, and of each band of a plane what RAMI exchanges.
class MeasureFiles {
 public:
  MeasureFiles(const std::string& folder, base::IfExists if_exists, const scene::Simulation& simulation,
               const scene::Measure& measure)
      : files_(folder, if_exists) {
    if (if_exists == base::IfExists::replace) files_.replaces(earlier_files(folder, {"brfpp_", "brfop_"}, ".mes"));
    if (measure.views != scene::MeasureViews::hemisphere)
      for (const scene::Band& band : run::bands_of(simulation, measure.bands_of)) {
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

/// A budget's files, claimed before anything is traced: the table, and meshes with what their facets absorb.
class BudgetFiles {
 public:
  BudgetFiles(const std::string& folder, base::IfExists if_exists, const scene::LightBudget& budget)
      : files_(folder, if_exists) {
    if (if_exists == base::IfExists::replace) files_.replaces(earlier_files(folder, {"facets_"}, ".ply"));
    for (const std::string& mesh : budget.facets) facets_.push_back(&files_.add("facets_" + mesh + ".ply"));
    table_ = &files_.add("budget.csv");
  }
  const std::vector<base::OutputFile*>& facets() const { return facets_; }

  void write(const scene::LightBudget& budget, const run::BudgetResult& result) {
    run::write_budget(budget, result, *table_);
    files_.publish();
  }

 private:
  base::OutputSet files_;
  std::vector<base::OutputFile*> facets_;
  base::OutputFile* table_ = nullptr;
};

void tell(const scene::Measure& measure, const run::MeasureResult& result, std::ostream& out) {
  for (std::size_t b = 0; b < result.albedo.size(); ++b)
    out << fmt::format("{}: {:.1f} nm: albedo {:.5f} +- {:.5f}\n", measure.name, 1e3 * result.wavelength_um[b],
                       result.albedo[b].all.mean, result.albedo[b].all.error);
}

void tell(const scene::LightBudget& budget, const run::BudgetResult& result, std::ostream& out) {
  for (std::size_t b = 0; b < result.band.size(); ++b) {
    out << budget.name << ": " << result.band[b] << ":";
    for (const char* quantity : {"reflected", "canopy", "transmitted", "lost", "unfinished"}) {
      const run::Measured& share = result.of(quantity).band[b];
      const bool always = std::string_view(quantity) != "lost" && std::string_view(quantity) != "unfinished";
      if (always || share.mean > 0) out << fmt::format(" {} {:.5f} +- {:.5f}", quantity, share.mean, share.error);
    }
    out << "\n";
  }
}

int run(Invocation& invocation, const MeasureRequest& request) {
  run::Services services = services_of(invocation);
  scene::Simulation simulation = run::load_job(request.file, invocation.common.seed, services, invocation.common.set);
  const Picked picked(simulation, request.name);
  const render::RenderOptions options = render_options(invocation.common);
  if (!picked.measures.empty() && simulation.bounces < scene::kMostChosenBounces)
    services.log.warning(
        fmt::format("light between surfaces comes by {} at most after the first, as the file's "
                    "'bounces' has it; without it by {}",
                    simulation.bounces, scene::kMostChosenBounces));
  const std::string folder = invocation.common.output.empty() ? "measures" : invocation.common.output;
  const auto place = [&](const std::string& name) { return folder + "/" + name; };
  std::vector<std::unique_ptr<MeasureFiles>> measure_files;
  for (const scene::Measure& measure : picked.measures)
    measure_files.push_back(
        std::make_unique<MeasureFiles>(place(measure.name), if_exists(invocation.common), simulation, measure));
  std::vector<std::unique_ptr<BudgetFiles>> budget_files;
  for (const scene::LightBudget& budget : picked.budgets)
    budget_files.push_back(std::make_unique<BudgetFiles>(place(budget.name), if_exists(invocation.common), budget));

  nlohmann::ordered_json all = nlohmann::json::array();
  const auto told = [&](const auto& entry, const auto& result, const char* file, nlohmann::ordered_json json) {
    all.push_back(std::move(json));
    if (invocation.common.json) return;
    tell(entry, result, invocation.out);
    invocation.out << place(entry.name) << "/" << file << "\n";
  };
  std::optional<render::Renderer> renderer;
  if (!picked.measures.empty()) renderer.emplace(simulation.scene, options);
  for (std::size_t i = 0; i < picked.measures.size(); ++i) {
    const scene::Measure& measure = picked.measures[i];
    const run::MeasureResult result = run::measure(*renderer, options, simulation, measure, services);
    measure_files[i]->write(measure, result, simulation.sun);
    told(measure, result, "measure.csv", run::measure_json(measure, result));
  }
  renderer.reset();
  for (std::size_t i = 0; i < picked.budgets.size(); ++i) {
    const scene::LightBudget& budget = picked.budgets[i];
    const run::BudgetResult result =
        run::light_budget(options, simulation, budget, budget_files[i]->facets(), services);
    budget_files[i]->write(budget, result);
    told(budget, result, "budget.csv", run::budget_json(budget, result));
  }
  if (invocation.common.json) invocation.out << all.dump(2) << "\n";
  return 0;
}

}  // namespace

Verb verb_measure() {
  auto o = std::make_shared<MeasureRequest>();
  Verb verb("measure", "Take an area's reflectance factors, and where the light goes that falls onto it");
  verb.description =
      "Each [[measure]] of the file is taken under the sun alone, without air: what a level area of the scene sends "
      "in each direction over what an ideal white panel there would send, in the plane of the sun, across it, or over "
      "the hemisphere, whose mean is the albedo. Light between surfaces is in it and told apart; errors are standard "
      "errors of 16 batches. A scene with [scene] periodic has no edges.\n\n"
      "A folder for each measure gets measure.csv and, of a plane, a file for each band in the form in which the RAMI "
      "exercises exchange results (brfpp, brfop and their parts of multiple scattering).\n\n"
      "Each [[budget]] follows photons of the sun, or of light from all of the sky, that fall onto an area: which "
      "share "
      "is reflected, absorbed by each material, transmitted to the ground, goes down and up at any level, and is "
      "absorbed by each facet of a mesh. Its folder gets budget.csv and facets_MESH.ply.";
  verb.examples = {"raycube measure canopy.toml -o out", "raycube measure canopy.toml --name albedo --json"};
  verb.common = kOutput | kCompute | kSet;
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "A simulation file", o->file);
    table.text("--name", "NAME", "Only the measure or budget of this name", o->name);
  };
  verb.run = [o](Invocation& invocation) { return run(invocation, *o); };
  return verb;
}

}  // namespace raycube::cli
