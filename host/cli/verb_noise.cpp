// `raycube noise`: what an instrument's detector would have measured of a stored cube.
#include <cmath>
#include <memory>
#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/cli/analyze_kit.h"
#include "host/cli/services.h"
#include "host/cli/verb.h"
#include "host/products/radiance_unit.h"
#include "host/run/camera_job.h"
#include "host/run/load_job.h"
#include "host/run/measured_cube.h"

namespace raycube::cli {
namespace {

struct NoiseRequest {
  std::string cube, file, instrument;
};

/// The one instrument with a detector that is asked for.
const scene::Instrument& pick(const scene::Simulation& simulation, const std::string& name) {
  const scene::Instrument* found = nullptr;
  for (const scene::Instrument& one : simulation.instruments) {
    if (!one.detector || (!name.empty() && one.name != name)) continue;
    if (found)
      throw base::Error(base::Fault::input, simulation.file +
                                                ": several instruments have a detector; name one "
                                                "(--instrument)");
    found = &one;
  }
  if (!found)
    throw base::Error(base::Fault::input,
                      simulation.file + (name.empty() ? ": no instrument has a [instrument.detector]"
                                                      : ": no instrument '" + name + "' with a [instrument.detector]"));
  return *found;
}

/// Whether the cube is one that the instrument takes.
void check_fits(const products::EnviHeader& h, const scene::Instrument& instrument, const std::string& path) {
  if (h.samples != instrument.pixels || h.lines != instrument.lines ||
      h.bands != static_cast<std::int64_t>(instrument.bands.size()))
    throw base::Error(
        base::Fault::input,
        fmt::format("{}: has {} samples x {} lines x {} bands, instrument '{}' {} x {} x {}; they must be "
                    "the same",
                    path, h.samples, h.lines, h.bands, instrument.name, instrument.pixels, instrument.lines,
                    instrument.bands.size()));
  const std::vector<double> um = h.wavelength_um();
  for (std::size_t b = 0; b < um.size(); ++b)
    if (std::abs(um[b] - instrument.bands[b].center_um) > 1e-3 * instrument.bands[b].center_um)
      throw base::Error(base::Fault::input,
                        fmt::format("{}: band {} lies at {:g} nm, that of instrument '{}' at {:g} nm", path, b + 1,
                                    1e3 * um[b], instrument.name, 1e3 * instrument.bands[b].center_um));
}

/// Our unit of radiance over the cube's, which is refused where it is none and taken for ours, with a warning, where
/// the header names none.
double radiance_per_unit(const products::EnviHeader& header, const std::string& path, run::Services& services) {
  if (header.data_units.empty()) {
    services.log.warning(path + ": its header names no data units; they are taken as " + products::kRadianceUnit);
    return 1;
  }
  const auto factor = products::radiance_of(header.data_units);
  if (!factor)
    throw base::Error(base::Fault::input, fmt::format("{}: its data units are no radiance by wavelength (found '{}'); "
                                                      "correct 'data units' in its header, like {}",
                                                      path, header.data_units, products::kRadianceUnit));
  return *factor;
}

int noise(const NoiseRequest& request, Invocation& invocation) {
  run::Services services = services_of(invocation);
  const scene::Simulation simulation =
      run::load_job(request.file, invocation.common.seed, services, invocation.common.set);
  const scene::Instrument& instrument = pick(simulation, request.instrument);
  check_fits(products::read_envi_header(products::find_envi_pair(request.cube).header), instrument, request.cube);
  const analysis::Cube cube =
      open_cube(invocation, request.cube, {"1:" + std::to_string(instrument.bands.size()), ""});  // bad ones too
  base::OutputSet set(invocation.common.output.empty() ? "noise" : invocation.common.output,
                      if_exists(invocation.common));
  if (invocation.common.overwrite) set.replaces({"measured.img", "measured.hdr", "detector.csv", "bad_elements.csv"});
  const double factor = radiance_per_unit(cube.header(), request.cube, services);
  const auto read = [&](std::int64_t first, std::int64_t lines, float* to) {
    analysis::Pixels pixels;
    cube.read(first, lines, pixels);
    for (std::size_t p = 0; p < pixels.count(); ++p)
      for (std::size_t b = 0; b < pixels.bands; ++b)
        to[p * pixels.bands + b] = pixels.counts[p] ? static_cast<float>(factor * pixels.at(p)[b]) : NAN;
  };
  products::EnviHeader header = cube.header();
  header.data_units = products::kRadianceUnit;
  header.header_offset = 0, header.data_gain.clear(), header.data_offset.clear(), header.warnings.clear();
  header.data_ignore_value.reset(), header.reflectance_scale_factor.reset();
  if (!header.wavelength.empty() && header.wavelength_um().empty()) header.wavelength.clear(), header.fwhm.clear();
  if (!header.wavelength.empty()) {
    header.wavelength = header.wavelength_um();
    if (!header.fwhm.empty()) header.fwhm = header.fwhm_um();
    header.wavelength_units = "Micrometers";
  }
  const run::MeasuredCube measured = run::measure_cube(instrument, simulation.seed, read, header, set, services);
  set.publish();
  if (measured.saturated > 0) services.log.warning(measured.warning());
  nlohmann::ordered_json out = {
      {"folder", set.folder()}, {"saturated", measured.saturated}, {"values", measured.values}};
  for (const auto& [name, what] : measured.files) out["files"].push_back(name);
  if (invocation.common.json)
    invocation.out << out.dump(2) << "\n";
  else
    for (const auto& [name, what] : measured.files)
      invocation.out << set.folder() << "/" << name << ": " << what << "\n";
  return 0;
}

}  // namespace

Verb verb_noise() {
  auto o = std::make_shared<NoiseRequest>();
  Verb verb("noise", "Make of a cube of radiance what an instrument's detector measures");
  verb.description =
      "The [instrument.detector] of FILE over a cube that is there: shot noise, dark current, reading, fixed pattern, "
      "bad elements, saturation, digital numbers. A render of FILE leaves the same measured.img, to the bit, for the "
      "same radiance and seed. detector.csv has each band's electrons per radiance, noise and calibration; digital "
      "numbers have the calibration as the header's gains and offsets too. Equations: docs/sensors.md.";
  verb.examples = {"raycube noise out/camera/radiance.img scene.toml --instrument camera --seed 7 -o noisy"};
  verb.common = kOutput | kSeed | kThreads | kSet;
  verb.output_default = "noise";
  verb.add_options = [o](base::OptionTable& table) {
    table.argument("CUBE", "A cube of radiance, in the data units of its header: its data file or its header", o->cube);
    table.argument("FILE", "The simulation file whose instrument has the detector", o->file);
    table.text("--instrument", "NAME", "Which of its instruments", o->instrument).default_text =
        "the one that has a detector";
  };
  verb.run = [o](Invocation& invocation) { return noise(*o, invocation); };
  return verb;
}

}  // namespace raycube::cli
