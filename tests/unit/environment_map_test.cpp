// The map of the environment by itself: vertical rays against what lies there by construction, shares that sum to 1,
// bilinear weights, the scene's mean.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/environment_function.h"
#include "host/plan/environment_map.h"
#include "host/plan/ground_rays.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;

plan::ViewBounds straight_down(double height_m, double half_m) {
  plan::ViewBounds view;
  view.sensor_height_m = height_m;
  view.x_min = view.y_min = -half_m / std::hypot(height_m, half_m);
  view.x_max = view.y_max = -view.x_min;
  view.sec_max = std::hypot(height_m, half_m) / height_m;
  return view;
}

/// Ground 12 x 12 km: west half black, east half white; a turned and scaled table of 100 x 100 m over (300, 200).
scene::CompiledScene halves() {
  scene::CompiledScene scene;
  const auto west = test::add_material(scene, "west", 0), east = test::add_material(scene, "east", 1),
             top = test::add_material(scene, "top", 0.5);
  test::place(scene, test::rectangle({-6000, -6000, 0}, {6000, 0, 0}, {0, 12000, 0}, west));
  test::place(scene, test::rectangle({0, -6000, 0}, {6000, 0, 0}, {0, 12000, 0}, east));
  const auto mesh = append_mesh(scene, "table", test::rectangle({-0.5, -0.5, 0}, {1, 0, 0}, {0, 1, 0}, top));
  const double h = 50 * std::sqrt(2.0) * std::sqrt(2.0);
  append_instance(scene, mesh, {h, -h, 0, 300, h, h, 0, 200, 0, 0, 1, 30}, 2);  // by 45 degrees: a diamond, side 141 m
  finish_top_tree(scene);
  return scene;
}

}  // namespace

TEST_CASE("the uppermost surface seen from above: ground, what stands on it, and nothing beside it") {
  const auto scene = halves();
  CHECK(plan::uppermost_surface(scene, -400, 100) == 0);
  CHECK(plan::uppermost_surface(scene, 400, -100) == 1);
  CHECK(plan::uppermost_surface(scene, 300, 200) == 2);
  CHECK(plan::uppermost_surface(scene, 300 + 99, 200) == 2);       // towards a corner
  CHECK(plan::uppermost_surface(scene, 300 + 60, 200 + 60) == 1);  // past an edge
  CHECK(plan::uppermost_surface(scene, 6500, 0) == RC_NONE);
  CHECK(plan::uppermost_surface({}, 0, 0) == RC_NONE);
}

TEST_CASE("S4.9 environment map: shares sum to 1, fall from one half to the other, and keep the border's even split") {
  const auto scene = halves();
  const auto map = plan::make_environment(scene, straight_down(600, 400), 0, 30, true);
  CHECK(map.columns > 30);
  double last = 2;
  for (std::size_t node = 0; node < map.nodes(); ++node) {
    double molecules = 0, aerosol = 0;
    for (std::size_t p = map.first_part[node]; p < map.first_part[node + 1]; ++p)
      molecules += map.part[p].molecules, aerosol += map.part[p].aerosol;
    CHECK(molecules == doctest::Approx(1).epsilon(1e-12));
    CHECK(aerosol == doctest::Approx(1).epsilon(1e-12));
  }
  const auto west_at = [&](double x, double y) {
    double west = 0;
    for (const auto& [node, weight] : plan::environment_at(map, x, y))
      for (std::size_t p = map.first_part[node]; p < map.first_part[node + 1]; ++p)
        if (map.part[p].material == 0) west += weight * map.part[p].aerosol;
    return west;
  };
  for (double x = -400; x <= 400; x += 10) {
    const double west = west_at(x, -300);
    CHECK(west <= last + 5e-4);  // 4096 places: steps of 2.4e-4
    last = west;
  }
  // A half plane `d` m away holds 1/(2 pi) int (1 - F(d / cos a)) da of the light; the table and the end of the world
  // are far.
  for (const double d : {30.0, 100.0, 200.0, 400.0}) {
    double beyond = 0;
    for (int i = 0; i < 2000; ++i) {
      const double a = std::numbers::pi * ((i + 0.5) / 2000 - 0.5);
      beyond += (1 - atmos::environment_function(atmos::Scatterer::aerosol, d / std::cos(a) / 1000, map.height_m / 1000,
                                                 map.cos_view)) /
                4000;
    }
    MESSAGE(d << " m from the border: beyond it " << beyond << ", map " << west_at(d, -300) << " and "
              << 1 - west_at(-d, -300));
    CHECK(std::abs(west_at(d, -300) - beyond) < 0.01);
    CHECK(std::abs(1 - west_at(-d, -300) - beyond) < 0.01);
  }
  CHECK(std::abs(west_at(0, -300) - 0.5) < 0.01);
}

TEST_CASE("S4.9 environment map: bilinear weights sum to 1, are exact at nodes, and clamp outside") {
  plan::EnvironmentMap map;
  map.columns = 4;
  map.rows = 3;
  map.first_x_m = 10;
  map.first_y_m = -20;
  map.step_m = 5;
  const auto place = [&](double x, double y) {
    double sum = 0, column = 0, row = 0;
    for (const auto& [node, weight] : plan::environment_at(map, x, y)) {
      CHECK(node < 12);
      CHECK(weight >= 0);
      sum += weight, column += weight * (node % 4), row += weight * (node / 4);
    }
    CHECK(sum == doctest::Approx(1).epsilon(1e-14));
    return std::array<double, 2>{column, row};
  };
  CHECK(place(20, -15)[0] == doctest::Approx(2));
  CHECK(place(18.5, -12)[0] == doctest::Approx(1.7));
  CHECK(place(18.5, -12)[1] == doctest::Approx(1.6));
  CHECK(place(1e9, -1e9)[0] == 3);
  CHECK(place(1e9, -1e9)[1] == 0);
  map.columns = map.rows = 1;
  CHECK(place(50, 50)[0] == 0);
}

TEST_CASE("S4.9 scene mean: area seen from above, holes left out; a scene without ground is black") {
  const auto scene = halves();
  const auto map = plan::make_environment(scene, straight_down(600, 10000), 0, 30, false);
  CHECK(map.nodes() == 1);
  const double table = 2e4 / 144e6;
  CHECK(map.mean[0] == doctest::Approx(0.5).epsilon(0.01));
  CHECK(map.mean[1] == doctest::Approx(0.5 - table).epsilon(0.01));
  CHECK(map.mean[2] == doctest::Approx(table).epsilon(0.2));  // nine points of 65536
  CHECK(plan::mean_reflectance(map, scene, {0.5})[0] == doctest::Approx(0.5 - table / 2).epsilon(0.01));
  scene::CompiledScene nothing;
  nothing.lo = {1, 1, 1};
  finish_top_tree(nothing);
  const auto none = plan::make_environment(nothing, straight_down(600, 10), 0, 0, true);
  CHECK(none.nodes() == 1);
  CHECK(none.part.empty());
}
