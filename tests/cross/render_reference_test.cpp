// The whole chain on the device against the reference (S60, S61): what `raycube check` does, on a small scene that has
// every kind of trouble at once. Geometry: rolling terrain, a box, leaf clouds placed with turn, tilt and scale; clear
// sky, sun at 50 degrees; framing camera at 600 m, 5 x 5 samples. Limits are DESIGN section 7's.
#include <doctest/doctest.h>

#include <set>

#include "atmos_tables/clear_sky.h"
#include "host/run/check_instrument.h"
#include "host/sensors/view_bounds.h"
#include "scene_compiler/bvh_builder.h"
#include "tests/oracle/reference_scene.h"
#include "tests/support/seeds.h"

using namespace raycube;
using namespace raycube::test;

namespace {

scene::TriangleMesh mesh_of(const std::vector<Triangle>& triangles) {
  scene::TriangleMesh mesh;
  for (const Triangle& t : triangles) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const glm::vec3& p : {t.a, t.b, t.c}) mesh.vertices.push_back({p.x, p.y, p.z});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.surface.push_back(t.surface);
    mesh.user_face.push_back(first / 3);
  }
  return mesh;
}

scene::Simulation small_park() {
  scene::Simulation simulation;
  scene::CompiledScene& scene = simulation.scene;
  SceneBuilder materials;
  materials.material("grass", {0.3, 0.5, 0.7, 0.72, 0.9, 1.2}, {0.03, 0.06, 0.05, 0.3, 0.5, 0.45});
  materials.material("roof", {0.3, 1.2}, {0.3, 0.3});
  materials.material("leaf", {0.3, 0.5, 0.7, 0.72, 0.9, 1.2}, {0.02, 0.05, 0.04, 0.25, 0.45, 0.4});
  scene.materials = materials.scene.materials;
  scene.surfaces = materials.scene.surfaces;
  shared::Surface mixed{};
  mixed.material[0] = 1, mixed.material[1] = 2;
  mixed.fraction[0] = 0.6f, mixed.fraction[1] = 0.4f;
  scene.surfaces.push_back(mixed);
  std::vector<Triangle> ground = terrain(30, 2, 0);
  for (std::size_t i = 0; i < ground.size(); i += 7) ground[i].surface = 3;
  add_box(ground, {-6, -6, -2}, {0, 2, 6}, 1);
  const std::uint32_t base = scene::append_mesh(scene, "ground", mesh_of(ground));
  std::mt19937 random(23);
  std::uniform_real_distribution<float> u(-1, 1);
  std::vector<Triangle> leaves;
  for (int i = 0; i < 1500; ++i) {
    float v[9];
    for (float& x : v) x = u(random);
    const glm::vec3 p(2 * v[0], 2 * v[1], 3 + 2 * v[2]);
    leaves.push_back({p, p + 0.2f * glm::vec3(v[3], v[4], v[5]), p + 0.2f * glm::vec3(v[6], v[7], v[8]), 2});
  }
  const std::uint32_t tree = scene::append_mesh(scene, "tree", mesh_of(leaves));
  scene::append_instance(scene, base, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, 0);
  for (int i = 0; i < 12; ++i) {
    const glm::dmat3 m = rotation(0.7 * i, 0.05 * i, 0.7 + 0.05 * i);
    scene::append_instance(scene, tree,
                           {m[0][0], m[1][0], m[2][0], 6.0 * (i % 4) - 9, m[0][1], m[1][1], m[2][1], 7.0 * (i / 4) - 8,
                            m[0][2], m[1][2], m[2][2], 0.5},
                           static_cast<std::uint32_t>(i + 1));
  }
  scene::finish_top_tree(scene);
  simulation.sun.zenith_deg = 50, simulation.sun.azimuth_deg = 140;
  simulation.sky_directions = 1024;  // fewer leave noise beneath leaves
  simulation.seed = testing::seed(5);
  scene::Instrument camera;
  camera.name = "camera";
  camera.pixels = camera.lines = 24;
  camera.ifov_across_rad = camera.ifov_along_rad = 1.0 / 600;
  camera.poses = {{0, 0, 600, 0, 0, 30}};
  camera.samples_u = camera.samples_v = 5;
  for (int b = 0; b < 20; ++b) {
    scene::Band band;
    band.center_um = 0.42 + 0.03 * b, band.fwhm_um = 0.02;
    camera.bands.push_back(band);
  }
  simulation.instruments.push_back(camera);
  return simulation;
}

}  // namespace

TEST_CASE("S60 S61: device and reference agree on hits, sun and radiance of every band; the tables within tolerance") {
  const scene::Simulation simulation = small_park();
  const scene::Instrument& camera = simulation.instruments[0];
  const atmos::RenderTable table =
      atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 600, atmos::clear_sky_wavelengths(0.36, 1.1, 0.005),
                             atmos::clear_sky_heights(static_cast<double>(simulation.scene.lo[2]),
                                                      static_cast<double>(simulation.scene.hi[2])));
  const plan::Plan plan = plan::make_plan(simulation, camera, table, sensors::view_bounds(camera));
  render::Renderer renderer(simulation.scene, {});
  run::CheckOptions options;
  options.pixels = 24 * 24;
  options.model_pixels = 24;
  const reference::Report report = run::check_instrument(renderer, simulation, camera, plan, table, options);
  MESSAGE(report.text({}));
  for (const std::string& failure : report.failures()) FAIL_CHECK(failure);
  CHECK(report.pixels == 576);
  CHECK(report.rays == 576 * 25);
  CHECK(report.hits[0] > report.rays * 99 / 100);
  CHECK(report.sun_rays > report.rays / 2);
  CHECK(report.model_pixels == 24);
}

TEST_CASE("S61: first hits of every ray of the image, and of a part of it") {
  const scene::Simulation simulation = small_park();
  const scene::Instrument& camera = simulation.instruments[0];
  render::Renderer renderer(simulation.scene, {});
  std::uint64_t told = 0;
  const reference::HitReport all =
      run::check_hits(renderer, simulation.scene, camera, 5, 1000000, 0, [&](std::uint64_t rays) { told += rays; });
  CHECK(all.rays == 24 * 24 * 25);
  CHECK(told == all.rays);
  CHECK(all.of(reference::Cause::agree) > all.rays * 99 / 100);
  CHECK(all.of(reference::Cause::unexplained) == 0);
  CHECK(all.hit_miss_double == 0);
  const reference::HitReport part = run::check_hits(renderer, simulation.scene, camera, 5, 900, 0);
  CHECK(part.rays == 900);  // nine groups of 4 pixels
  CHECK(part.of(reference::Cause::unexplained) == 0);
}

TEST_CASE("S60 S61: a pixel of more samples than one chunk holds is probed and compared whole") {
  scene::Simulation simulation = small_park();
  scene::Instrument& camera = simulation.instruments[0];
  for (const scene::SamplerKind sampler : {scene::SamplerKind::grid, scene::SamplerKind::jittered}) {
    CAPTURE(static_cast<int>(sampler));
    camera.sampler = sampler;
    camera.samples_u = camera.samples_v = 41;  // 1681: a chunk of 1024 at most and a shorter one
    const atmos::RenderTable table = atmos::build_clear_sky(
        simulation.atmosphere, simulation.sun, 600, atmos::clear_sky_wavelengths(0.36, 1.1, 0.005),
        atmos::clear_sky_heights(static_cast<double>(simulation.scene.lo[2]),
                                 static_cast<double>(simulation.scene.hi[2])));
    const plan::Plan plan = plan::make_plan(simulation, camera, table, sensors::view_bounds(camera));
    render::Renderer renderer(simulation.scene, {});
    run::CheckOptions options;
    options.pixels = 4;
    options.model_pixels = 0;
    const reference::Report report = run::check_instrument(renderer, simulation, camera, plan, table, options);
    for (const std::string& failure : report.failures()) FAIL_CHECK(failure);
    CHECK(report.rays == 4 * 1681);
    CHECK(report.hits[0] > report.rays * 99 / 100);
    CHECK(report.sun_rays > report.rays / 2);
    CHECK(report.worst > 0);
    const reference::HitReport hits = run::check_hits(renderer, simulation.scene, camera, simulation.seed, 4 * 1681, 0);
    CHECK(hits.rays == report.rays);
    CHECK(hits.hits == report.hits);
  }
}

TEST_CASE("S61: pixels to check are picked by seed, without repeats, inside the image") {
  scene::Instrument camera;
  camera.pixels = 322, camera.lines = 50;
  const auto a = render::pick_tiles(camera, 1, 400), again = render::pick_tiles(camera, 1, 400),
             b = render::pick_tiles(camera, 2, 400);
  REQUIRE(a.size() == 100);
  bool same = true, other = false;
  std::set<std::pair<int, int>> places;
  for (std::size_t i = 0; i < a.size(); ++i) {
    CHECK(a[i].first_column % 4 == 0);
    CHECK(a[i].first_column + a[i].columns <= 322);
    CHECK(a[i].first_line < 50);
    places.insert({a[i].first_line, a[i].first_column});
    same &= a[i].first_line == again[i].first_line && a[i].first_column == again[i].first_column;
    other |= a[i].first_line != b[i].first_line;
  }
  CHECK(places.size() == 100);
  CHECK(same);
  CHECK(other);
  const auto whole = render::pick_tiles(camera, 1, 322 * 50);
  std::size_t pixels = 0;
  for (const auto& tile : whole) pixels += tile.pixels();
  CHECK(pixels == 322 * 50);
  CHECK(whole.back().first_line == 49);
  CHECK(whole.back().first_column + whole.back().columns == 322);
}
