// Thermal light on the device against the reference (S61, S4.8): fields on relief, houses and trees, every material at
// its own temperature. The reference looks up what hides the sky; the plan puts a black body of one temperature there:
// the model block "surroundings" says what that costs. Limits are DESIGN section 7's; the model's are the simulation's
// tolerance.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <memory>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/synthetic.h"
#include "atmos_tables/table_rows.h"
#include "host/base/planck.h"
#include "host/plan/baked_rows.h"
#include "host/run/check_bounced.h"
#include "host/run/check_instrument.h"
#include "host/sensors/view_bounds.h"
#include "scene_compiler/spectral_shape.h"
#include "tests/support/chance_checks.h"
#include "tests/support/full.h"
#include "tests/support/render_kit.h"
#include "tests/support/test_scenes.h"

using namespace raycube;

namespace {

struct Warm {
  double reflectance, kelvin;
};

/// Relief of three fields and a mixture, a box of two materials, 30 crowns; reflectances as in the thermal infrared.
scene::Simulation village(const std::vector<Warm>& warm, double spacing_m) {
  scene::Simulation simulation;
  auto& scene = simulation.scene;
  for (const Warm& w : warm) {
    test::add_material(scene, "m" + std::to_string(scene.materials.size()), w.reflectance);
    scene.materials.back().reflectance = {{0.3, 9.0, 15.0}, {w.reflectance, w.reflectance, 0.7 * w.reflectance}};
    scene.materials.back().temperature_K = w.kelvin;
  }
  shared::Surface mixture{};
  mixture.material[0] = 1, mixture.material[1] = 3;
  mixture.fraction[0] = 0.4f, mixture.fraction[1] = 0.6f;
  scene.surfaces.push_back(mixture);
  const auto mixed = static_cast<std::uint32_t>(scene.surfaces.size() - 1);
  auto ground = test::terrain(60, 300);
  for (std::size_t t = 0; t < ground.surface.size(); ++t) {
    const auto& v = ground.vertices[ground.triangles[t][0]];
    const auto field = static_cast<std::uint32_t>(std::floor(v[0] / 20) * 7 + std::floor(v[1] / 20) * 3 + 1000) % 4;
    ground.surface[t] = field < 3 ? field : mixed;
  }
  append_instance(scene, append_mesh(scene, "land", ground), test::placement(0, 0, 1, 0, 0, 8),
                  0);  // all of it above z = 0
  const auto house = append_mesh(
      scene, "house", test::join({test::box({-4, -6, -3}, {4, 6, 9}, 3), test::box({-2, -2, 9}, {0, 0, 12}, 4)}));
  append_instance(scene, house, test::placement(0.4, 0, 1, 6, 4, 11), 1);
  auto crown = test::crown(600, 0.5, 3, 9);
  std::fill(crown.surface.begin(), crown.surface.end(), 4u);
  const auto tree = append_mesh(scene, "tree", crown);
  for (std::uint32_t i = 0; i < 30; ++i)
    append_instance(scene, tree,
                    test::placement(i, 0.1, 1, spacing_m * (test::unit_random(1, i, 0) - 0.5),
                                    spacing_m * (test::unit_random(1, i, 1) - 0.5), 16),
                    i + 2);
  finish_top_tree(scene);
  simulation.seed = testing::seed(7);
  simulation.sky_directions = 512;
  scene::Instrument camera = test::nadir_camera(16, 16, 600, 2.5);
  camera.samples_u = camera.samples_v = 5;
  simulation.instruments = {camera};
  return simulation;
}

reference::Report compare(const scene::Simulation& simulation, const atmos::RenderTable& table, plan::Plan& plan) {
  const scene::Instrument& camera = simulation.instruments[0];
  plan = plan::make_plan(simulation, camera, table, sensors::view_bounds(camera));
  plan.baked = std::make_shared<plan::BakedRows>();  // as commands have it
  render::Renderer renderer(simulation.scene, {});
  run::CheckOptions options;
  options.pixels = 16 * 16;
  options.model_pixels = 24;
  const reference::Report report = run::check_instrument(renderer, simulation, camera, plan, table, options);
  MESSAGE(plan.sun_sources << " sun, " << plan.sky_components << " sky, " << plan.thermal.sky_components
                           << " thermal sky, " << plan.thermal.nodes() << " temperatures, " << plan.height.count
                           << " heights, " << plan.view.count << " views, surroundings " << plan.thermal.surroundings_K
                           << " K\n"
                           << report.text({}));
  for (const std::string& failure : report.failures()) FAIL_CHECK(failure);
  CHECK(report.pixels == 256);
  CHECK(report.thermal);
  return report;
}

/// Thermal rows on the axes of a table of sunlight: isothermal path, sky of the vertical depth given.
void add_thermal(atmos::RenderTable& table, double path_K, double sky_K, double sky_depth) {
  auto& path = add_row(table, "path_radiance_thermal", "isothermal path");
  auto& sky = add_row(table, "sky_radiance_thermal", "isothermal sky");
  const auto& um = atmos::wavelengths(table);
  std::size_t at = 0;
  std::vector<std::vector<double>> t;
  for (const double z : table.axis("target_height").nodes)
    for (const double view : table.axis("view_zenith").nodes) t.push_back(atmos::view_transmission(table, z, view));
  for (std::size_t i = 0; i < um.size(); ++i)
    for (const auto& transmission : t)
      path.values[at++] = static_cast<float>(base::planck_radiance(um[i], path_K) * (1 - transmission[i]));
  at = 0;
  for (const double l : um)
    for (std::size_t h = 0; h < table.axis("target_height").nodes.size(); ++h)
      for (const double zenith : table.axis("sky_zenith").nodes)
        sky.values[at++] =
            static_cast<float>(-base::planck_radiance(l, sky_K) * std::expm1(-sky_depth * atmos::airmass(zenith)));
}

/// The device's share of the error of what paths sum up; the reference's is by its own 65536.
const int kManyDirections = testing::full() ? 2048 : 512;

const std::vector<Warm> kSummer = {{0.02, 299}, {0.05, 312}, {0.08, 305}, {0.1, 318}, {0.03, 297}};

}  // namespace

TEST_CASE(
    "S4.8 S61 long-wave night: device and reference agree on every band; one temperature of the surroundings within "
    "tolerance") {
  auto simulation = village(kSummer, 60);
  simulation.sun.zenith_deg = 120;
  simulation.instruments[0].bands = test::gaussian_bands({8.3, 9.1, 10.2, 11.4, 12.4}, 0.2);
  const auto table = atmos::isothermal_table(
      285, [](double um) { return 0.3 + 0.15 * std::pow(um - 10, 2); }, 600, atmos::wavelength_grid(7, 14, 0.02));
  plan::Plan plan;
  const auto report = compare(simulation, table, plan);
  CHECK(plan.sun_sources == 0);
  CHECK(plan.sky_components == 0);
  CHECK(report.sky_rays > 100000);
  CHECK(report.model_surroundings.figure > 0);
  CHECK(report.model_surroundings.figure < 0.005);
  CHECK(report.text({}).find("surroundings at one temperature") != std::string::npos);
  CHECK(report.json().find("\"surroundings\"") != std::string::npos);
}

TEST_CASE("S4.8 S61 3.6 to 3.9 um by day: sun, skylight and thermal light on device and reference") {
  auto simulation = village({{0.05, 299}, {0.1, 306}, {0.15, 303}, {0.2, 310}, {0.05, 298}}, 60);
  simulation.sun.zenith_deg = 40, simulation.sun.azimuth_deg = 200;
  simulation.instruments[0].bands = test::gaussian_bands({3.6, 3.7, 3.8}, 0.04);
  auto table =
      atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 600, atmos::clear_sky_wavelengths(3.4, 3.99, 0.005),
                             atmos::clear_sky_heights(simulation.scene.lo[2], simulation.scene.hi[2]));
  add_thermal(table, 288, 270, 0.1);
  plan::Plan plan;
  const auto report = compare(simulation, table, plan);
  CHECK(plan.sun_sources == 1);
  CHECK(report.sun_rays > 1000);
}

TEST_CASE("S4.8 S16 light between warm surfaces is that of another code's paths, by night and by day") {
  // With panes of glass; without them the device's own paths, ray by ray. Short: night with panes, day
  // without.
  for (const auto& [day, panes] : {std::pair{false, true}, {true, true}, {false, false}, {true, false}}) {
    if (day == panes && !testing::full()) continue;
    CAPTURE(day);
    CAPTURE(panes);
    auto simulation = village({{0.3, 280}, {0.5, 330}, {0.4, 300}, {0.2, 340}, {0.15, 290}}, 60);
    auto& scene = simulation.scene;
    scene.materials[4].transmittance = {{0.3, 15.0}, {0.3, 0.2}};
    if (panes) {
      const auto pane = test::add_material(scene, "pane", 0.1);
      scene.materials.back().temperature_K = 310;
      scene.materials.back().reflectance = {{0.3, 15.0}, {0.1, 0.1}};
      scene.materials.back().transmittance = {{0.3, 9.0, 15.0}, {0.6, 0.7, 0.4}};
      scene.materials.back().behind = {RC_SHAPE_plate};
      test::place(scene, test::rectangle({-15, -15, 22}, {20, 0, 3}, {0, 30, 0}, pane));
      finish_top_tree(scene);
    }
    simulation.sky_directions = kManyDirections, simulation.bounces = 4, simulation.bounces_given = true;
    auto table = atmos::isothermal_table(
        285, [](double um) { return 0.3 + 0.02 * std::pow(um - 10, 2); }, 600, atmos::wavelength_grid(7, 14, 0.02));
    simulation.sun.zenith_deg = 120;
    simulation.instruments[0].bands = test::gaussian_bands({8.3, 10.2, 12.4}, 0.2);
    if (day) {
      simulation.sun.zenith_deg = 40, simulation.sun.azimuth_deg = 200;
      simulation.instruments[0].bands = test::gaussian_bands({3.6, 3.7, 3.8}, 0.04);
      table = atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 600,
                                     atmos::clear_sky_wavelengths(3.4, 3.99, 0.005),
                                     atmos::clear_sky_heights(scene.lo[2], scene.hi[2]));
      add_thermal(table, 288, 270, 0.1);
    }
    plan::Plan plan;
    compare(simulation, table, plan);
    render::Renderer renderer(scene, {});
    if (!panes) {
      const auto replayed = run::replay_paths(renderer, simulation, simulation.instruments[0], plan, {});
      MESSAGE(replayed.text());
      for (const std::string& failure : replayed.failures()) FAIL_CHECK(failure);
      CHECK(replayed.pixels > 0);
      CHECK(replayed.excluded_pixels == 0);
      CHECK(replayed.worst > 0);
      continue;
    }
    const auto bounced = run::check_bounced(renderer, simulation, simulation.instruments[0], plan, {});
    MESSAGE("a skeleton of " << plan.bounces.skeleton.size() << ":" << bounced.text());
    for (const std::string& failure : bounced.failures()) FAIL_CHECK(failure);
    for (const auto& band : bounced.bands) {
      MESSAGE(band.device << " for " << band.reference << " +- " << band.error);
      CHECK_WITHIN(band.device - band.reference, 4 * band.error + bounced.skeleton_error * band.size);
      CHECK(band.error < 0.02 * std::abs(band.reference));
    }
  }
}

TEST_CASE("S21 S4.8 S61 matter that is not Lambert's emits by the angle: device, reference and paths of another code") {
  auto simulation = village(kSummer, 60);
  auto& materials = simulation.scene.materials;
  materials[0].front = materials[2].front = {RC_SHAPE_rpv, {0.8, -0.2, 0.5}};  // mixed in one surface
  materials[1].gloss = {RC_SHAPE_gloss, {0.3, 0.2}};
  materials[3].gloss_nodes = {{8, {RC_SHAPE_gloss, {0.3, 0.1}}}, {12, {RC_SHAPE_gloss, {0.45, 0.4}}}};
  materials[3].gloss = materials[3].gloss_nodes[0].shape;
  materials[4].front = {RC_SHAPE_oren_nayar, {30}}, materials[4].gloss = {RC_SHAPE_ward, {0.3, 0.2, 0.5, 30}};
  for (auto& material : materials) scene::make_lobes(material);
  simulation.instruments[0].bands = test::gaussian_bands({8.3, 10.2, 12.4}, 0.2);
  simulation.sun.zenith_deg = 120, simulation.sky_directions = kManyDirections, simulation.tolerance = 0.01;
  const auto table = atmos::isothermal_table(
      285, [](double um) { return 0.3 + 0.02 * std::pow(um - 10, 2); }, 600, atmos::wavelength_grid(7, 14, 0.02));
  plan::Plan plan;
  compare(simulation, table, plan);
  CHECK(!plan.thermal.albedo.empty());
  simulation.bounces = 3, simulation.bounces_given = true;
  const scene::Instrument& camera = simulation.instruments[0];
  plan = plan::make_plan(simulation, camera, table, sensors::view_bounds(camera));
  REQUIRE(plan.bounces.any());
  render::Renderer renderer(simulation.scene, {});
  const auto replayed = run::replay_paths(renderer, simulation, camera, plan, {});
  MESSAGE(replayed.text());
  for (const std::string& failure : replayed.failures()) FAIL_CHECK(failure);
  CHECK(replayed.worst > 0);
  if (!testing::full()) return;  // what they send along paths is in test render_lobe_heat too
  const auto bounced = run::check_bounced(renderer, simulation, camera, plan, {});
  MESSAGE(bounced.text());
  for (const std::string& failure : bounced.failures()) FAIL_CHECK(failure);
  for (const auto& band : bounced.bands) {
    CHECK_WITHIN(band.device - band.reference, 4 * band.error + bounced.skeleton_error * band.size);
    CHECK(band.error < 0.02 * std::abs(band.reference));
  }
}

TEST_CASE(
    "S61 more than four components of sky: glowing surfaces under a clear sky in the visible, two float4s of weights") {
  auto simulation = village({{0.3, 1279}, {0.2, 1281}, {0.4, 1280}, {0.1, 1282}, {0.15, 1280.5}}, 60);
  simulation.sun.zenith_deg = 60, simulation.sun.azimuth_deg = 140;
  simulation.tolerance = 0.01;
  simulation.plan.sky_rank = 4;                                 // and the thermal sky's
  simulation.sky_directions = 2048;  // 512 leave 1.1 % beside what glows
  simulation.instruments[0].bands = test::gaussian_bands({0.42, 0.5, 0.66, 0.8, 0.95}, 0.01);
  auto table =
      atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 600, atmos::clear_sky_wavelengths(0.38, 1.0, 0.005),
                             atmos::clear_sky_heights(simulation.scene.lo[2], simulation.scene.hi[2]));
  add_thermal(table, 1000, 1200, 0.5);
  plan::Plan plan =
      plan::make_plan(simulation, simulation.instruments[0], table, sensors::view_bounds(simulation.instruments[0]));
  MESSAGE(plan::plan_json(plan).dump(2));
  compare(simulation, table, plan);
  CHECK(plan.components() > 4);  // two float4s of met sky
}

TEST_CASE(
    "S61 lava below 3 um, under a table that holds no thermal row: the reference has its light, so a plan "
    "without it fails the check") {
  auto simulation = village({{0.3, 300}, {0.2, 300}, {0.4, 300}, {0.1, 300}, {0.15, 300}}, 60);
  simulation.scene.materials[0].temperature_K = 700;  // a field: little of it lights the others at 2.2 um
  simulation.sun.zenith_deg = 40, simulation.sun.azimuth_deg = 200;
  simulation.instruments[0].bands = test::gaussian_bands({1.0, 1.6, 2.2}, 0.02);
  const auto table =
      atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 600, atmos::clear_sky_wavelengths(0.9, 2.3, 0.005),
                             atmos::clear_sky_heights(simulation.scene.lo[2], simulation.scene.hi[2]));
  const scene::Instrument& camera = simulation.instruments[0];
  const auto checked = [&] {
    const plan::Plan plan = plan::make_plan(simulation, camera, table, sensors::view_bounds(camera));
    render::Renderer renderer(simulation.scene, {});
    run::CheckOptions options;
    options.pixels = options.model_pixels = 96;  // one in fifteen shows the lava
    return run::check_instrument(renderer, simulation, camera, plan, table, options);
  };
  const auto with = checked();
  MESSAGE(with.text({}));
  CHECK(with.thermal);
  CHECK(with.model_emission.figure < 1e-3);  // nodes of height and view
  CHECK(with.beyond_pixels == 0);
  simulation.thermal_below_3um = false;
  const auto without = checked();
  MESSAGE(without.text({}));
  CHECK(without.thermal);
  CHECK(without.model_emission.figure > 0.5);
  CHECK(without.model_total.figure > 0.5);
  CHECK(!without.failures().empty());
}
