// Watertightness of the tracing kernels on closed surfaces: camera rays, rays aimed at edges, rays aimed at vertices.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

#include "tests/support/devices.h"
#include "tests/support/full.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"

using namespace raycube;
using raycube::test::first_context;
using test::TraceShape;

namespace {

/// Of a million rays each, camera rays and those aimed at edges.
int passes() { return testing::full() ? 10 : 3; }

std::size_t misses(const std::vector<std::uint32_t>& hits, const TraceShape& shape) {
  std::size_t count = 0;
  for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
    for (std::uint32_t s = 0; s < shape.samples(); ++s)
      count += hits[shape.hits_at(pixel, RC_HIT_INSTANCE, s)] == RC_NONE;
  return count;
}

TraceShape tile(std::uint32_t columns, std::uint32_t lines, int n) {
  TraceShape shape;
  shape.nu = shape.nv = n;
  shape.columns = shape.pixels_per_line = columns, shape.lines = lines;
  return shape;
}

// One group per target, whose sample (column 0, row 0) is the only one that matters: its ray is aimed from inside the
// closed sphere at a point; with 1 sample per pixel and one pixel per group d0 is that ray.
std::vector<shared::RayGroup> aimed(const std::vector<std::array<double, 3>>& targets,
                                    const std::array<double, 3>& origin) {
  std::vector<shared::RayGroup> groups;
  for (const auto& target : targets) {
    double d[3];
    for (int k = 0; k < 3; ++k) d[k] = target[k] - static_cast<double>(static_cast<float>(origin[k]));
    const double side[3] = {std::abs(d[0]) < std::abs(d[2]) ? 1.0 : 0.0, 0.0,
                            std::abs(d[0]) < std::abs(d[2]) ? 0.0 : 1.0};
    const double u[3] = {d[1] * side[2] - d[2] * side[1], d[2] * side[0] - d[0] * side[2],
                         d[0] * side[1] - d[1] * side[0]};
    const double v[3] = {d[1] * u[2] - d[2] * u[1], d[2] * u[0] - d[0] * u[2], d[0] * u[1] - d[1] * u[0]};
    const double length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    const double su = 1e-3 * length / std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
    const double sv = 1e-3 * length / std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    const auto f = [](const double(&x)[3], double s) {
      return shared::rc_float4{static_cast<float>(s * x[0]), static_cast<float>(s * x[1]), static_cast<float>(s * x[2]),
                               0};
    };
    shared::RayGroup g{};
    g.origin = {static_cast<float>(origin[0]), static_cast<float>(origin[1]), static_cast<float>(origin[2]), 0};
    g.d0 = f(d, 1), g.du = f(u, su), g.dv = f(v, sv);
    groups.push_back(g);
  }
  return groups;
}

// Sends every target's ray through the kernel in batches; instanced as asked. Returns the rays that left the closed
// surface.
std::size_t leaks_at(const scene::CompiledScene& scene, const std::vector<std::array<double, 3>>& targets, bool bundle,
                     int pass = 0) {
  TraceShape shape = tile(1, 0, 1);
  shape.pixels_per_group = 1;
  shape.bundle = bundle;
  shape.lines = static_cast<std::uint32_t>(targets.size());
  const std::array<double, 3> origin{0.13 + 0.11 * pass, -0.21 - 0.07 * pass, 0.17 - 0.05 * pass};
  test::TraceChain chain(first_context(), scene, shape);
  return misses(chain.primary(aimed(targets, origin)), shape);
}

}  // namespace

TEST_CASE("S5: 3e6 camera rays over closed terrain, of all cases 1e7, none falls through") {
  const auto scene = test::single(test::terrain(260, 160));
  TraceShape shape = tile(180, 46, 11);  // 180 x 46 x 121 = 1.0e6 rays a shot
  test::TraceChain chain(first_context(), scene, shape);
  std::size_t rays = 0, lost = 0;
  for (int shot = 0; shot < passes(); ++shot) {
    const auto hits = chain.primary(
        test::nadir_groups(shape, 1.7 * shot, 0.9 * shot, 300 + 37 * shot, 0.3, 300 + 37 * shot, 0.004 * shot));
    lost += misses(hits, shape);
    rays += std::size_t{shape.pixels()} * shape.samples();
  }
  CHECK(rays >= std::size_t{1'000'000} * static_cast<std::size_t>(passes()));
  CHECK(lost == 0);
}

TEST_CASE(
    "S5: rays aimed at edge interiors and at vertices of a closed instanced surface, 3e6 of them, of all cases 1e7, "
    "none leaves it") {
  const auto mesh = test::sphere(4, 3, 0.15);
  scene::CompiledScene scene;
  const auto index = scene::append_mesh(scene, "sphere", mesh);
  const auto place = test::placement(0.4, 0.3, 1.3, 0.2, -0.1, 0.05);
  scene::append_instance(scene, index, place, 0);
  scene::finish_top_tree(scene);
  const auto world = [&](const std::array<double, 3>& p) {
    std::array<double, 3> q;
    for (int i = 0; i < 3; ++i)
      q[i] = place[4 * i] * p[0] + place[4 * i + 1] * p[1] + place[4 * i + 2] * p[2] + place[4 * i + 3];
    return q;
  };
  std::size_t edge_rays = 0, edge_leaks = 0;
  for (int pass = 0; pass < passes(); ++pass) {
    std::vector<std::array<double, 3>> edges;
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::uint32_t k = 0; k < 3; ++k) {
        const auto& a = mesh.vertices[mesh.triangles[t][k]];
        const auto& b = mesh.vertices[mesh.triangles[t][(k + 1) % 3]];
        for (std::uint32_t repeat = 0; repeat < 66; ++repeat) {
          const double f = 0.02 + 0.96 * test::unit_random(9 + pass, t * 3 + k, repeat);
          edges.push_back(world(
              {a[0] + f * (double(b[0]) - a[0]), a[1] + f * (double(b[1]) - a[1]), a[2] + f * (double(b[2]) - a[2])}));
        }
      }
    edge_rays += edges.size();
    edge_leaks += leaks_at(scene, edges, true, pass);
  }
  std::vector<std::array<double, 3>> vertices;
  for (const auto& v : mesh.vertices) vertices.push_back(world({v[0], v[1], v[2]}));
  CHECK(edge_rays >= std::size_t{1'000'000} * static_cast<std::size_t>(passes()));
  CHECK(edge_leaks == 0);
  for (int pass = 0; pass < 10; ++pass) {
    CHECK(leaks_at(scene, vertices, true, pass) == 0);
    CHECK(leaks_at(scene, vertices, false, pass) == 0);
  }
}
