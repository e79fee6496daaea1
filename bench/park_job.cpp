#include "bench/park_job.h"

#include <filesystem>

#include "host/base/error.h"
#include "scene_compiler/load_simulation.h"

namespace raycube::bench {

scene::Simulation load_park(const Settings& settings) {
  if (!std::filesystem::exists(settings.park_file))
    throw base::Error(base::Fault::environment, "bench: no park at " + settings.park_file +
                                                    "; make it with bench/opaque_park.py " +
                                                    std::filesystem::path(settings.park_file).parent_path().string());
  scene::Simulation park = scene::load_simulation(settings.park_file);
  park.bounces = 0, park.bounces_given = true;  // figures of light scattered once, as those that they are held against
  return park;
}

run::CameraJob prepare_job(const scene::Simulation& simulation, const scene::Instrument& instrument) {
  base::Log log;
  run::Services services = run::watched_services(log);
  return run::prepare_camera(simulation, instrument, services);
}

std::string shell_quoted(const std::string& text) {
  std::string out = "'";
  for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace raycube::bench
