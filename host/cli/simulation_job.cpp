#include "host/cli/simulation_job.h"

#include <algorithm>
#include <chrono>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/rct_file.h"
#include "host/base/error.h"
#include "host/sensors/view_bounds.h"
#include "scene_compiler/load_simulation.h"

namespace raycube::cli {

namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Wavelengths a band's response reaches, um. A Gaussian is cut at 2.5 FWHM, where it has fallen to 3e-8.
std::pair<double, double> reach(const scene::Band& band) {
  if (band.fwhm_um > 0) return {band.center_um - 2.5 * band.fwhm_um, band.center_um + 2.5 * band.fwhm_um};
  return {band.wavelength_um.front(), band.wavelength_um.back()};
}

atmos::RenderTable make_table(const scene::Simulation& simulation, const scene::Instrument& instrument, double sensor_height_m) {
  const auto& spec = simulation.atmosphere;
  if (!spec.table_file.empty()) return atmos::read_rct(spec.table_file);
  double first = 1e9, last = 0;
  for (const auto& band : instrument.bands) {
    first = std::min(first, reach(band).first);
    last = std::max(last, reach(band).second);
  }
  const auto& scene = simulation.scene;
  const bool empty = scene.instances.empty();
  const double low = empty ? 0.0 : scene.lo[2], high = empty ? 0.0 : scene.hi[2];
  if (spec.none)
    return atmos::vacuum_table(simulation.sun, sensor_height_m, atmos::clear_sky_wavelengths(first, last), {low});
  return atmos::build_clear_sky(spec, simulation.sun, sensor_height_m, atmos::clear_sky_wavelengths(first, last),
                                atmos::clear_sky_heights(low, std::min(high, sensor_height_m)));
}

}  // namespace

scene::Simulation load_job(const std::string& file, Context& context) {
  scene::LoadOptions options;
  options.seed = context.common.seed;
  options.need_instruments = true;
  scene::Simulation simulation = scene::load_simulation(file, options);
  for (const auto& notice : simulation.notices) context.log.warning(notice);
  return simulation;
}

std::vector<const scene::Instrument*> pick_instruments(const scene::Simulation& simulation, const std::string& name) {
  std::vector<const scene::Instrument*> picked;
  std::string known;
  for (const auto& instrument : simulation.instruments) {
    if (name.empty() || instrument.name == name) picked.push_back(&instrument);
    known += (known.empty() ? "" : ", ") + instrument.name;
  }
  if (picked.empty())
    throw base::Error(base::Fault::input, simulation.file + ": no instrument is called '" + name + "'; there are: " + known);
  return picked;
}

InstrumentJob prepare(const scene::Simulation& simulation, const scene::Instrument& instrument, Context& context) {
  InstrumentJob job;
  job.instrument = &instrument;
  const plan::ViewBounds view = sensors::view_bounds(instrument);
  auto start = std::chrono::steady_clock::now();
  job.table = make_table(simulation, instrument, view.sensor_height_m);
  job.table_s = seconds_since(start);
  start = std::chrono::steady_clock::now();
  job.plan = plan::make_plan(simulation, instrument, job.table, view);
  job.plan_s = seconds_since(start);
  context.log.detail(instrument.name + ": atmosphere table in " + std::to_string(job.table_s) + " s, plan in " +
                     std::to_string(job.plan_s) + " s");
  context.log.debug(job.plan.report_json);
  return job;
}

render::RenderOptions render_options(const CommonOptions& common) {
  render::RenderOptions options;
  options.device = common.device;
  options.threads = common.threads;
  options.memory_bytes = common.memory_bytes;
  return options;
}

}  // namespace raycube::cli
