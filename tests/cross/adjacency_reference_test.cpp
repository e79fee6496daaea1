// Light between ground and air on the device against the reference (S4.9, S61): relief of several materials with trees
// of spheres, a wide camera, so that height and view get several nodes and the environment many; the clear sky with
// rows for S, T_dif and t of a hazy air. Limits are DESIGN section 7's; the model's are the simulation's tolerance.
#include <doctest/doctest.h>

#include "atmos_tables/clear_sky.h"
#include "host/run/check_instrument.h"
#include "host/sensors/view_bounds.h"
#include "tests/support/render_kit.h"
#include "tests/support/seeds.h"
#include "tests/support/test_scenes.h"

using namespace raycube;

namespace {

scene::Simulation patches() {
  scene::Simulation simulation;
  auto& scene = simulation.scene;
  std::vector<std::uint32_t> material;
  for (const double r : {0.03, 0.1, 0.25, 0.5, 0.8})
    material.push_back(test::add_material(scene, "m" + std::to_string(material.size()), r));
  shared::Surface mixture{};
  mixture.material[0] = 2, mixture.material[1] = 5;
  mixture.fraction[0] = 0.25f, mixture.fraction[1] = 0.75f;
  scene.surfaces.push_back(mixture);
  auto ground = test::terrain(60, 600);
  for (std::size_t t = 0; t < ground.surface.size(); ++t) {  // fields of about 100 m, one side of the land darker
    const auto& v = ground.vertices[ground.triangles[t][0]];
    const auto field = static_cast<std::uint32_t>(std::floor(v[0] / 100) * 7 + std::floor(v[1] / 100) * 3 + 1000);
    ground.surface[t] = v[0] < 0 ? field % 2 : 2 + field % 4;
  }
  const auto land = append_mesh(scene, "land", ground);
  append_instance(scene, land, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 8, 0}, 0);
  auto ball = test::sphere(2, 6, 0.1);
  std::fill(ball.surface.begin(), ball.surface.end(), material[3]);
  const auto tree = append_mesh(scene, "tree", ball);
  for (std::uint32_t i = 0; i < 60; ++i)
    append_instance(
        scene, tree,
        test::placement(0, 0, 1, 400 * test::unit_random(1, i, 0) - 200, 400 * test::unit_random(1, i, 1) - 200, 12),
        i + 1);
  finish_top_tree(scene);
  simulation.sun.zenith_deg = 50, simulation.sun.azimuth_deg = 140;
  simulation.seed = testing::seed(7);
  simulation.sky_directions = 4096;  // trees hide much of the sky: fewer leave noise, the sky's own
  scene::Instrument camera = test::nadir_camera(16, 16, 800, 30);
  camera.samples_u = camera.samples_v = 5;
  camera.bands = test::gaussian_bands({0.42, 0.55, 0.66, 0.87}, 0.01);
  simulation.instruments = {camera};
  return simulation;
}

}  // namespace

TEST_CASE(
    "S4.9 S61 light between ground and air: device and reference agree on every band; map and table within tolerance") {
  scene::Simulation simulation = patches();
  const scene::Instrument& camera = simulation.instruments[0];
  atmos::RenderTable table = atmos::build_clear_sky(
      simulation.atmosphere, simulation.sun, 800, atmos::clear_sky_wavelengths(0.38, 0.95, 0.005),
      atmos::clear_sky_heights(simulation.scene.lo[2], simulation.scene.hi[2]));
  test::add_ground_coupling(table);
  render::Renderer renderer(simulation.scene, {});
  for (const auto mode : {scene::Adjacency::local, scene::Adjacency::mean}) {
    simulation.atmosphere.adjacency = mode;
    const plan::Plan plan = plan::make_plan(simulation, camera, table, sensors::view_bounds(camera));
    MESSAGE("nodes: height " << plan.height.count << ", view " << plan.view.count << ", environment "
                             << plan.environment.columns << " x " << plan.environment.rows);
    REQUIRE(plan.height.count > 1);
    CHECK((plan.environment.nodes() > 100) == (mode == scene::Adjacency::local));
    run::CheckOptions options;
    options.pixels = 16 * 16;
    options.model_pixels = 32;
    const reference::Report report = run::check_instrument(renderer, simulation, camera, plan, table, options);
    MESSAGE(report.text({}));
    for (const std::string& failure : report.failures()) FAIL_CHECK(failure);
    CHECK(report.pixels == 256);
    CHECK(report.adjacency);
    CHECK(report.model_environment.figure < 0.003);
    CHECK(report.model_environment.figure > 0);
    CHECK(report.text({}).find("ground around") != std::string::npos);
    CHECK(report.json().find("\"environment\"") != std::string::npos);
  }
}
