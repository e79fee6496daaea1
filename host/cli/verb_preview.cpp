// raycube preview: a picture of a scene in seconds.
#include <chrono>
#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/timing.h"
#include "host/cli/services.h"
#include "host/cli/verb.h"
#include "host/run/load_job.h"
#include "host/run/preview.h"

namespace raycube::cli {

namespace {

struct PreviewRequest {
  std::string file, instrument;
  int samples = run::PreviewSettings().samples;
};

const scene::Instrument& camera_of(const scene::Simulation& simulation, const std::string& name, base::Log& log) {
  const auto cameras = run::pick_instruments(simulation, name);
  if (cameras.empty())
    throw base::Error(base::Fault::input,
                      simulation.file + ": " + (name.empty() ? "there is" : "'" + name + "' is") +
                          " no camera to preview but LIDARs; add a camera over the scene ([[instrument]] with "
                          "kind = \"framing\"), or render");
  if (cameras.size() > 1)
    log.info(fmt::format("preview of '{}', the first of {} cameras; --instrument names another", cameras[0]->name,
                         cameras.size()));
  return *cameras[0];
}

int preview(const PreviewRequest& options, Invocation& invocation) {
  run::Services services = services_of(invocation);
  const std::string path = invocation.common.output.empty() ? "preview.png" : invocation.common.output;
  base::IfExists if_exists = cli::if_exists(invocation.common);
  base::OutputFile(path, if_exists);  // refuses before the work what its end would refuse
  scene::Simulation simulation = run::load_job(options.file, invocation.common.seed, services, invocation.common.set);
  const scene::Instrument camera = camera_of(simulation, options.instrument, invocation.log);
  const auto start = std::chrono::steady_clock::now();
  render::Renderer renderer(simulation.scene, render_options(invocation.common));
  run::PreviewSettings settings;
  settings.samples = options.samples;
  run::PreviewState done;
  run::preview(renderer, simulation, camera, settings, services,
               [&](const run::PreviewState& state, const auto& write) {
                 base::OutputFile file(path, if_exists);
                 write(file);
                 file.publish();
                 if_exists = base::IfExists::replace;  // its own
                 done = state;
                 invocation.log.info(fmt::format("{}: {} x {} pixels, {} samples each, {:.1f} s", path, state.width,
                                                 state.height, state.samples, base::seconds_since(start)));
               });
  if (invocation.common.json)
    invocation.out << nlohmann::json{{"picture", path},     {"instrument", camera.name},
                                     {"width", done.width}, {"height", done.height},
                                     {"step", done.step},   {"samples_per_pixel", done.samples}}
                          .dump(2)
                   << "\n";
  else
    invocation.out << path << "\n";
  return 0;
}

}  // namespace

Verb verb_preview() {
  auto options = std::make_shared<PreviewRequest>();
  Verb verb("preview", "Show in seconds what a camera sees, and refine the picture while you watch");
  verb.description =
      "A PNG of the three bands that a quicklook shows (or of one), stretched from the 2nd to the 98th percentile: "
      "four samples a pixel at first, then twice as many again and again in the same file, which is whole at any time. "
      "Nothing is planned and no tolerance held: the clear sky stands in for the layered model where it knows the "
      "bands, light between ground and air is left out, and of an image of more than 2^18 pixels every n-th line and "
      "column is seen. Ctrl-C ends it; the last picture stays.";
  verb.examples = {"raycube preview park.toml",
                   "raycube preview park.toml --instrument spectir --samples 256 -o look.png"};
  verb.common = kOutput | kCompute | kSet;
  verb.output_default = "preview.png";
  verb.add_options = [options](base::OptionTable& table) {
    table.argument("FILE", "The simulation file (TOML)", options->file);
    table.text("--instrument", "NAME", "This camera instead of the first", options->instrument);
    table.integer("--samples", "N", 1, 65536, "Samples a pixel when it ends", options->samples);
  };
  verb.run = [options](Invocation& invocation) { return preview(*options, invocation); };
  return verb;
}

}  // namespace raycube::cli
