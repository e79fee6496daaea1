// What the planner measures of nodes and sky components against the whole tables, held against the device rendering
// coarse and fine plans (S60, S61).
#include <doctest/doctest.h>

#include <cmath>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/synthetic.h"
#include "host/base/error.h"
#include "host/planner/model_trial.h"
#include "host/planner/planner.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"
#include "tests/support/test_scenes.h"

using namespace raycube;
using namespace raycube::planner;

namespace {

/// Hills of one material with sixty balls 12 m up, seen from 800 m by 64 x 8 pixels of 7 m: 16 degrees to either side.
scene::Simulation balls_on_hills() {
  scene::Simulation simulation;
  auto& scene = simulation.scene;
  const auto soil = test::add_material(scene, "soil", 0.2), leaf = test::add_material(scene, "leaf", 0.4);
  auto ground = test::terrain(40, 600);
  std::fill(ground.surface.begin(), ground.surface.end(), soil);
  append_instance(scene, append_mesh(scene, "land", ground), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 8, 0}, 0);
  auto ball = test::sphere(2, 6, 0.1);
  std::fill(ball.surface.begin(), ball.surface.end(), leaf);
  const auto tree = append_mesh(scene, "tree", ball);
  for (std::uint32_t i = 0; i < 60; ++i)
    append_instance(
        scene, tree,
        test::placement(0, 0, 1, 400 * test::unit_random(1, i, 0) - 200, 60 * test::unit_random(1, i, 1) - 30, 12),
        i + 1);
  finish_top_tree(scene);
  simulation.sun.zenith_deg = 50, simulation.sun.azimuth_deg = 140;
  simulation.seed = testing::seed(7);
  simulation.sky_directions = 512;
  scene::Instrument camera = test::nadir_camera(64, 8, 800, 7);
  camera.samples_u = camera.samples_v = 3;
  camera.bands = test::gaussian_bands({0.42, 0.55, 0.66, 0.87}, 0.01);
  simulation.instruments = {camera};
  return simulation;
}

atmos::RenderTable clear_sky(const scene::Simulation& simulation) {
  return atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 800,
                                atmos::clear_sky_wavelengths(0.38, 0.95, 0.005),
                                atmos::clear_sky_heights(simulation.scene.lo[2], simulation.scene.hi[2]));
}

std::vector<float> image_of(render::Renderer& renderer, const scene::Simulation& simulation, const plan::Plan& plan) {
  std::vector<float> out;
  renderer.probe(
      simulation.instruments[0], plan, simulation.sun, simulation.seed, {{0, 8, 0, 64}},
      [&](const render::PixelProbe& probe) { out.insert(out.end(), probe.radiance.begin(), probe.radiance.end()); });
  return out;
}

/// rms over pixels of the difference over the mean, worst band.
double difference(const std::vector<float>& image, const std::vector<float>& truth, std::size_t bands) {
  double worst = 0;
  for (std::size_t b = 0; b < bands; ++b) {
    double squares = 0, mean = 0;
    for (std::size_t k = b; k < image.size(); k += bands)
      squares += std::pow(double{image[k]} - double{truth[k]}, 2), mean += double{truth[k]};
    const auto pixels = static_cast<double>(image.size() / bands);
    worst = std::max(worst, std::sqrt(squares / pixels) / (mean / pixels));
  }
  return worst;
}

}  // namespace

TEST_CASE("S60: under a uniform sky one component and one node are exact, whatever hides it") {
  scene::Simulation simulation = balls_on_hills();
  simulation.sun.zenith_deg = 120;
  const scene::Instrument& camera = simulation.instruments[0];
  const auto table = atmos::uniform_sky_table(0, 1, {0.3, 1.0, 4.0}, 120);
  const plan::Plan plan = plan::make_plan(simulation, camera, table, sensors::view_bounds(camera));
  const ModelError error = model_error(simulation, camera, plan, table);
  CHECK(error.pixels == 128);
  CHECK(error.total.bound < 3e-6);  // the weights' floats
}

TEST_CASE(
    "S60 S61: what coarse nodes and few components are off by, as a device says that renders them and finer ones") {
  scene::Simulation simulation = balls_on_hills();
  const scene::Instrument& camera = simulation.instruments[0];
  const auto table = clear_sky(simulation);
  const auto view = sensors::view_bounds(camera);
  render::Renderer renderer(simulation.scene, {});
  simulation.tolerance = 1e-4;
  simulation.plan.sky_rank = 4, simulation.plan.height_nodes = 2, simulation.plan.view_nodes = 3,
  simulation.plan.path_nodes = 4;
  const plan::Plan fine = plan::make_plan(simulation, camera, table, view);
  const ModelError finest = model_error(simulation, camera, fine, table);
  MESSAGE("fine: " << finest.total.estimate << ", sky " << finest.sky.estimate << ", path " << finest.path.estimate
                   << ", sun " << finest.sun.estimate);
  const std::vector<float> truth = image_of(renderer, simulation, fine);
  struct Case {
    const char* what;
    scene::PlanOverrides given;
  };
  scene::PlanOverrides view_nodes = simulation.plan, path_nodes = simulation.plan, components = simulation.plan;
  view_nodes.view_nodes = 1, path_nodes.path_nodes = 1, components.sky_rank = 1;
  for (const Case& coarse : {Case{"view", view_nodes}, {"path", path_nodes}, {"components", components}}) {
    simulation.plan = coarse.given;
    const plan::Plan plan = plan::make_plan(simulation, camera, table, view);
    const ModelError measured = model_error(simulation, camera, plan, table);
    const double device = difference(image_of(renderer, simulation, plan), truth, camera.bands.size());
    CAPTURE(coarse.what);
    MESSAGE(coarse.what << ": measured " << measured.total.estimate << " (at most " << measured.total.bound
                        << "), device " << device);
    REQUIRE(device > 1.8 * finest.total.estimate);
    // 128 of 512 pixels: two standard errors of their mean square. The fine plan's own error, of other parts, adds its
    // square.
    const double room = 2 * (measured.total.bound - measured.total.estimate) +
                        finest.total.estimate * finest.total.estimate / (2 * device);
    CHECK_WITHIN(measured.total.estimate - device, room);
    CHECK_BELOW(room, 0.3 * device);
    // The parts name the culprit.
    const double part = coarse.what == std::string("path")         ? measured.path.estimate
                        : coarse.what == std::string("components") ? measured.sky.estimate
                                                                   : measured.sun.estimate;
    CHECK_ABOVE(part, 0.5 * measured.total.estimate);
    CHECK(model_error(simulation, camera, plan, table, 1).total.bound == measured.total.bound);
  }
}

TEST_CASE("S60: a plan whose estimate is past the tolerance is held to what it is on this scene") {
  scene::Simulation simulation = balls_on_hills();
  const scene::Instrument& camera = simulation.instruments[0];
  const auto table = clear_sky(simulation);
  simulation.tolerance = 1e-6;
  plan::Plan plan = plan::make_plan(simulation, camera, table, sensors::view_bounds(camera));
  REQUIRE(plan.refusal.find("cannot hold the tolerance of 1e-06") != std::string::npos);
  Decision decision = as_given(simulation, camera, plan);
  try {
    hold_tolerance(decision, simulation, camera, plan, table);
    FAIL_CHECK("not refused");
  } catch (const base::Error& error) {
    CHECK(error.fault() == base::Fault::input);
    CHECK(std::string(error.what()).find("raise the tolerance") != std::string::npos);
  }
  const double estimate = decision.plan_estimate, measured = decision.plan_error;
  MESSAGE("estimate " << estimate << ", measured " << measured);
  REQUIRE(measured < 0.8 * estimate);
  simulation.tolerance = 0.5 * (estimate + measured);
  Decision held = as_given(simulation, camera, plan);  // the same nodes: the finest there are
  hold_tolerance(held, simulation, camera, plan, table);
  // What is refused was looked at twice, the second time in as many directions as `check` looks in.
  CHECK(held.plan_error == model_error(simulation, camera, plan, table).total.bound);
  CHECK(measured == model_error(simulation, camera, plan, table, 0, 1024).total.bound);
  CHECK(held.model_pixels == 128);
}
