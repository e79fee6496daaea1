// Where ray tracing fails (REQUIREMENTS section 4, Geometry), on every device found, in bundles and ray by ray.
// Oracles: brute force in double over the same rays (judge_hits), and closed forms of planes, convex bodies and counted
// hits.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/support/devices.h"
#include "host/base/units.h"
#include "scene_compiler/owner.h"
#include "tests/support/judge_hits.h"
#include "tests/support/render_kit.h"
#include "tests/support/test_scenes.h"

using namespace raycube;
using test::TraceShape;

namespace {

TraceShape tile(std::uint32_t columns, std::uint32_t lines, int n) {
  TraceShape shape;
  shape.nu = shape.nv = n;
  shape.columns = shape.pixels_per_line = columns, shape.lines = lines;
  return shape;
}

/// All rays of a tile in bundles and one by one: none wrong, at most a share of them on an edge or at a tie in depth.
void require_right(const scene::CompiledScene& scene, TraceShape shape, const std::vector<shared::RayGroup>& groups,
                   double least_hits, double most_explained = 1e-3) {
  test::on_every_device([&](const cl::Context& context) {
    for (const bool bundle : {true, false}) {
      CAPTURE(bundle);
      shape.bundle = bundle;
      const auto count = test::judge_hits(context, scene, shape, groups);
      CHECK(count.wrong == 0);
      CHECK(double(count.explained) <= most_explained * double(count.rays));
      CHECK(double(count.hits) >= least_hits * double(count.rays));
    }
  });
}

scene::CompiledScene placed(const std::vector<scene::TriangleMesh>& meshes) {
  scene::CompiledScene scene;
  for (std::uint32_t i = 0; i < meshes.size(); ++i)
    scene::append_instance(scene, scene::append_mesh(scene, "mesh", meshes[i]), test::kIdentity, i);
  scene::finish_top_tree(scene);
  return scene;
}

/// Samples whose ray hit, and of these how many the sun lights.
struct Lit {
  std::size_t hits = 0, lit = 0;
};
Lit lit_samples(const cl::Context& context, const scene::CompiledScene& scene, const TraceShape& shape,
                const std::vector<shared::RayGroup>& groups, double zenith_rad) {
  test::TraceChain chain(context, scene, shape);
  const auto hits = chain.primary(groups);
  chain.surface();
  const auto mask =
      chain.sun({static_cast<float>(std::sin(zenith_rad)), 0, static_cast<float>(std::cos(zenith_rad)), 0});
  Lit sum;
  for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
    for (std::uint32_t s = 0; s < shape.samples(); ++s) {
      const bool hit = hits[shape.hits_at(pixel, RC_HIT_INSTANCE, s)] != RC_NONE;
      sum.hits += hit;
      sum.lit += hit && shape.sees_sun(mask, pixel, s);
    }
  return sum;
}

/// Nodes that a walk can have waiting at once: the siblings left behind on the way down, whatever the order of
/// children.
std::uint32_t most_waiting(const scene::CompiledScene& scene, std::uint32_t index) {
  const auto& node = scene.nodes[index];
  std::uint32_t deepest = 0;
  for (std::uint32_t k = 0; k < node.count; ++k)
    if (!(node.leaf_mask >> k & 1)) deepest = std::max(deepest, most_waiting(scene, node.child[k]));
  return node.count + (deepest ? deepest - 1 : 0);
}

}  // namespace

TEST_CASE(
    "stability: views at 80 to 89.9 degrees hit a plane always and relief where double does; no self-shadow under a "
    "sun as low") {
  const auto plane = placed({test::rectangle({-50000, -50000, 0}, {100000, 0, 0}, {0, 100000, 0}, 0)});
  const auto relief = test::single(test::terrain(40, 400));
  for (const double angle_deg : {80.0, 89.0, 89.9}) {
    CAPTURE(angle_deg);
    TraceShape shape = tile(12, 8, 4);
    const double tilt = std::tan(base::rad_from_deg(angle_deg));
    // The farthest ray meets the plane within 50 km: 10 m high, 17 km at 89.97 degrees.
    const auto groups = test::nadir_groups(shape, 0, 0, 10, 1e-4, 0.1, tilt);
    require_right(plane, shape, groups, 1);
    test::on_every_device([&](const cl::Context& context) {
      const Lit seen = lit_samples(context, plane, shape, groups, base::rad_from_deg(angle_deg));
      CHECK(seen.hits == shape.pixels() * shape.samples());
      CHECK(seen.lit == seen.hits);
    });
    // 12 m above the hills, or among them where the ray falls by 0.7 m only on its way across.
    require_right(relief, shape, test::nadir_groups(shape, -150, 0, angle_deg > 89.5 ? 1.5 : 12, 5e-3 * tilt, 1, tilt),
                  0.2);
  }
}

TEST_CASE("stability: a low-poly sphere and a view from 20 km: each face is lit exactly where it faces the sun") {
  // A convex body has no shadows but its own faces turned away: the lit share of a convex polyhedron's samples follows
  // from the faces' normals alone. Near a terminator's edge nothing is doubtful, for a sample belongs to one face.
  const auto mesh = test::sphere(1, 5, 0);
  const auto scene = placed({mesh});
  const double zenith = base::rad_from_deg(70), sun[3] = {std::sin(zenith), 0, std::cos(zenith)};
  for (const double height_m : {60.0, 20000.0}) {
    CAPTURE(height_m);
    TraceShape shape = tile(16, 16, 4);
    const auto groups = test::nadir_groups(shape, 0, 0, height_m, 0.7, height_m, 1e-5);
    test::on_every_device([&](const cl::Context& context) {
      test::TraceChain chain(context, scene, shape);
      const auto hits = chain.primary(groups);
      chain.surface();
      const auto mask =
          chain.sun({static_cast<float>(sun[0]), static_cast<float>(sun[1]), static_cast<float>(sun[2]), 0});
      std::size_t lit = 0, dark = 0, wrong = 0;
      for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
        for (std::uint32_t s = 0; s < shape.samples(); ++s) {
          const std::uint32_t primitive = hits[shape.hits_at(pixel, RC_HIT_PRIMITIVE, s)];
          if (hits[shape.hits_at(pixel, RC_HIT_INSTANCE, s)] == RC_NONE) continue;
          const auto& corner = mesh.triangles[scene::owner_of(scene, 0, primitive).triangle];
          double p[3][3], n[3], cosine = 0;
          for (int k = 0; k < 3; ++k)
            for (int i = 0; i < 3; ++i) p[k][i] = mesh.vertices[corner[k]][i];
          for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3, k = (i + 2) % 3;
            n[i] = (p[1][j] - p[0][j]) * (p[2][k] - p[0][k]) - (p[1][k] - p[0][k]) * (p[2][j] - p[0][j]);
            cosine += n[i] * sun[i];
          }
          const bool seen = shape.sees_sun(mask, pixel, s);
          (seen ? lit : dark) += 1;
          wrong += seen != (cosine > 0);
        }
      CHECK(lit > 500);
      CHECK(dark > 200);
      CHECK(wrong == 0);
    });
  }
}

TEST_CASE("stability: a plane of 40 km seen from 20 km, tilted and level, is lit everywhere") {
  for (const double tilt : {0.0, 0.3}) {
    scene::TriangleMesh mesh = test::rectangle({-20000, -20000, 0}, {40000, 0, 0}, {0, 40000, 0}, 0);
    for (auto& v : mesh.vertices) v[2] = static_cast<float>(tilt * v[0]);
    const auto scene = placed({mesh});
    TraceShape shape = tile(20, 20, 4);
    const auto groups = test::nadir_groups(shape, 300, 100, 20000, 1500, 20000, 0);
    test::on_every_device([&](const cl::Context& context) {
      const Lit seen = lit_samples(context, scene, shape, groups,
                                   base::rad_from_deg(60));  // 30 deg high, the slope of 17 deg turned from it
      CHECK(seen.hits > 0.9 * shape.pixels() * shape.samples());
      CHECK(seen.lit == seen.hits);
    });
  }
}

TEST_CASE("stability: trees of the greatest depth: the stack holds every node that can wait, and no hit is lost") {
  // Triangles that grow by 2^(1/8) each, from 1 mm to 1000 km, one inside the next: every split cuts off the largest
  // few, so that the tree is as deep as such a tree gets.
  scene::TriangleMesh mesh;
  for (std::uint32_t i = 0; i < 240; ++i) {
    const float size = static_cast<float>(1e-3 * std::exp2(i / 8.0));
    mesh.vertices.insert(mesh.vertices.end(),
                         {{-size, -size, -size}, {size, -size, -size}, {0.1f * size, size, -size}});
    mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    mesh.surface.push_back(0);
    mesh.user_face.push_back(i);
  }
  // The same spread of sizes among instances makes the tree over them deep too.
  scene::CompiledScene scene;
  const auto index = scene::append_mesh(scene, "nested", mesh);
  for (std::uint32_t i = 0; i < 60; ++i)
    scene::append_instance(scene, index,
                           test::placement(0.1 * i, 0, std::exp2(-0.5 * i), 0, 0, -0.1 * std::exp2(-0.5 * i)), i);
  scene::finish_top_tree(scene);
  MESSAGE("levels: top " << scene.top_depth << ", mesh " << scene.trees[0].depth << "; stack " << scene.stack_bound());
  CHECK(scene.top_depth + scene.trees[0].depth >= 6);
  CHECK(most_waiting(scene, 0) + most_waiting(scene, scene.trees[0].root) <= scene.stack_bound());
  TraceShape shape = tile(6, 6, 4);
  // Seen from far above, small ones lie closer together than rounding parts them: ties in depth, 9 in 576 at most.
  for (const double height_m : {0.01, 1.0, 1000.0})
    require_right(scene, shape, test::nadir_groups(shape, 0.1 * height_m, 0, height_m, 0.2, 1, 0.05), 0.3, 0.03);
}

TEST_CASE("stability: a part of 1 mm on and above terrain of 100 km is hit by the rays that meet it, and by no other") {
  const double kHalf = 5e-4;  // m
  for (const double relief_m : {0.0, 800.0}) {
    scene::TriangleMesh ground = test::terrain(50, 100000);  // cells of 2 km
    for (auto& v : ground.vertices)
      v[2] = static_cast<float>(relief_m * std::sin(v[0] / 9000) * std::cos(v[1] / 7000) - 0.001 - relief_m);
    const float low = relief_m > 0 ? 0.2f : 0.0f;  // above relief or on the plain, whose top is 1 mm below it
    scene::TriangleMesh part = test::box({-kHalf, -kHalf, low}, {kHalf, kHalf, low + 2 * kHalf}, 0);
    const auto scene = placed({ground, part});
    TraceShape shape = tile(12, 12, 4);
    // Rays 0.025 mm apart straight down from 1 m above, over 1.2 mm.
    const double above = 1;
    const auto groups = test::nadir_groups(shape, 0, 0, low + 2 * kHalf + above, 1e-4, above, 0);
    require_right(scene, shape, groups, 1,
                  40.0 / 2304);  // the diagonal of the part's top runs through 40 of the samples
    test::on_every_device([&](const cl::Context& context) {
      test::TraceChain chain(context, scene, shape);
      const auto hits = chain.primary(groups);
      std::size_t wrong = 0, met = 0;
      for (std::uint32_t line = 0; line < shape.lines; ++line)
        for (std::uint32_t column = 0; column < shape.columns; ++column)
          for (std::uint32_t s = 0; s < shape.samples(); ++s) {
            const auto ray = test::host_ray(groups[line * shape.groups_per_line() + column / shape.pixels_per_group],
                                            shape, 0, column % shape.pixels_per_group, s);
            // Top face, at distance `above` along z: rays that pass beside it meet no side of it either (they spread
            // outwards).
            const double x = std::abs(ray.direction[0] / ray.direction[2]) * above,
                         y = std::abs(ray.direction[1] / ray.direction[2]) * above;
            if (std::abs(std::max(x, y) - kHalf) < 1e-6) continue;  // fp32 rays from 1 m: 0.06 um, times roundings
            const bool inside = std::max(x, y) < kHalf;
            const bool on_part = hits[shape.hits_at(line * shape.columns + column, RC_HIT_INSTANCE, s)] == 1;
            met += inside;
            wrong += inside != on_part;
          }
      CHECK(met > 1000);
      CHECK(wrong == 0);
    });
  }
}

TEST_CASE("stability: axis-parallel rays in slab planes, coincident faces, slivers, one triangle, nothing") {
  TraceShape shape = tile(17, 17, 1);
  shape.pixels_per_group = 1;
  auto groups = test::nadir_groups(shape, 0, 0, 10, 0.25, 1, 0);
  for (auto& group : groups) {  // straight down every 0.25 m: along borders, diagonals and corners of what follows
    group.origin.x = group.d0.x, group.origin.y = group.d0.y;
    group.d0 = {0, 0, -1, 0}, group.du = {1e-4f, 0, 0, 0}, group.dv = {0, -1e-4f, 0, 0};
  }
  const auto square = test::rectangle({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 0);
  const auto wall = test::rectangle({0, -1, 0}, {0, 2, 0}, {0, 0, 2}, 0);  // edge-on to every ray
  const auto coincident = placed({test::join({square, square}), square, wall});
  require_right(coincident, shape, groups, 0.2);
  test::on_every_device(
      [&](const cl::Context& context) {  // inside the square no ray is lost, whatever edge it runs along
        const auto hits = test::TraceChain(context, coincident, shape).primary(groups);
        for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
          if (std::max(std::abs(groups[pixel].origin.x), std::abs(groups[pixel].origin.y)) < 1)
            CHECK(hits[shape.hits_at(pixel, RC_HIT_INSTANCE)] != RC_NONE);
      });
  scene::TriangleMesh slivers = test::triangle_soup(100, 2, 2, 8);
  for (std::size_t t = 0; t < slivers.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      slivers.vertices[3 * t + 2][k] = 0.5f * (slivers.vertices[3 * t][k] + slivers.vertices[3 * t + 1][k]) + 1e-5f * k;
  TraceShape dense = tile(20, 20, 4);
  require_right(test::single(slivers), dense, test::nadir_groups(dense, 0, 0, 20, 0.3, 20, 0.02), 0);
  require_right(test::single(test::triangle_soup(1, 0.1, 4, 3)), dense, test::nadir_groups(dense, 0, 0, 10, 0.3, 10, 0),
                0.001);
  require_right(placed({}), shape, groups, 0);
}

TEST_CASE("stability: closed bodies leak no ray at edges and vertices, seen from inside") {
  const auto mesh = test::sphere(2, 3, 0.2);
  const auto scene = placed({mesh});
  TraceShape shape = tile(1, 0, 1);
  shape.pixels_per_group = 1;
  std::vector<shared::RayGroup> groups;
  const auto aim = [&](double x, double y, double z) {
    shared::RayGroup g{};
    const float from[3] = {0.1f, -0.2f, 0.15f};
    g.origin = {from[0], from[1], from[2], 0};
    g.d0 = {static_cast<float>(x - from[0]), static_cast<float>(y - from[1]), static_cast<float>(z - from[2]), 0};
    g.du = {-1e-4f * g.d0.y, 1e-4f * g.d0.x, 0, 0}, g.dv = {0, -1e-4f * g.d0.z, 1e-4f * g.d0.y, 0};
    groups.push_back(g);
  };
  for (const auto& v : mesh.vertices) aim(v[0], v[1], v[2]);
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const auto &a = mesh.vertices[t[k]], &b = mesh.vertices[t[(k + 1) % 3]];
      for (const double f : {0.25, 0.5, 0.7})
        aim(a[0] + f * (double(b[0]) - a[0]), a[1] + f * (double(b[1]) - a[1]), a[2] + f * (double(b[2]) - a[2]));
    }
  shape.lines = static_cast<std::uint32_t>(groups.size());
  test::on_every_device([&](const cl::Context& context) {
    for (const bool bundle : {true, false}) {
      shape.bundle = bundle;
      const auto hits = test::TraceChain(context, scene, shape).primary(groups);
      std::size_t lost = 0;
      for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
        lost += hits[shape.hits_at(pixel, RC_HIT_INSTANCE)] == RC_NONE;
      CHECK(lost == 0);
    }
  });
}
