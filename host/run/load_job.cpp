#include "host/run/load_job.h"

#include <algorithm>

#include "atmos_tables/clear_sky_inputs.h"
#include "host/base/error.h"
#include "host/run/air_table.h"
#include "host/run/air_limits.h"
#include "scene_compiler/load_simulation.h"

namespace raycube::run {

scene::Simulation load_job(const std::string& file, std::optional<std::uint64_t> seed, Services& services,
                           const std::vector<std::string>& overrides) {
  scene::LoadOptions options;
  options.seed = seed;
  options.need_instruments = true, options.overrides = overrides;
  services.log.set_status("loading " + file);
  scene::Simulation simulation = scene::load_simulation(file, options);
  services.log.set_status("");
  keep_within_air(simulation);
  for (const auto& notice : simulation.notices) services.log.warning(notice);
  for (const auto& instrument : simulation.instruments)
    for (const auto& notice : light_notices(simulation, instrument))
      services.log.warning(instrument.name + ": " + notice);
  for (const auto& lidar : simulation.lidars)
    for (const auto& notice : light_notices(simulation, lidar)) services.log.warning(lidar.name + ": " + notice);
  return simulation;
}

std::vector<std::string> light_notices(const scene::Simulation& simulation, const scene::Instrument& instrument) {
  if (instrument.bands.empty()) return {};
  const auto notice = atmos::no_light_notice(simulation.atmosphere, simulation.sun, band_range(instrument.bands).first);
  return notice ? std::vector{*notice} : std::vector<std::string>{};
}

std::vector<std::string> light_notices(const scene::Simulation& simulation, const scene::Lidar& lidar) {
  if (!lidar.detector.solar_background || lidar.pulse.lines.empty()) return {};
  double first_um = lidar.pulse.lines[0].wavelength_um;
  for (const auto& line : lidar.pulse.lines) first_um = std::min(first_um, line.wavelength_um);
  const auto notice = atmos::no_light_notice(simulation.atmosphere, simulation.sun, first_um);
  return notice ? std::vector{"the background of scene and sky (solar_background): " + *notice}
                : std::vector<std::string>{};
}

std::vector<const scene::Instrument*> pick_instruments(const scene::Simulation& simulation, const std::string& name) {
  std::vector<const scene::Instrument*> picked;
  std::string known;
  for (const auto& instrument : simulation.instruments) {
    if (name.empty() || instrument.name == name) picked.push_back(&instrument);
    known += (known.empty() ? "" : ", ") + instrument.name;
  }
  bool lidar = name.empty() && !simulation.lidars.empty();
  for (const auto& one : simulation.lidars) {
    lidar = lidar || one.name == name;
    known += (known.empty() ? "" : ", ") + one.name;
  }
  if (picked.empty() && !lidar)
    throw base::Error(base::Fault::input,
                      simulation.file + ": no instrument is called '" + name + "'; there are: " + known);
  return picked;
}

std::vector<const scene::Lidar*> pick_lidars(const scene::Simulation& simulation, const std::string& name) {
  std::vector<const scene::Lidar*> picked;
  for (const auto& lidar : simulation.lidars)
    if (name.empty() || lidar.name == name) picked.push_back(&lidar);
  return picked;
}

}  // namespace raycube::run
