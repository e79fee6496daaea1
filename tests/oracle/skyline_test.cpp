// The ground's skyline: what it claims of every pair of places, by brute force; that it is told of ordinary ground and
// not near walls, edges, folds and second layers; that sun and sky are the same bits with it and without.
#include "scene_compiler/skyline.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "host/plan/sky_rays.h"
#include "tests/support/devices.h"
#include "tests/support/skies.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"

using namespace raycube;
using raycube::test::first_context;

namespace {

/// Ground of n x n quads of side_m about the origin, of a height by place; every quad but those left out.
template <class Height, class Keep>
scene::TriangleMesh ground(std::uint32_t n, double side_m, const Height& height, const Keep& keep) {
  scene::TriangleMesh mesh;
  for (std::uint32_t j = 0; j <= n; ++j)
    for (std::uint32_t i = 0; i <= n; ++i) {
      const double x = side_m * (i - 0.5 * n), y = side_m * (j - 0.5 * n);
      mesh.vertices.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(height(x, y))});
    }
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      if (!keep(i, j)) continue;
      const std::uint32_t a = j * (n + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  return mesh;
}

void add(scene::TriangleMesh& mesh, const std::array<float, 3>& a, const std::array<float, 3>& b,
         const std::array<float, 3>& c) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
  mesh.triangles.push_back({first, first + 1, first + 2});
}

/// A level square of corners (x, y) and (x + side, y + side) at height z.
void add_plate(scene::TriangleMesh& mesh, float x, float y, float side, float z) {
  add(mesh, {x, y, z}, {x + side, y, z}, {x + side, y + side, z});
  add(mesh, {x, y, z}, {x + side, y + side, z}, {x, y + side, z});
}

scene::TriangleMesh finished(scene::TriangleMesh mesh) {
  mesh.surface.assign(mesh.triangles.size(), 0);
  for (std::uint32_t i = 0; i < mesh.triangles.size(); ++i) mesh.user_face.push_back(i);
  return mesh;
}

scene::CompiledScene alone(const scene::TriangleMesh& mesh, const std::array<double, 12>& place) {
  scene::CompiledScene scene;
  scene::append_instance(scene, scene::append_mesh(scene, "ground", mesh), place, 0);
  scene::finish_top_tree(scene);
  return scene;
}

double hills(double x, double y) {
  return 0.9 * std::sin(0.35 * x) * std::cos(0.28 * y) + 0.05 * std::sin(3.1 * x + y);
}
const auto kAll = [](std::uint32_t, std::uint32_t) { return true; };

std::size_t known_cells(const scene::Skyline& skyline) {
  std::size_t known = 0;
  for (std::size_t c = 1; c < skyline.cells.size(); c += 2) known += std::isfinite(skyline.cells[c]);
  return known;
}

/// Skyline of the cell of a place, or infinity off the grid.
float at(const scene::Skyline& skyline, double x, double y) {
  const double column = (x - skyline.x_m) * skyline.per_cell, row = (y - skyline.y_m) * skyline.per_cell;
  if (column < 0 || row < 0 || column >= skyline.columns || row >= skyline.rows)
    return std::numeric_limits<float>::infinity();
  return skyline.cells[2 * (static_cast<std::size_t>(row) * skyline.columns + static_cast<std::size_t>(column)) + 1];
}

/// Places on a mesh: of each triangle its corners and three more drawn inside.
std::vector<std::array<double, 3>> places_on(const scene::TriangleMesh& mesh) {
  std::vector<std::array<double, 3>> out;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (std::uint32_t k = 0; k < 6; ++k) {
      double u = k == 1 ? 1 : 0, v = k == 2 ? 1 : 0;
      if (k > 2) {
        const double r = std::sqrt(test::unit_random(t, k, 0)), s = test::unit_random(t, k, 1);
        u = r * (1 - s), v = r * s;
      }
      std::array<double, 3> p{};
      for (std::size_t i = 0; i < 3; ++i) {
        const double a = mesh.vertices[mesh.triangles[t][0]][i], b = mesh.vertices[mesh.triangles[t][1]][i],
                     c = mesh.vertices[mesh.triangles[t][2]][i];
        p[i] = a + u * (b - a) + v * (c - a);
      }
      out.push_back(p);
    }
  return out;
}

/// How far the worst pair of places stands above what the skyline claims, m; and pairs looked at.
double worst_claim(const scene::TriangleMesh& mesh, const scene::Skyline& skyline, std::size_t& pairs) {
  double worst = -1;
  const auto places = places_on(mesh);
  for (std::size_t i = 0; i < places.size(); i += 37) {
    const auto& p = places[i];
    const float square = at(skyline, p[0], p[1]);
    if (!std::isfinite(square)) continue;
    const double slope = std::sqrt(double{square});
    for (const auto& q : places) {
      worst = std::max(worst, q[2] - p[2] - slope * std::hypot(q[0] - p[0], q[1] - p[1]));
      ++pairs;
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("S7: no place of the ground stands higher above another than the skyline says, walls and layers included") {
  struct Case {
    std::string name;
    scene::TriangleMesh mesh;
    double least_known;  // share of cells; of the 31 x 31 here the outer three on each side are near the edge
  };
  std::vector<Case> cases;
  cases.push_back({"hills", ground(60, 0.7, hills, kAll), 0.6});
  cases.push_back({"level",
                   ground(
                       60, 0.7, [](double, double) { return 3.0; }, kAll),
                   0.65});
  cases.push_back(
      {"with a hole", ground(60, 0.7, hills, [](auto i, auto j) { return i != 30 || j < 20 || j > 40; }), 0.5});
  cases.push_back({"a cliff of a quad",
                   ground(
                       60, 0.7, [](double x, double y) { return hills(x, y) + (x > 3 ? 8 : 0); }, kAll),
                   0.1});
  auto tower = ground(60, 0.7, hills, kAll);
  add(tower, {5, 5, -2}, {6, 5, -2}, {5.5f, 5, 6});
  cases.push_back({"a spire", tower, 0.02});
  auto roof = ground(60, 0.7, hills, kAll);
  add_plate(roof, -8, -8, 6, 4);
  cases.push_back({"a roof", roof, 0.1});
  auto lid = ground(60, 0.7, hills, kAll);
  add_plate(lid, -40, -40, 80, 1.5f);  // so low that cells beyond the near ones do not tell
  cases.push_back({"a lid over all of it", lid, 0});
  auto turned_over = ground(60, 0.7, hills, kAll);
  for (std::uint32_t t = 2000; t < 2400; ++t)
    std::swap(turned_over.triangles[t][0], turned_over.triangles[t][t % 2 + 1]);
  cases.push_back({"some triangles wound the other way", turned_over, 0.6});
  auto step = ground(60, 0.7, hills, [](auto i, auto) { return i < 34; });
  const auto upper = ground(
      60, 0.7, [](double x, double y) { return hills(x, y) + 2; }, [](auto i, auto) { return i >= 34; });
  for (const auto& t : upper.triangles) add(step, upper.vertices[t[0]], upper.vertices[t[1]], upper.vertices[t[2]]);
  cases.push_back({"a step without a wall", step, 0.3});
  for (const Case& c : cases) {
    INFO(c.name);
    const auto mesh = finished(c.mesh);
    const scene::CompiledScene scene = alone(mesh, test::kIdentity);
    const scene::Skyline& skyline = scene.skyline;
    std::size_t pairs = 0;
    const double worst = skyline.cells.empty() ? -1 : worst_claim(mesh, skyline, pairs);
    const double known = skyline.cells.empty() ? 0
                                               : 2.0 * static_cast<double>(known_cells(skyline)) /
                                                     static_cast<double>(skyline.cells.size());
    MESSAGE(c.name << ": " << known << " of the cells known, worst " << worst << " m above its claim, " << pairs
                   << " pairs");
    CHECK(worst <= 1e-5);  // corners are rounded to 1e-6 m
    CHECK(known >= c.least_known);
  }
}

TEST_CASE("S7: under a roof, beside a wall and at the ground's edge nothing is known") {
  auto mesh = ground(60, 0.7, hills, kAll);
  add_plate(mesh, -8, -8, 6, 4);
  add(mesh, {5, 5, -2}, {6, 5, -2}, {5.5f, 5, 3});
  const auto scene = alone(finished(mesh), test::kIdentity);
  REQUIRE(scene.skyline.instance == 0);
  CHECK(!std::isfinite(at(scene.skyline, -5, -5)));
  CHECK(!std::isfinite(at(scene.skyline, 5.5, 5)));
  CHECK(!std::isfinite(at(scene.skyline, 20.9, 0)));
  CHECK(std::isfinite(at(scene.skyline, -15, 12)));
}

TEST_CASE("S7: balls, a ground placed twice, stretched ground and a wall have no skyline") {
  auto twice = alone(finished(ground(20, 1, hills, kAll)), test::kIdentity);
  scene::append_instance(twice, 0, test::placement(0, 0.1, 1, 40, 0, 0), 1);
  CHECK(scene::survey_skyline(twice, 2).instance == RC_NONE);
  CHECK(alone(test::sphere(2, 3, 0.1), test::kIdentity).skyline.instance == RC_NONE);
  const std::array<double, 12> taller{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 8, 0};  // points are not lifted off as it is told
  CHECK(alone(finished(ground(20, 1, hills, kAll)), taller).skyline.instance == RC_NONE);
  scene::TriangleMesh wall;
  add(wall, {0, 0, 0}, {10, 0, 0}, {10, 0, 8});
  CHECK(alone(finished(wall), test::kIdentity).skyline.instance == RC_NONE);
}

TEST_CASE("S9: the same skyline for any number of threads, and by parts of the edges") {
  const auto scene = alone(finished(ground(80, 0.7, hills, kAll)), test::kIdentity);
  const auto one = scene::survey_skyline(scene, 1), three = scene::survey_skyline(scene, 3);
  CHECK(one.cells == three.cells);
  CHECK(one.cells == scene.skyline.cells);
  CHECK(scene::survey_skyline(scene, 2, 1).cells == one.cells);
}

TEST_CASE("S7 S9: sun and sky are the same bits with the skyline and without, over ground placed anyhow") {
  auto mesh = ground(90, 0.35, hills, kAll);
  add_plate(mesh, 2, 2, 3, 3);
  add(mesh, {-5, -5, -1}, {-5, -3, -1}, {-5, -4, 4});
  const auto ball = test::sphere(1, 2, 0.1);
  const std::array<double, 12> turned = test::placement(3, 0.7, 1.3, 1, -2, 0.5);
  for (const auto& place : {test::kIdentity, turned}) {
    scene::CompiledScene scene;
    const auto first = scene::append_mesh(scene, "ground", finished(mesh));
    const auto second = scene::append_mesh(scene, "ball", ball);
    scene::append_instance(scene, first, place, 0);
    for (std::uint32_t i = 0; i < 12; ++i)
      scene::append_instance(
          scene, second,
          test::placement(i, 0.4 * i, 0.3 + 0.1 * (i % 4), 2.2 * i - 12, 3.0 * (i % 5) - 6, 1.0 + 0.4 * (i % 3)),
          i + 1);
    scene::finish_top_tree(scene);
    REQUIRE(scene.skyline.instance == 0);
    scene::CompiledScene plain = scene;
    plain.skyline = {};
    test::TraceShape shape;
    shape.nu = shape.nv = 6;
    shape.components = 2;
    shape.columns = shape.pixels_per_line = 30, shape.lines = 30;
    const auto groups = test::nadir_groups(shape, 0, 0, 200, 0.9, 200, 0.02);
    plan::Plan plan;
    plan.sky_components = 2;
    plan.sun_direction = {0.5f, 0.2f, 0.8426150f};
    plan.sky_basis = test::factors_of(test::clear_sky(32.6), 2).basis;
    plan.sky = plan::make_sky_rays(plan.sky_basis, plan.thermal, 1.19, plan.sun_direction, 80);
    plan.sky.open_share = {0.5f};
    test::TraceChain with(first_context(), scene, shape), without(first_context(), plain, shape);
    CHECK(with.primary(groups) == without.primary(groups));
    with.surface(), without.surface();
    std::size_t asked = 0, seen = 0;
    for (const double elevation_deg : {3.0, 9.0, 14.0, 20.0, 30.0, 50.0, 85.0})
      for (int turn = 0; turn < 5; ++turn) {
        const double e = elevation_deg * std::numbers::pi / 180, a = 1.3 * turn + 0.1;
        const shared::rc_float4 way{static_cast<float>(std::cos(e) * std::sin(a)),
                                    static_cast<float>(std::cos(e) * std::cos(a)), static_cast<float>(std::sin(e)), 0};
        const auto mine = with.sun(way), theirs = without.sun(way);
        CHECK(mine == theirs);
        for (const auto word : mine) seen += static_cast<std::size_t>(__builtin_popcount(word)), asked += 16;
      }
    CHECK(seen > asked / 10);
    CHECK(seen < asked * 9 / 10);
    CHECK(with.sky(plan) == without.sky(plan));
  }
}
