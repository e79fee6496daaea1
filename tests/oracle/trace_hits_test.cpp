// Closest hits of the tracing kernels against brute force in double over the same fp32 rays (DESIGN section 7).
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "kernels/sampling/sampler.h"
#include "scene_compiler/owner.h"
#include "tests/support/devices.h"
#include "tests/support/judge_hits.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"

using namespace raycube;
using raycube::test::first_context;
using test::TraceShape;

namespace {

test::HitCount compare(const scene::CompiledScene& scene, const TraceShape& shape,
                       const std::vector<shared::RayGroup>& groups) {
  return test::judge_hits(first_context(), scene, shape, groups);
}

TraceShape tile(std::uint32_t columns, std::uint32_t lines, int nu, int nv) {
  TraceShape shape;
  shape.nu = nu, shape.nv = nv;
  shape.columns = shape.pixels_per_line = columns, shape.lines = lines;
  return shape;
}

// Triangles of every size, small ones in rotated and scaled instances, large ones around the sensor's nadir.
scene::CompiledScene soup() {
  scene::CompiledScene scene;
  const auto small = scene::append_mesh(scene, "small", test::triangle_soup(60, 1.5, 0.4, 1));
  const auto large = scene::append_mesh(scene, "large", test::triangle_soup(20, 6, 5, 2));
  for (std::uint32_t i = 0; i < 5; ++i)
    scene::append_instance(scene, small,
                           test::placement(0.7 * i, 0.3 * i, 0.5 + 0.3 * i, 10 * test::unit_random(5, i, 0) - 5,
                                           10 * test::unit_random(5, i, 1) - 5, 4 * test::unit_random(5, i, 2)),
                           i);
  scene::append_instance(scene, large, test::kIdentity, 100);
  scene::append_instance(scene, large, test::placement(0.3, -0.2, 1.1, 1, 2, -4), 101);
  scene::finish_top_tree(scene);
  return scene;
}

void require_right(const scene::CompiledScene& scene, const TraceShape& shape,
                   const std::vector<shared::RayGroup>& groups, double least_hits = 0.1) {
  const test::HitCount count = compare(scene, shape, groups);
  MESSAGE("rays " << count.rays << ", hits " << count.hits << ", explained " << count.explained);
  CHECK(count.hits >= static_cast<std::size_t>(least_hits * count.rays));
  CHECK(count.explained <= count.rays / 1000);
  CHECK(count.wrong == 0);
}

// Four large triangles: a slab axis-parallel and through round coordinates, and its mirror image in the same plane.
scene::CompiledScene planes() {
  scene::TriangleMesh mesh;
  for (const float z : {0.0f, 1.0f, 1.0f})
    for (const auto& corner : {std::array<float, 3>{-2, -2, z}, {2, -2, z}, {2, 2, z}, {-2, 2, z}})
      mesh.vertices.push_back(corner);
  for (std::uint32_t base : {0u, 4u, 8u}) {
    const std::uint32_t turned = base == 0;  // the lowest faces down: edge functions of the other sign
    mesh.triangles.push_back({base, base + 1 + turned, base + 2 - turned});
    mesh.triangles.push_back({base, base + 2 + turned, base + 3 - turned});
  }
  mesh.surface.assign(mesh.triangles.size(), 0);
  mesh.user_face = {0, 1, 2, 3, 4, 5};
  return test::single(mesh);
}

}  // namespace

TEST_CASE("S7: a million rays into a soup of instanced triangles: nothing unexplained against brute force in double") {
  TraceShape shape = tile(97, 86, 11, 11);
  require_right(soup(), shape, test::nadir_groups(shape, 0.3, -0.2, 60, 0.15, 60, 0.01));
}

TEST_CASE("S7: every sampler, wide supports, one pixel per group, and single rays give the oracle's hits") {
  const auto scene = soup();
  struct Form {
    int sampler, pixels_per_group;
    float support;
    bool bundle;
  };
  for (const Form& form :
       {Form{RC_SAMPLER_GRID, 4, 3, true}, Form{RC_SAMPLER_LATTICE, 4, 1, true}, Form{RC_SAMPLER_JITTERED, 4, 1, true},
        Form{RC_SAMPLER_GRID, 1, 1, true}, Form{RC_SAMPLER_GRID, 4, 1, false}, Form{RC_SAMPLER_LATTICE, 1, 3, true}}) {
    TraceShape shape = tile(7, 5, 6, 5);
    shape.sampler = form.sampler, shape.support = form.support, shape.pixels_per_group = form.pixels_per_group,
    shape.bundle = form.bundle;
    shape.seed = 77, shape.first_line = 3, shape.pixels_per_line = 20, shape.first_column = 4;
    INFO("sampler " << form.sampler << ", support " << form.support << ", group of " << form.pixels_per_group);
    require_right(scene, shape, test::nadir_groups(shape, 0.3, -0.2, 60, 0.6, 60, 0.01));
  }
}

// The same rays, begun where the centre ray passes the height `top`.
std::vector<shared::RayGroup> ahead(std::vector<shared::RayGroup> groups, double top) {
  for (auto& group : groups) {
    group.d0.w = static_cast<float>((double{group.origin.z} - top) / -double{group.d0.z});
    const auto start = [&group](float o, float d) { return static_cast<float>(o + double{group.d0.w} * d); };
    group.origin = {start(group.origin.x, group.d0.x), start(group.origin.y, group.d0.y),
                    start(group.origin.z, group.d0.z), group.origin.w};
  }
  return groups;
}

TEST_CASE("S7: bundles that give way to single rays, all, some and none of them, give the oracle's hits") {
  const auto scene = soup();
  for (const int sampler : {RC_SAMPLER_GRID, RC_SAMPLER_LATTICE})
    for (const int visits : {1, 30, 100000}) {
      TraceShape shape = tile(30, 21, 6, 5);
      shape.sampler = sampler, shape.visits = visits;
      CAPTURE(sampler);
      CAPTURE(visits);
      require_right(scene, shape, ahead(test::nadir_groups(shape, 0.3, -0.2, 700, 0.5, 700, 0.001), 12));
    }
}

TEST_CASE("S7: moving poses: the origin changes across the line") {
  TraceShape shape = tile(24, 12, 4, 4);
  shape.moving = true;
  auto groups = test::nadir_groups(shape, 0.3, -0.2, 60, 0.5, 60, 0.01);
  for (auto& group : groups) group.ov = {0.3f, -0.7f, 0.1f, 0};
  require_right(soup(), shape, groups);
}

// Bounds of judge_hits are relative to where rays start: 1e-5 m here, whatever the sensor's height. From 700 km itself
// they are 1 m.
TEST_CASE(
    "S7: rays of sensors 60 m, 20 km and 700 km up that start above the scene: every form gives the oracle's hits") {
  const auto scene = soup();
  struct Form {
    int sampler, pixels_per_group;
    float support;
    bool bundle, moving;
  };
  for (const double height : {60.0, 2e4, 7e5})
    for (const Form& form : {Form{RC_SAMPLER_GRID, 4, 1, true, false}, Form{RC_SAMPLER_GRID, 4, 3, true, false},
                             Form{RC_SAMPLER_JITTERED, 4, 1, true, false}, Form{RC_SAMPLER_LATTICE, 1, 3, true, false},
                             Form{RC_SAMPLER_GRID, 4, 1, false, false}, Form{RC_SAMPLER_GRID, 4, 1, true, true}}) {
      TraceShape shape = tile(24, 21, 8, 8);
      shape.sampler = form.sampler, shape.support = form.support, shape.pixels_per_group = form.pixels_per_group,
      shape.bundle = form.bundle, shape.moving = form.moving;
      INFO("height " << height << " m, sampler " << form.sampler << ", support " << form.support << ", bundle "
                     << form.bundle << ", moving " << form.moving);
      auto groups = ahead(test::nadir_groups(shape, 0.3, -0.2, height, 0.5, height, 0.6 / height), 12);
      if (form.moving)
        for (auto& group : groups) group.ov = {0.3f, -0.7f, 0.1f, 0};
      require_right(scene, shape, groups);
    }
}

TEST_CASE("S7: from inside, triangles behind and beside the sensor, wide fields of view") {
  const auto scene = soup();
  TraceShape shape = tile(40, 30, 4, 4);
  require_right(scene, shape, test::nadir_groups(shape, 0.5, 0.4, 0.7, 0.1, 1, 0.3), 0.3);
  const auto closed = test::single(test::sphere(2, 3, 0.2));
  TraceShape wide = tile(8, 8, 6, 6);
  require_right(closed, wide, test::nadir_groups(wide, 0.5, 0.4, 0.7, 0.9, 1, 0.3), 1.0);
}

TEST_CASE("S7: axis-parallel rays that run in slab planes, coincident faces, one triangle, an empty scene") {
  // One ray per pixel straight down, origins every 0.25 m over a 4 m square: rays in its borders, diagonals and middle.
  TraceShape shape = tile(33, 33, 1, 1);
  shape.pixels_per_group = 1;
  auto groups = test::nadir_groups(shape, 0, 0, 10, 0.25, 1, 0);
  for (auto& group : groups) {
    group.origin.x = group.d0.x, group.origin.y = group.d0.y;
    group.d0 = {0, 0, -1, 0}, group.du = {1e-4f, 0, 0, 0}, group.dv = {0, -1e-4f, 0, 0};
  }
  require_right(planes(), shape, groups, 0.2);
  // Of the two sheets at z = 1 the one with the lower primitive numbers wins everywhere, edges included; from below the
  // sheet at z = 0. Inside the square every ray hits, those exactly on its diagonal too, whichever way round the
  // triangles are seen.
  test::TraceChain chain(first_context(), planes(), shape);
  const auto scene = planes();
  for (const bool from_below : {false, true}) {
    auto looking = groups;
    if (from_below)
      for (auto& group : looking) group.origin.z = -10, group.d0.z = 1;
    const auto hits = chain.primary(looking);
    const std::uint32_t face = from_below ? 0 : 2;
    for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel) {
      const std::uint32_t primitive = hits[shape.hits_at(pixel, RC_HIT_PRIMITIVE)];
      if (primitive != RC_NONE) CHECK(scene::owner_of(scene, 0, primitive).face / 2 == face / 2);
      if (std::max(std::abs(groups[pixel].origin.x), std::abs(groups[pixel].origin.y)) < 2) CHECK(primitive != RC_NONE);
    }
  }
  require_right(test::single(test::triangle_soup(1, 0.1, 4, 3)), shape, test::nadir_groups(shape, 0, 0, 10, 0.5, 10, 0),
                0.001);
  scene::CompiledScene empty;
  scene::finish_top_tree(empty);
  const test::HitCount none = compare(empty, shape, groups);
  CHECK(none.hits == 0);
  CHECK(none.wrong == 0);
}

TEST_CASE("S7: slivers a thousand times longer than wide") {
  auto mesh = test::triangle_soup(200, 4, 1, 8);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {  // third corner next to the middle of the first edge
      auto& v = mesh.vertices;
      const auto &a = v[3 * t], &b = v[3 * t + 1];
      v[3 * t + 2][k] = 0.5f * (a[k] + b[k]) + 1e-3f * (v[3 * t + 2][k] - a[k]);
    }
  TraceShape shape = tile(44, 40, 8, 8);
  require_right(test::single(mesh), shape, test::nadir_groups(shape, 0.1, 0.2, 50, 0.2, 50, 0.02), 0.0001);
}

TEST_CASE("DESIGN 4: tiles, chunks of samples and single rays change no bit") {
  const auto scene = soup();
  TraceShape whole = tile(18, 6, 8, 6);
  const auto groups = test::nadir_groups(whole, 0.3, -0.2, 60, 0.7, 60, 0.01);
  const auto all = test::TraceChain(first_context(), scene, whole).primary(groups);
  TraceShape line = whole;  // one line at a time, its right part alone
  line.lines = 1, line.first_column = 8, line.columns = 10;
  TraceShape part = whole;  // two rows of samples at a time
  part.chunk = 16;
  test::TraceChain by_line(first_context(), scene, [&] {
    line.first_line = 4;
    return line;
  }());
  const auto right = by_line.primary(test::nadir_groups(line, 0.3, -0.2, 60, 0.7, 60, 0.01));
  for (std::uint32_t column = 0; column < 10; ++column)
    for (std::uint32_t plane = 0; plane < RC_HIT_PLANES; ++plane)
      for (std::uint32_t k = 0; k < whole.elements().near; ++k)
        CHECK(right[line.hits_at(column, plane, k)] == all[whole.hits_at(4 * 18 + 8 + column, plane, k)]);
  test::TraceChain by_chunk(first_context(), scene, part);
  for (std::uint32_t first = 0; first < 48; first += 16) {
    const auto some = by_chunk.primary(groups, first);
    for (std::uint32_t pixel = 0; pixel < whole.pixels(); ++pixel)
      for (std::uint32_t row = 0; row < RC_HIT_PLANES; ++row)
        for (std::uint32_t k = 0; k < 16; ++k)
          CHECK(some[part.hits_at(pixel, row, k)] == all[whole.hits_at(pixel, row, first + k)]);
  }
}
