// Surface points, sun and sky visibility against closed forms and double brute force.
#include <doctest/doctest.h>

#include <cmath>

#include "kernels/sampling/sampler.h"
#include "tests/support/devices.h"
#include "tests/support/double_trace.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"

using namespace raycube;
using raycube::test::first_context;
using test::TraceShape;

TEST_CASE(
    "S8: surface points lie on the viewer's side of their triangle, within the stated bound; sun and sky match brute "
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
  std::vector<shared::rc_float4> directions, weights;
  constexpr std::uint32_t kSets = 3, kCount = 8;
  for (std::uint32_t k = 0; k < kSets * kCount; ++k) {
    const double c = (k % kCount + 0.5) / kCount, s = std::sqrt(1 - c * c), phi = 2.4 * k;
    directions.push_back(
        {static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)), static_cast<float>(c), 0});
    weights.push_back({0.5f, 0.1f * static_cast<float>(k), 1.0f / static_cast<float>(k + 1), -0.2f});
  }
  const auto blocked = chain.sky(directions, weights, kSets);

  const test::DoubleTracer oracle(scene);
  const std::size_t n = shape.elements().padded;
  std::size_t lit = 0, dark = 0, wrong_side = 0, far_off = 0, sun_wrong = 0, sky_wrong = 0;
  for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel) {
    const std::uint32_t set = rc_hash(shape.seed, pixel, 0, 21) % kSets;
    for (std::uint32_t s = 0; s < n; ++s) {
      const float* at = surface.data() + shape.surface_at(pixel, 0) + s;
      const double point[3] = {at[RC_POINT_X * n], at[RC_POINT_Y * n], at[RC_POINT_Z * n]};
      const float normal[3] = {at[RC_NORMAL_X * n], at[RC_NORMAL_Y * n], at[RC_NORMAL_Z * n]};
      const bool seen = shape.sees_sun(mask, pixel, s);
      const std::uint32_t instance = hits[shape.hits_at(pixel, RC_HIT_INSTANCE) + s],
                          primitive = hits[shape.hits_at(pixel, RC_HIT_PRIMITIVE) + s];
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
      double expected[4] = {0, 0, 0, 0};
      for (std::uint32_t k = 0; k < kCount; ++k) {
        const auto& d = directions[set * kCount + k];
        const auto& w = weights[set * kCount + k];
        const float way[3] = {d.x, d.y, d.z};
        const double c = double(normal[0]) * d.x + double(normal[1]) * d.y + double(normal[2]) * d.z;
        if (c <= 0 || !oracle.blocked(point, way)) continue;
        expected[0] += w.x * c, expected[1] += w.y * c, expected[2] += w.z * c, expected[3] += w.w * c;
      }
      for (int c = 0; c < 4; ++c)
        sky_wrong +=
            std::abs(expected[c] - blocked[shape.blocked_at(pixel, c) + s]) > 1e-5 * (1 + std::abs(expected[c]));
    }
  }
  MESSAGE("lit " << lit << ", dark " << dark);
  CHECK(lit > 1000);
  CHECK(dark > 300);
  CHECK(wrong_side == 0);
  CHECK(far_off == 0);
  CHECK(sun_wrong == 0);
  CHECK(sky_wrong == 0);
}

TEST_CASE(
    "S8 S16 directions shared out: bundles, single rays and any chunks give the same, and the parts together are the "
    "whole") {
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
  constexpr std::uint32_t kSets = 2, kCount = 16;
  std::vector<shared::rc_float4> directions, weights;
  for (std::uint32_t k = 0; k < kSets * kCount; ++k) {
    const double c = (k % kCount + 0.5) / kCount, s = std::sqrt(1 - c * c), phi = 2.4 * k;
    directions.push_back(
        {static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)), static_cast<float>(c), 0});
    weights.push_back(
        {0.5f, 1.0f + 0.1f * static_cast<float>(k % kCount), 1.0f / static_cast<float>(k % kCount + 1), 0.2f});
  }
  shape.bundle = true;
  test::TraceChain bundled(first_context(), scene, shape);
  shape.bundle = false;
  test::TraceChain single(first_context(), scene, shape);
  bundled.primary(groups), bundled.surface(), single.primary(groups), single.surface();
  const auto whole = bundled.sky(directions, weights, kSets);
  const std::size_t n = shape.elements().padded, planes = shape.elements().blocked / n;
  constexpr std::uint32_t kChunk = 21;  // three rows
  shape.bundle = true, shape.chunk = kChunk;
  test::TraceChain chunked(first_context(), scene, shape);
  for (const std::uint32_t share : {1u, 2u, 4u, 8u, 16u}) {
    CAPTURE(share);
    const auto blocked = bundled.sky(directions, weights, kSets, share);
    CHECK(blocked == single.sky(directions, weights, kSets, share));
    CHECK((blocked == whole) == (share == 1));
    std::size_t other = 0;
    for (std::uint32_t first = 0; first < 49; first += kChunk) {
      chunked.primary(groups, first), chunked.surface();
      const auto part = chunked.sky(directions, weights, kSets, share);
      const std::size_t padded = shape.elements().padded;
      for (std::uint32_t row = 0; row < shape.pixels() * planes; ++row)
        for (std::uint32_t s = first; s < std::min(first + kChunk, 49u); ++s)
          other += part[std::size_t{row} * padded + s - first] != blocked[std::size_t{row} * n + s];
    }
    CHECK(other == 0);
    // The plane of weight 0 over all samples: what a part hides, counted `share` times, is the whole in the mean.
    double sum = 0, square = 0, all = 0;
    for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel) {
      double difference = 0;
      for (std::uint32_t s = 0; s < n; ++s) {
        const std::size_t at = shape.blocked_at(pixel, 0) + s;
        difference += blocked[at] - whole[at], all += whole[at];
      }
      sum += difference, square += difference * difference;
    }
    CHECK(all > 0);
    CHECK(std::abs(sum) <= 4 * std::sqrt(square));
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
          if (hits[shape.hits_at(pixel, RC_HIT_INSTANCE) + sample] == RC_NONE) continue;
          ++points;
          const bool seen = shape.sees_sun(mask, pixel, sample);
          if (!seen && ++dark <= 3)
            MESSAGE((bundle ? "bundle" : "single") << " direction " << k << " pixel " << pixel << " point "
                                                   << surface[shape.surface_at(pixel, RC_POINT_X) + sample] << " "
                                                   << surface[shape.surface_at(pixel, RC_POINT_Y) + sample] << " "
                                                   << surface[shape.surface_at(pixel, RC_POINT_Z) + sample]);
        }
    }
    MESSAGE((bundle ? "bundle" : "single") << ": points and directions " << points << ", dark " << dark);
    CHECK(points > 100'000);
    CHECK(dark == 0);
  }
}
