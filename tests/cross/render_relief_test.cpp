// Mountains under a wide camera: the plan needs several nodes of height, view and path, and the device's
// weights between them are held against the reference's own (S18, S60, S61). Geometry: waves 400 m from
// valley to crest, 2 km long, camera at 3 km, 40 degrees across, 3 x 3 samples; clear sky, sun at 40 degrees.
// Limits are DESIGN section 7's for the same plan on both sides.
#include <doctest/doctest.h>

#include "atmos_tables/clear_sky.h"
#include "host/run/check_instrument.h"
#include "host/sensors/view_bounds.h"
#include "tests/oracle/reference_scene.h"
#include "tests/support/render_kit.h"
#include "tests/support/seeds.h"

using namespace raycube;

namespace {

scene::Simulation mountains() {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "scree", 0.25);
  scene::TriangleMesh mesh;
  for (const test::Triangle& t : test::terrain(30, 2, surface)) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const glm::vec3& p : {t.a, t.b, t.c}) mesh.vertices.push_back({p.x, p.y, p.z});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.surface.push_back(t.surface);
    mesh.user_face.push_back(first / 3);
  }
  const std::uint32_t waves = scene::append_mesh(simulation.scene, "waves", mesh);
  scene::append_instance(simulation.scene, waves, {100, 0, 0, 0, 0, 100, 0, 0, 0, 0, 100, 200}, 0);
  scene::finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 40, simulation.sun.azimuth_deg = 140;
  simulation.sky_directions = 128;
  simulation.seed = testing::seed(7);
  simulation.tolerance = 0.02;  // coarse nodes do: both sides interpolate between the same ones
  scene::Instrument camera = test::nadir_camera(12, 12, 3000, 3000 * 0.06);
  camera.samples_u = camera.samples_v = 3;
  camera.bands = test::gaussian_bands({0.42, 0.55, 0.76, 0.94}, 0.01);
  simulation.instruments = {camera};
  return simulation;
}

}  // namespace

TEST_CASE(
    "S18 S60 S61 mountains under a wide camera: several height, view and path nodes, device and reference "
    "agree") {
  const scene::Simulation simulation = mountains();
  const scene::Instrument& camera = simulation.instruments[0];
  const atmos::RenderTable table = atmos::build_clear_sky(
      simulation.atmosphere, simulation.sun, 3000, atmos::clear_sky_wavelengths(0.38, 1.0, 0.005),
      atmos::clear_sky_heights(static_cast<double>(simulation.scene.lo[2]),
                               static_cast<double>(simulation.scene.hi[2])));
  const plan::Plan plan = plan::make_plan(simulation, camera, table, sensors::view_bounds(camera));
  MESSAGE("nodes: height " << plan.height.count << ", view " << plan.view.count << ", path " << plan.path_x.count
                           << " x " << plan.path_y.count);
  REQUIRE(plan.height.count > 1);
  REQUIRE(plan.view.count > 1);
  REQUIRE(plan.path_x.count > 1);
  render::Renderer renderer(simulation.scene, {});
  run::CheckOptions options;
  options.pixels = 12 * 12;
  options.model_pixels = 0;
  const reference::Report report = run::check_instrument(renderer, simulation, camera, plan, table, options);
  MESSAGE(report.text({}));
  for (const std::string& failure : report.failures()) FAIL_CHECK(failure);
  CHECK(report.pixels == 144);
  CHECK(report.hit_miss == 0);
}
