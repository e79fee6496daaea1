// `raycube explain`: what one pixel's radiance is the sum of.
#include <fmt/format.h>

#include <charconv>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <system_error>

#include "host/base/error.h"
#include "host/cli/services.h"
#include "host/cli/verb.h"
#include "host/products/radiance_unit.h"
#include "host/run/cube_products.h"
#include "host/run/explain_pixel.h"
#include "host/run/input_check.h"
#include "host/run/load_job.h"

namespace raycube::cli {
namespace {

using products::kRadianceUnit;

struct ExplainRequest {
  std::string file, instrument, pixel;
  std::optional<int> band;
};

struct PixelPlace {
  int sample = 0, line = 0;
};

PixelPlace pixel_place(const std::string& text, const scene::Instrument& instrument) {
  PixelPlace at;
  const char* const end = text.data() + text.size();
  const auto sample = std::from_chars(text.data(), end, at.sample);
  const bool comma = sample.ec == std::errc() && sample.ptr != end && *sample.ptr == ',';
  const auto line = comma ? std::from_chars(sample.ptr + 1, end, at.line) : sample;
  if (!comma || line.ec != std::errc() || line.ptr != end || at.sample < 0 || at.line < 0 ||
      at.sample >= instrument.pixels || at.line >= instrument.lines)
    throw base::Error(base::Fault::input,
                      fmt::format("--pixel: not a pixel of instrument '{}' (found '{}'); give SAMPLE,LINE, both from "
                                  "0, samples to {}, lines to {}",
                                  instrument.name, text, instrument.pixels - 1, instrument.lines - 1));
  return at;
}

const scene::Instrument& only_instrument(const scene::Simulation& simulation, const std::string& name) {
  const bool lidar = !name.empty() && !run::pick_lidars(simulation, name).empty();
  if (lidar || simulation.instruments.empty())
    throw base::Error(base::Fault::input,
                      "--instrument: " + (lidar ? "'" + name + "' is a LIDAR" : "the file has no camera") +
                          "; explain tells of cameras' pixels, name a camera");
  const auto found = run::pick_instruments(simulation, name);
  if (found.size() == 1 && !found.front()->focal_planes.empty())
    throw base::Error(base::Fault::input,
                      "--instrument: pixels of '" + found.front()->name +
                          "' share their samples by its focal planes, and have no light of their own "
                          "to explain; take focal_plane out, and the mean over a pixel is told");
  if (found.size() == 1) return *found.front();
  std::string names;
  for (const auto* one : found) names += (names.empty() ? "" : ", ") + one->name;
  throw base::Error(base::Fault::input, "--instrument: which is meant? The file has " + names + "; name one of them");
}

std::string name_of(const run::PixelPart& light) {
  using enum scene::BandTruth;
  const std::string of = light.material.empty() ? ""
                                                : (light.through ? " through "
                                                   : light.gloss ? " by the gloss of "
                                                                 : " on ") +
                                                      light.material;
  switch (light.kind) {
    case path:
      return "path: air before the scene";
    case ground_around:
      return "ground around, by the air";
    case sun:
      return "sun" + of;
    case sky:
      return fmt::format("sky {}{}", light.number, of);
    case thermal_sky:
      return fmt::format("thermal sky {}{}", light.number, of);
    case surroundings:
      return "warm surroundings" + of;
    case emission:
      return "emitted by " + light.material;
    default:
      break;
  }
  return fmt::format("between surfaces, order {}{}", light.number, light.and_more ? " and more" : "");
}

void print_budget(const run::PixelBudget& budget, const scene::Instrument& instrument, PixelPlace at,
                  const std::vector<int>& bands, std::ostream& out) {
  out << fmt::format("instrument {}, sample {}, line {}: radiance, {}\n{:34}", instrument.name, at.sample, at.line,
                     kRadianceUnit, "");
  for (const int band : bands)
    out << fmt::format("{:>26}", fmt::format("band {} ({:.1f} nm)", band + 1,
                                             1000 * instrument.bands[static_cast<std::size_t>(band)].center_um));
  const auto line = [&](const std::string& name, const auto& radiance, bool shares) {
    out << fmt::format("\n{:34}", name);
    for (const int band : bands) {
      const auto b = static_cast<std::size_t>(band);
      const double share = budget.sum[b] != 0 ? 100 * double{radiance[b]} / budget.sum[b] : 0;
      out << fmt::format("{:>17.6g}{:>9}", radiance[b], shares ? fmt::format("{:.2f} %", share) : "");
    }
  };
  for (const run::PixelPart& light : budget.light) line(name_of(light), light.radiance, true);
  line("sum", budget.sum, false);
  line("rendered", budget.rendered, false);
  out << fmt::format("\nsum and rendered differ by at most {:.1e} in any of {} bands\n", budget.worst_difference,
                     budget.sum.size());
}

nlohmann::ordered_json to_json(const run::PixelBudget& budget, const scene::Instrument& instrument, PixelPlace at) {
  nlohmann::ordered_json all = {{"instrument", instrument.name},
                                {"sample", at.sample},
                                {"line", at.line},
                                {"unit", kRadianceUnit},
                                {"wavelength_um", nlohmann::json::array()},
                                {"light", nlohmann::json::array()}};
  for (const auto& band : instrument.bands) all["wavelength_um"].push_back(band.center_um);
  for (const run::PixelPart& light : budget.light) {
    nlohmann::ordered_json one = {{"kind", scene::band_truth_entry(light.kind).name}};
    if (light.number > 0) one["number"] = light.number;
    if (light.and_more) one["and_more"] = true;
    if (!light.material.empty())
      one["material"] = light.material, one["through"] = light.through, one["gloss"] = light.gloss;
    one["radiance"] = light.radiance;
    all["light"].push_back(std::move(one));
  }
  all["sum"] = budget.sum;
  all["rendered"] = budget.rendered;
  all["worst_difference"] = budget.worst_difference;
  return all;
}

int run(Invocation& invocation, const ExplainRequest& request) {
  run::Services services = services_of(invocation);
  const scene::Simulation simulation =
      run::load_job(request.file, invocation.common.seed, services, invocation.common.set);
  const scene::Instrument& given = only_instrument(simulation, request.instrument);
  const PixelPlace at = pixel_place(request.pixel, given);
  const auto count = static_cast<int>(given.bands.size());
  if (request.band && *request.band > count)
    throw base::Error(base::Fault::input, fmt::format("--band: instrument '{}' has bands 1 to {} (found {})",
                                                      given.name, count, *request.band));
  run::check_inputs(simulation, {.instruments = {&given}});
  render::Renderer renderer(simulation.scene, render_options(invocation.common));
  run::Planning planning;
  planning.renderer = &renderer;
  const run::CameraJob job = run::prepare_camera(simulation, given, services, planning);
  const run::PixelBudget budget = run::explain_pixel(renderer, simulation, job, at.line, at.sample);
  if (invocation.common.json)
    invocation.out << to_json(budget, *job.instrument, at).dump(2) << "\n";
  else
    print_budget(budget, *job.instrument, at,
                 request.band ? std::vector<int>{*request.band - 1} : run::shown_bands(*job.instrument),
                 invocation.out);
  return 0;
}

}  // namespace

Verb verb_explain() {
  auto o = std::make_shared<ExplainRequest>();
  Verb verb("explain", "Say what a pixel's radiance is the sum of");
  verb.description =
      "One pixel is rendered as `render` renders it, with the same samples, and its radiance is told by where "
      "light came from and which material scattered it last: the sun, the skies by the plan's components (those beyond "
      "the first are differences of colour and may be negative), thermal light, light between surfaces by the number "
      "of surfaces that it met after the one that is seen (of thermal light what that differs from the warm "
      "surroundings', so that it may be negative), the air's own light, and what the air scatters in from the "
      "ground around. The terms sum to what `render` writes, to the rounding of floats.\n\n"
      "With --json all bands are told, else those of the quicklook or --band.";
  verb.examples = {"raycube explain park.toml --instrument spectir --pixel 120,80",
                   "raycube explain park.toml --instrument spectir --pixel 120,80 --band 60"};
  verb.common = kCompute | kSet;
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("FILE", "A simulation file", o->file);
    table.text("--instrument", "NAME", "Which instrument, where the file has several", o->instrument);
    table.text("--pixel", "SAMPLE,LINE", "The pixel: its place across and along the image, both from 0", o->pixel);
    table.integer<int>("--band", "", 1, 1000000, "Only this band, from 1", o->band);
  };
  verb.run = [o](Invocation& invocation) { return run(invocation, *o); };
  return verb;
}

}  // namespace raycube::cli
