// A render called from another program, as docs/extending.md writes it: no command line, its own progress, its own
// stop.
#include <doctest/doctest.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "host/render/renderer.h"
#include "host/run/load_job.h"
#include "host/run/render_camera.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using raycube::testing::TestFolder;

namespace {

constexpr const char* kScene = R"(format = 1
sky_directions = 8
[atmosphere]
model = "none"
[time.sun]
zenith_deg = 30
azimuth_deg = 150
[[material]]
name = "grey"
reflectance = 0.5
[[plane]]
material = "grey"
size_m = [200, 200]
[[instrument]]
name = "camera"
kind = "framing"
position_m = [0, 0, 500]
pixels = 16
lines = 16
ifov_mrad = 0.5
samples = { grid = [2, 2] }
bands = { first_nm = 500, step_nm = 50, count = 3, fwhm_nm = 20 }
)";

struct Cancelled : std::runtime_error {
  Cancelled() : std::runtime_error("the window was closed") {}
};

/// Renders the first camera of `file` into `folder`.
run::CameraRun render_first(const std::string& file, const std::string& folder, run::Services& services) {
  const scene::Simulation simulation = run::load_job(file, {}, services);
  const scene::Instrument& instrument = *run::pick_instruments(simulation, "").at(0);
  const render::RenderOptions options;
  render::Renderer renderer(simulation.scene, options);
  const run::CameraJob job = run::prepare_camera(simulation, instrument, services);
  return run::render_camera(simulation, job, renderer, options,
                            {folder, base::IfExists::refuse, "a program of my own", 0}, services);
}

}  // namespace

TEST_CASE("S61 another program renders by the library, hears how far it is, and stops it by an exception of its own") {
  const TestFolder folder;
  folder.write("scene.toml", kScene);
  base::LogOptions quiet;
  quiet.verbosity = -2;
  base::Log log(quiet);
  run::Services services{.log = log};
  std::uint64_t told = 0;
  std::vector<std::string> steps;
  services.progress = [&](const std::string& what, std::uint64_t, const std::string&) {
    steps.push_back(what);
    return [&](std::uint64_t more) { told += more; };
  };
  const auto whole = render_first(folder / "scene.toml", folder / "cube", services);
  CHECK(whole.name == "camera");
  CHECK(std::filesystem::file_size(whole.cube) == 16 * 16 * 3 * sizeof(float));
  CHECK(std::filesystem::exists(folder / "cube/run.json"));
  CHECK(!steps.empty());
  CHECK(told >= 16 * 16);

  services.stop = [] { throw Cancelled(); };
  CHECK_THROWS_AS(render_first(folder / "scene.toml", folder / "stopped", services), Cancelled);
  CHECK(!std::filesystem::exists(folder / "stopped/run.json"));
}
