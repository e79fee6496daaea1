// raycube render: a simulation file to radiance cubes with truth.
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/text.h"
#include "host/cli/dry_run.h"
#include "host/cli/services.h"
#include "host/cli/verb.h"
#include "host/planner/plan_file.h"
#include "host/run/cube_products.h"
#include "host/run/forecast.h"
#include "host/run/input_check.h"
#include "host/run/laz.h"
#include "host/run/load_job.h"
#include "host/run/render_camera.h"
#include "host/run/render_lidar.h"
#include "host/base/timing.h"

namespace raycube::cli {

namespace {

struct RenderRequest {
  std::vector<std::string> files;
  std::string instrument, plan;
};

/// One of the files, and where its instruments' folders go.
struct RenderedFile {
  std::string file, folder;
};

/// What --json says of a cube that is whole.
nlohmann::json to_json(const run::CameraRun& done) {
  return {{"name", done.name},       {"folder", done.folder},         {"digest", done.digest},
          {"seconds", done.seconds}, {"rays_per_s", done.rays_per_s}, {"band_samples_per_s", done.band_samples_per_s},
          {"cube", done.cube}};
}

/// What it says of a survey.
nlohmann::json to_json(const run::LidarRun& done) {
  return {{"name", done.name},
          {"folder", done.folder},
          {"kind", "lidar"},
          {"digest", done.digest},
          {"pulses", done.pulses},
          {"returns", done.returns},
          {"seconds", done.seconds},
          {"pulses_per_s", done.pulses_per_s},
          {"worst_ledger_error", done.worst_ledger_error},
          {"main", done.main_file}};
}

std::vector<std::string> names_of(const std::vector<const scene::Instrument*>& instruments,
                                  const std::vector<const scene::Lidar*>& lidars) {
  std::vector<std::string> names;
  for (const auto* instrument : instruments) names.push_back(instrument->name);
  for (const auto* lidar : lidars) names.push_back(lidar->name);
  return names;
}

/// Of one instrument or LIDAR: what is printed of it, as JSON or for people.
struct Told {
  nlohmann::json json;
  std::string text;
};

/// What a run has done so far, for the message of an error that ends it.
struct Done {
  std::vector<std::string> names;    ///< of all its instruments, in order
  std::vector<std::string> folders;  ///< of those that are whole
  std::vector<Told> told;
};

/// One simulation file.
class Rendering {
 public:
  Rendering(const RenderedFile& what, const RenderRequest& options, Invocation& invocation, Done& done)
      : what_(what),
        options_(options),
        invocation_(invocation),
        done_(done),
        services_(services_of(invocation)),
        settings_(render_options(invocation.common)) {}

  void execute() {
    const auto start = std::chrono::steady_clock::now();
    const scene::Simulation simulation =
        run::load_job(what_.file, invocation_.common.seed, services_, invocation_.common.set);
    load_s_ = base::seconds_since(start);
    const auto instruments = run::pick_instruments(simulation, options_.instrument);
    const auto lidars = run::pick_lidars(simulation, options_.instrument);
    done_.names = names_of(instruments, lidars);
    if (!invocation_.common.dry_run)
      for (const auto& name : done_.names) run::check_output_place(folder_of(name), invocation_.common.overwrite);
    run::check_inputs(simulation, {.instruments = instruments, .lidars = lidars, .background = true});
    for (const auto* lidar : lidars)
      if (lidar->products.laz) run::laz_python();
    read_plan(instruments, lidars);
    render_cameras(simulation, instruments);
    planning_.renderer = nullptr;  // it went with the cameras
    for (const auto* lidar : lidars) render_one(simulation, *lidar);
  }

 private:
  std::string folder_of(const std::string& name) const { return (std::filesystem::path(what_.folder) / name).string(); }

  run::Destination destination_of(const std::string& name) const {
    return {folder_of(name), if_exists(invocation_.common), invocation_.command_line, load_s_};
  }

  void read_plan(const std::vector<const scene::Instrument*>& instruments,
                 const std::vector<const scene::Lidar*>& lidars) {
    if (options_.plan.empty()) return;
    replay_ = planner::read_plan_file(options_.plan);
    for (const auto* instrument : instruments) planner::find_entry(*replay_, instrument->name, false, options_.plan);
    for (const auto* lidar : lidars) planner::find_entry(*replay_, lidar->name, true, options_.plan);
    planning_.replay = &*replay_, planning_.replay_path = options_.plan;
  }

  void render_cameras(const scene::Simulation& simulation, const std::vector<const scene::Instrument*>& instruments) {
    std::optional<render::Renderer> renderer;
    for (const auto* instrument : instruments) {
      try {
        if (!renderer) renderer.emplace(simulation.scene, settings_);
      } catch (const base::Error& error) {
        if (error.fault() != base::Fault::device || !invocation_.common.dry_run) throw;
        services_.log.warning(
            std::string("the time cannot be estimated, nor the errors of samples and sky directions: ") + error.what());
      }
      render_one(simulation, *instrument, renderer ? &*renderer : nullptr);
    }
  }

  void render_one(const scene::Simulation& simulation, const scene::Instrument& instrument,
                  render::Renderer* renderer) {
    planning_.renderer = renderer;
    const run::CameraJob job = run::prepare_camera(simulation, instrument, services_, planning_);
    if (!invocation_.common.dry_run) {
      tell(run::render_camera(simulation, job, *renderer, settings_, destination_of(instrument.name), services_));
      return;
    }
    const std::size_t tile_samples = renderer ? renderer->tuning().tile_samples : render::kCpuTileSamples;
    const auto forecast = run::forecast_camera(simulation.scene, job, settings_, tile_samples);
    std::optional<double> estimated_s;
    if (renderer) estimated_s = run::estimate_render_s(*renderer, simulation, job);
    done_.told.push_back({dry_run_json(job, forecast, estimated_s), dry_run_text(job, forecast, estimated_s)});
  }

  void render_one(const scene::Simulation& simulation, const scene::Lidar& lidar) {
    if (!invocation_.common.dry_run) {
      tell(run::render_lidar(simulation, lidar, settings_, destination_of(lidar.name), services_, planning_));
      return;
    }
    const auto forecast = run::forecast_lidar(simulation, lidar, settings_, services_, planning_);
    done_.told.push_back({dry_run_json(lidar, forecast), dry_run_text(lidar, forecast)});
  }

  void tell(const run::CameraRun& whole) {
    done_.folders.push_back(whole.folder);
    done_.told.push_back({to_json(whole), whole.cube + "\n"});
  }
  void tell(const run::LidarRun& whole) {
    done_.folders.push_back(whole.folder);
    done_.told.push_back({to_json(whole), whole.main_file + "\n"});
  }

  const RenderedFile& what_;
  const RenderRequest& options_;
  Invocation& invocation_;
  Done& done_;
  run::Services services_;
  const render::RenderOptions settings_;
  double load_s_ = 0;  ///< that loading the scene took
  std::optional<planner::PlanFile> replay_;
  run::Planning planning_;
};

/// An error that comes after some instruments are whole says that they stay, and how to go on.
void render_and_keep(const RenderedFile& what, const RenderRequest& options, Invocation& invocation, Done& done) {
  try {
    Rendering(what, options, invocation, done).execute();
  } catch (const base::Error& error) {
    if (done.folders.empty() || done.folders.size() == done.names.size()) throw;
    std::string kept, rest;
    for (const auto& folder : done.folders) kept += (kept.empty() ? "" : ", ") + folder;
    for (std::size_t i = done.folders.size(); i < done.names.size(); ++i)
      rest += (rest.empty() ? "--instrument " : ", then --instrument ") + done.names[i];
    throw base::Error(error.fault(), std::string(error.what()) + "; whole and kept: " + kept + "; go on with " + rest);
  }
}

/// The files with their folders: of one the output folder, of several each its own in it, by the file's name.
std::vector<RenderedFile> files_of(const RenderRequest& options, const CommonOptions& common) {
  const std::filesystem::path out = common.output.empty() ? "out" : common.output;
  if (options.files.size() == 1) return {{options.files.front(), out.string()}};
  if (!options.plan.empty())
    throw base::Error(base::Fault::input, "--plan is of one simulation (found " +
                                              base::counted(options.files.size(), "file") +
                                              "); render each with its own");
  std::vector<RenderedFile> all;
  for (const std::string& file : options.files) {
    const std::string folder = (out / std::filesystem::path(file).stem()).string();
    for (const RenderedFile& other : all)
      if (other.folder == folder)
        throw base::Error(base::Fault::input, file + ": its products would go to " + folder + " as those of " +
                                                  other.file + "; rename one, or render them one by one");
    all.push_back({file, folder});
  }
  return all;
}

nlohmann::json instruments_json(const Done& done) {
  nlohmann::json all = nlohmann::json::array();
  for (const auto& one : done.told) all.push_back(one.json);
  return all;
}

/// One after the other; one that fails is told of, and the others are rendered all the same. The exit status is that of
/// the first that failed.
int render_files(const RenderRequest& options, Invocation& invocation) {
  const std::vector<RenderedFile> files = files_of(options, invocation.common);
  nlohmann::json all = nlohmann::json::array();
  int status = 0;
  for (const RenderedFile& what : files) {
    Done done;
    nlohmann::json said = {{"file", what.file}};
    try {
      render_and_keep(what, options, invocation, done);
    } catch (const base::Error& error) {
      if (files.size() == 1) throw;
      if (error.fault() == base::Fault::interrupted || base::interrupted_by_now()) {
        if (invocation.common.json) invocation.out << nlohmann::json{{"simulations", all}}.dump(2) << "\n";
        throw;
      }
      invocation.log.error(error.what());
      said["error"] = error.what();
      if (status == 0) status = error.exit_status();
    }
    said["instruments"] = instruments_json(done);
    all.push_back(std::move(said));
    if (!invocation.common.json)
      for (const auto& one : done.told) invocation.out << one.text;
  }
  if (invocation.common.json)
    invocation.out << (files.size() == 1 ? nlohmann::json{{"instruments", all[0]["instruments"]}}
                                         : nlohmann::json{{"simulations", all}})
                          .dump(2)
                   << "\n";
  return status;
}

}  // namespace

Verb verb_render() {
  auto options = std::make_shared<RenderRequest>();
  Verb verb("render", "Render the instruments of a simulation file into radiance cubes with truth");
  verb.description =
      "Each instrument gets a folder of its own under the output folder: radiance.img (ENVI), truth.img, "
      "location.img when the "
      "scene is georeferenced (with map info in every header when the pixels lie on a map grid), "
      "preview.exr, quicklook.png and run.json. Files appear under these names only when all of them are "
      "whole, and as one: `raycube info --verify` holds them against the hashes in run.json. Instruments "
      "that are whole stay when a later one fails.\n\nSamples, sky directions and sub-rays that the file "
      "does not give are chosen by the tolerance (see `raycube plan`); "
      "run.json holds every line of the plan.\n\nOf several files each gets a folder of its own in the output "
      "folder, named as the file without its ending; one that fails is told of and the others are rendered.\n\nThe "
      "result on stdout is the path of each cube, one a line.";
  verb.examples = {"raycube render park.toml -o out",
                   "raycube render park.toml --instrument spectir --memory 1G --overwrite",
                   "raycube render morning.toml noon.toml -o day"};
  verb.common = kOutput | kDryRun | kCompute | kSet;
  verb.output_default = "out";
  verb.add_options = [options](base::OptionTable& table) {
    table.arguments("FILE", "The simulation file (TOML), or several", options->files);
    table.text("--instrument", "NAME", "Only this instrument", options->instrument);
    table.text(
        "--plan", "FILE",
        "Settings that `raycube plan -o FILE` chose, instead of planning; of another scene they are a first guess",
        options->plan);
  };
  verb.run = [options](Invocation& invocation) { return render_files(*options, invocation); };
  return verb;
}

}  // namespace raycube::cli
