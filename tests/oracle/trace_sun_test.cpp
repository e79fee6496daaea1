// Surface points and who sees the sun, against closed forms and double brute force.
#include <doctest/doctest.h>

#include <cmath>

#include "tests/support/devices.h"
#include "tests/support/double_trace.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"

using namespace raycube;
using raycube::test::first_context;
using test::TraceShape;

TEST_CASE(
    "S8: surface points lie on the viewer's side of their triangle, within the stated bound; the sun matches brute "
    "force") {
  scene::CompiledScene scene;
  const auto ground = scene::append_mesh(scene, "ground", test::terrain(12, 40));
  const auto ball = scene::append_mesh(scene, "ball", test::sphere(1, 2, 0.1));
  scene::append_instance(scene, ground, test::kIdentity, 0);
  for (std::uint32_t i = 0; i < 6; ++i)
    scene::append_instance(
        scene, ball, test::placement(i, 0.4 * i, 0.6 + 0.2 * i, 5.0 * i - 12, 3.0 * (i % 3) - 3, 3 + i % 2), i + 1);
  scene::finish_top_tree(scene);
  // A group's points fill 8, 32 and 76 words of 16: less than one round of the loops over words, one, and several.
  TraceShape shape;
  SUBCASE("25 samples") { shape.nu = shape.nv = 5, shape.columns = 18, shape.lines = 10; }
  SUBCASE("121 samples") { shape.nu = shape.nv = 11, shape.columns = 8, shape.lines = 5; }
  SUBCASE("289 samples") { shape.nu = shape.nv = 17, shape.columns = 8, shape.lines = 4; }
  CAPTURE(shape.nu);
  shape.pixels_per_line = shape.columns;
  const auto groups = test::nadir_groups(shape, 0, 0, 300, 30.6 / shape.columns, 300, 0.02);
  test::TraceChain chain(first_context(), scene, shape);
  const auto hits = chain.primary(groups);
  const auto surface = chain.surface();
  const double zenith = 1.2;
  const shared::rc_float4 sun{static_cast<float>(std::sin(zenith) * 0.6), static_cast<float>(std::sin(zenith) * 0.8),
                              static_cast<float>(std::cos(zenith)), 0};
  const auto mask = chain.sun(sun);

  const test::DoubleTracer oracle(scene);
  constexpr std::size_t n = RC_WORD;
  std::size_t lit = 0, dark = 0, wrong_side = 0, far_off = 0, sun_wrong = 0;
  for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel) {
    for (std::uint32_t s = 0; s < shape.elements().padded; ++s) {
      const float* at = surface.data() + shape.surface_at(pixel, 0, s);
      const double point[3] = {at[RC_POINT_X * n], at[RC_POINT_Y * n], at[RC_POINT_Z * n]};
      const float normal[3] = {at[RC_NORMAL_X * n], at[RC_NORMAL_Y * n], at[RC_NORMAL_Z * n]};
      const bool seen = shape.sees_sun(mask, pixel, s);
      const std::uint32_t instance = hits[shape.hits_at(pixel, RC_HIT_INSTANCE, s)],
                          primitive = hits[shape.hits_at(pixel, RC_HIT_PRIMITIVE, s)];
      if (instance == RC_NONE) {
        CHECK(normal[2] == 0);
        CHECK(!seen);
        continue;
      }
      const float to_viewer[3] = {normal[0], normal[1], normal[2]}, back[3] = {-normal[0], -normal[1], -normal[2]};
      const auto up = oracle.test(instance, primitive, point, to_viewer);
      const auto down = oracle.test(instance, primitive, point, back);
      wrong_side += up.t > 0;
      // Coordinates of 20 m: the bound of rc_surface_point is below 100 roundings of 2^-24 of them.
      far_off += !(std::abs(down.t) < 100 * 0x1p-24 * 60);
      const double cosine = double(normal[0]) * sun.x + double(normal[1]) * sun.y + double(normal[2]) * sun.z;
      const float direction[3] = {sun.x, sun.y, sun.z};
      const bool truth = cosine > 0 && !oracle.blocked(point, direction);
      (seen ? lit : dark) += 1;
      sun_wrong += truth != seen;
    }
  }
  MESSAGE("lit " << lit << ", dark " << dark);
  CHECK(lit > 1000);
  CHECK(dark > 300);
  CHECK(wrong_side == 0);
  CHECK(far_off == 0);
  CHECK(sun_wrong == 0);
}

TEST_CASE("S8: bundles, single rays and any chunks see the same sun") {
  scene::CompiledScene scene;
  scene::append_instance(scene, scene::append_mesh(scene, "ground", test::terrain(12, 40)), test::kIdentity, 0);
  const auto ball = scene::append_mesh(scene, "ball", test::sphere(1, 2, 0.1));
  for (std::uint32_t i = 0; i < 6; ++i)
    scene::append_instance(scene, ball, test::placement(i, 0.4 * i, 0.6, 5.0 * i - 12, 3.0 * (i % 3) - 3, 3 + i % 2),
                           i + 1);
  scene::finish_top_tree(scene);
  TraceShape shape;
  shape.nu = shape.nv = 7;
  shape.columns = shape.pixels_per_line = 18, shape.lines = 10;
  const auto groups = test::nadir_groups(shape, 0, 0, 300, 1.7, 300, 0.02);
  TraceShape alone = shape, part = shape;
  alone.bundle = false;
  constexpr std::uint32_t kChunk = 21;  // three rows
  part.chunk = kChunk;
  test::TraceChain bundled(first_context(), scene, shape), single(first_context(), scene, alone),
      chunked(first_context(), scene, part);
  bundled.primary(groups), bundled.surface(), single.primary(groups), single.surface();
  for (int k = 0; k < 16; ++k) {
    const double c = (k + 0.5) / 16, s = std::sqrt(1 - c * c), phi = 2.4 * k;
    const shared::rc_float4 towards{static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)),
                                    static_cast<float>(c), 0};
    CAPTURE(k);
    const auto seen = bundled.sun(towards);
    CHECK(seen == single.sun(towards));
    std::size_t other = 0, lit = 0, all = 0;
    for (std::uint32_t first = 0; first < 49; first += kChunk) {
      chunked.primary(groups, first), chunked.surface();
      const auto found = chunked.sun(towards);
      for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
        for (std::uint32_t i = first; i < std::min(first + kChunk, 49u); ++i) {
          const bool sees = shape.sees_sun(seen, pixel, i);
          other += part.sees_sun(found, pixel, i - first) != sees;
          lit += sees, ++all;
        }
    }
    CHECK(other == 0);
    CHECK(lit > 100);
    CHECK(lit < all);
  }
}

TEST_CASE("S8: a flat long thin line does not shadow itself: the park's court lines under 64 directions") {
  scene::CompiledScene scene;
  scene::append_instance(scene, scene::append_mesh(scene, "court lines", test::court_lines()),
                         test::placement(0, 0, 1, 118, 76, 3.41), 0);
  scene::finish_top_tree(scene);
  // The eastern side line of the eastern court, x = 125.465 .. 125.535 m, 28 m long: its two triangles are 400 times
  // longer than wide.
  TraceShape shape;
  shape.nu = shape.nv = 8;
  shape.pixels_per_line = 284, shape.lines = 284, shape.first_column = 140, shape.columns = 4;
  const auto groups = test::nadir_groups(shape, 125.5, 76, 613.4, 0.1, 610, 0);
  for (const bool bundle : {true, false}) {
    shape.bundle = bundle;
    test::TraceChain chain(first_context(), scene, shape);
    const auto hits = chain.primary(groups);
    const auto surface = chain.surface();
    std::size_t points = 0, dark = 0;
    for (std::uint32_t k = 0; k < (bundle ? 64 : 8); ++k) {
      // First the one that check found in the park: the point (125.506, 68.954, 3.410) was dark.
      const double c = (k + 0.5) / 64, s = std::sqrt(1 - c * c), phi = 2.4 * k;
      const shared::rc_float4 towards =
          k ? shared::rc_float4{static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)),
                                static_cast<float>(c), 0}
            : shared::rc_float4{0.3485f, -0.7526f, 0.5586f, 0};
      const auto mask = chain.sun(towards);
      for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
        for (std::uint32_t sample = 0; sample < shape.samples(); ++sample) {
          if (hits[shape.hits_at(pixel, RC_HIT_INSTANCE, sample)] == RC_NONE) continue;
          ++points;
          const bool seen = shape.sees_sun(mask, pixel, sample);
          if (!seen && ++dark <= 3)
            MESSAGE((bundle ? "bundle" : "single") << " direction " << k << " pixel " << pixel << " point "
                                                   << surface[shape.surface_at(pixel, RC_POINT_X, sample)] << " "
                                                   << surface[shape.surface_at(pixel, RC_POINT_Y, sample)] << " "
                                                   << surface[shape.surface_at(pixel, RC_POINT_Z, sample)]);
        }
    }
    MESSAGE((bundle ? "bundle" : "single") << ": points and directions " << points << ", dark " << dark);
    CHECK(points > 100'000);
    CHECK(dark == 0);
  }
}
