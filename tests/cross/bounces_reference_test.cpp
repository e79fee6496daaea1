// Light between surfaces of a wood against paths of another code: Embree, double, whole spectra, other draws.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "host/run/check_bounced.h"
#include "host/sensors/view_bounds.h"
#include "scene_compiler/spectral_shape.h"
#include "tests/support/chance_checks.h"
#include "tests/support/full.h"
#include "tests/support/render_kit.h"
#include "tests/support/skies.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace raycube;

constexpr int kPixels = 12;
const std::vector<double> kCentres = {0.45, 0.55, 0.67, 0.75, 0.86, 1.6};

/// From nodes of 20 nm, as the table of the air has them.
scene::Curve curve(const std::function<double(double)>& value) {
  scene::Curve out;
  for (int i = 0; i <= 120; ++i) {
    out.wavelength_um.push_back(0.3 + 0.02 * i);
    out.value.push_back(value(out.wavelength_um.back()));
  }
  return out;
}

double step(double l, double at, double width) { return 1 / (1 + std::exp((at - l) / width)); }

/// Eight crowns of leaves, turned, tilted and stretched, on rough or wet ground with a bright box among them; the
/// ground's shapes may change with wavelength. Glazed: half of it stands below a roof of two panes, one with gloss.
scene::Simulation wood(bool wet, bool changing, bool glazed) {
  scene::Simulation simulation;
  scene::CompiledScene& scene = simulation.scene;
  const auto ground = test::add_material(scene, "ground", 0.3), leaf = test::add_material(scene, "leaf", 0.4),
             wall = test::add_material(scene, "wall", 0.6);
  scene.materials[0].reflectance = curve([](double l) { return 0.1 + 0.15 * std::min(l, 1.5); });
  if (wet)
    scene.materials[0].gloss = {RC_SHAPE_gloss, {0.2, 0.4}};
  else
    scene.materials[0].front = {RC_SHAPE_oren_nayar, {30, 0}};
  if (changing) {  // with wavelength: what is rough in the blue is a bowl in the red
    scene.materials[0].front_nodes = {
        {0.5, scene.materials[0].front}, {0.7, {RC_SHAPE_oren_nayar, {60, 0}}}, {0.9, {RC_SHAPE_oren_nayar, {10, 0}}}};
    if (wet) scene.materials[0].gloss_nodes = {{0.5, scene.materials[0].gloss}, {0.8, {RC_SHAPE_gloss, {0.3, 0.1}}}};
  }
  scene.materials[1].reflectance = curve([](double l) { return 0.05 + 0.42 * step(l, 0.71, 0.015); });
  scene.materials[1].transmittance = curve([](double l) { return 0.03 + 0.40 * step(l, 0.71, 0.02); });
  scene.materials[2].reflectance = curve([](double l) { return 0.5 + 0.2 * std::sin(6 * l); });
  scene::make_lobes(scene.materials[0]);
  test::place(scene, test::rectangle({-60, -60, 0}, {120, 0, 0}, {0, 120, 0}, ground));
  test::place(scene, test::box({-1, -2, 0}, {2, 1, 3}, wall));
  scene::TriangleMesh crown = test::crown(600, 0.4, 2.2, 5);
  crown.surface.assign(crown.triangles.size(), leaf);
  const std::uint32_t tree = append_mesh(scene, "crown", crown);
  for (std::uint32_t i = 0; i < 8; ++i) {
    const double turn = 2 * std::numbers::pi * i / 8;
    append_instance(scene, tree,
                    test::placement(1.3 * i, 0.2 * (i % 3), 0.8 + 0.1 * (i % 4), 4.5 * std::cos(turn),
                                    4.5 * std::sin(turn), 2.5 + 0.3 * (i % 2)),
                    i + 2);
  }
  if (glazed) {
    const auto pane = test::add_material(scene, "pane", 0.08), lacquer = test::add_material(scene, "lacquer", 0.0);
    for (const auto number : {3, 4}) {
      auto& glass = scene.materials[number];
      glass.behind = {RC_SHAPE_plate};
      glass.transmittance = curve([&](double l) { return 0.6 + 0.2 * std::sin((number + 2) * l); });
    }
    scene.materials[4].gloss = {RC_SHAPE_gloss, {0.4, 0.06}};
    test::place(scene, test::rectangle({-1, -30, 6}, {-25, 0, -2}, {0, 60, 0}, pane));
    test::place(scene, test::rectangle({-1, -30, 6}, {4, 0, -1}, {0, 60, 0}, lacquer));
  }
  finish_top_tree(scene);
  simulation.seed = testing::seed(3);
  simulation.sky_directions = 128;
  simulation.tolerance = 0.01;
  simulation.sun.zenith_deg = 40, simulation.sun.azimuth_deg = 150;
  scene::Instrument camera = test::nadir_camera(kPixels, kPixels, 300, 1.0);
  camera.bands = test::gaussian_bands(kCentres, 0.02);
  camera.samples_u = camera.samples_v = 4;
  simulation.instruments = {camera};
  return simulation;
}

}  // namespace

TEST_CASE("S16 LIGHT 2: light between surfaces in a wood is that of another code's paths, band by band") {
  // As `raycube check` looks at it. Standard errors are of both sides' own scatter. Short: without what other cases
  // hold, and with fewer of the device's paths, of which sixteen draws leave hardly any of the error.
  const atmos::RenderTable air = test::clear_sky(40);
  struct Case {
    int levels;
    bool wet, changing, glazed, in_short;
  };
  for (const auto& [levels, wet, changing, glazed, in_short] : {Case{1, false, false, false, false},
                                                                {4, false, false, false, true},
                                                                {2, true, false, false, false},
                                                                {3, false, true, false, true},
                                                                {2, true, true, false, true},
                                                                {1, false, false, true, false},
                                                                {4, false, false, true, true},
                                                                {2, true, true, true, true}}) {
    if (!in_short && !testing::full()) continue;
    scene::Simulation simulation = wood(wet, changing, glazed);
    simulation.bounces = levels;
    if (wet || glazed) simulation.sky_directions = testing::full() ? 1024 : wet ? 256 : 128;
    if (levels == 3) simulation.sky_directions = 122;  // 61 paths: no whole fours
    CAPTURE(wet);
    CAPTURE(glazed);
    CAPTURE(changing);
    const scene::Instrument& camera = simulation.instruments[0];
    const plan::Plan plan = plan::make_plan(simulation, camera, air, sensors::view_bounds(camera));
    double worst = 0;
    for (const char* name : {"ground", "leaf", "wall"}) worst = std::max(worst, plan.bounces.material_error.at(name));
    if (!wet && !glazed) CHECK(worst == plan.bounces.error);  // else a gloss or a pane has an error of its own
    render::Renderer renderer(simulation.scene, {});
    const reference::BouncedReport report = run::check_bounced(renderer, simulation, camera, plan, {});
    MESSAGE(levels << " surfaces after the first, a skeleton of " << plan.bounces.skeleton.size() << ":"
                   << report.text());
    if (!glazed) {
      const reference::ReplayReport replayed = run::replay_paths(renderer, simulation, camera, plan, {});
      MESSAGE(replayed.text());
      for (const std::string& failure : replayed.failures()) FAIL_CHECK(failure);
      CHECK(replayed.pixels >= 32);
      CHECK(replayed.paths == replayed.pixels * static_cast<std::uint64_t>(plan.paths()));
      CHECK(replayed.steps > replayed.paths / 4);
      CHECK(replayed.worst > 0);
      CHECK(replayed.excluded_pixels == 0);
    }
    CHECK(report.pixels == kPixels * kPixels);
    REQUIRE(report.bands.size() == kCentres.size());
    for (const std::string& failure : report.failures()) FAIL_CHECK(failure);
    for (const auto& band : report.bands) {
      CAPTURE(band.device / band.reference);
      CHECK_WITHIN(band.device - band.reference, 4 * band.error + report.skeleton_error * band.size);
      CHECK(band.error <
            (wet || glazed ? 0.03 : 0.02) * band.reference);  // mirrored paths of the reference scatter more
    }
  }
}
