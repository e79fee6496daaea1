// What rays into the sky bring to each sample, against the same sums in double: the directions by
// kernels/sampling/sky_rays.h, what hides them by brute force, the light by the plan's maps.
#include <doctest/doctest.h>

#include <cmath>

#include "host/plan/sky_rays.h"
#include "host/reference/radiance.h"
#include "tests/support/devices.h"
#include "tests/support/double_trace.h"
#include "tests/support/skies.h"
#include "tests/support/test_scenes.h"
#include "tests/support/trace_chain.h"

using namespace raycube;
using raycube::test::first_context;
using test::TraceShape;

namespace {

constexpr float kOpenShares[] = {1.0f, 0.25f, 0.0f};  // of hills and of two kinds of balls

/// Hills with balls over them, of three surfaces that take other shares of the sky for granted.
scene::CompiledScene hills_with_balls() {
  scene::CompiledScene scene;
  const auto ground = scene::append_mesh(scene, "ground", test::terrain(12, 40));
  std::uint32_t ball[2];
  for (std::uint32_t i = 0; i < 2; ++i) {
    auto mesh = test::sphere(1, 2, 0.1);
    mesh.surface.assign(mesh.triangles.size(), 1 + i);
    ball[i] = scene::append_mesh(scene, "ball", mesh);
  }
  scene::append_instance(scene, ground, test::kIdentity, 0);
  for (std::uint32_t i = 0; i < 6; ++i)
    scene::append_instance(scene, ball[i % 2],
                           test::placement(i, 0.4 * i, 0.6 + 0.2 * i, 5.0 * i - 12, 3.0 * (i % 3) - 3, 3 + i % 2),
                           i + 1);
  scene::finish_top_tree(scene);
  return scene;
}

/// Maps of zenith angle alone: one that brightens towards the horizon, and how another differs from it.
plan::SkyBasis warm_sky() {
  plan::SkyBasis basis;
  for (int i = 0; i <= 9; ++i) basis.zenith_rad.push_back(base::kPi / 2 * i / 9);
  basis.azimuth_rad = {0, base::kPi};
  for (int i = 0; i <= 9; ++i)
    for (int j = 0; j < 2; ++j) basis.value.push_back({0.25 + 0.02 * i, 0.1 - 0.02 * i, 0, 0});
  return basis;
}

/// A plan of which the sky's rays need no more. solar: components of a clear sky, 0 .. 4; warm: of a thermal one, with
/// surroundings where there are any.
plan::Plan sky_plan(int solar, int warm, int rays, const std::vector<float>& open_share) {
  constexpr double kZenith_deg = 40, kAzimuth_rad = 2.1;
  plan::Plan plan;
  const double zenith = base::rad_from_deg(kZenith_deg);
  plan.sun_direction = {static_cast<float>(std::sin(zenith) * std::sin(kAzimuth_rad)),
                        static_cast<float>(std::sin(zenith) * std::cos(kAzimuth_rad)),
                        static_cast<float>(std::cos(zenith))};
  plan.sky_components = solar;
  if (solar > 0) plan.sky_basis = test::factors_of(test::clear_sky(kZenith_deg), solar).basis;
  if (warm > 0) plan.thermal.on = true, plan.thermal.sky_components = warm, plan.thermal.basis = warm_sky();
  plan.sky = plan::make_sky_rays(plan.sky_basis, plan.thermal, kAzimuth_rad, plan.sun_direction, rays);
  plan.sky.open_share = open_share;
  return plan;
}

/// Components of a sample, and what its rays could bring at most of any: by which rounding is told.
struct Met {
  double sum[8] = {}, size = 0;
  int rays = 0;
};

/// Every sample's of a pixel, on the points and normals that the device found.
std::vector<Met> met_of_pixel(const scene::CompiledScene& scene, const test::DoubleTracer& oracle,
                              const plan::Plan& plan, const TraceShape& shape, std::uint32_t pixel,
                              const std::vector<std::uint32_t>& hits, const std::vector<float>& surface) {
  const auto nu = rc_u32(shape.nu), nv = rc_u32(shape.nv), samples = nu * nv, rays = rc_u32(plan.sky.rays);
  std::vector<Met> out(samples);
  for (rc_u32 part = 0; part < rc_sky_parts(samples, rays); ++part) {
    const SkyPart share = rc_sky_shares(shape.sampler, nu, nv, rays, shape.seed, pixel, part);
    for (rc_u32 i = 0; i < share.rays; ++i) {
      const rc_u32 s = rc_sky_sample(share, nu, samples, rays, shape.seed, pixel, part, i);
      const std::uint32_t primitive = hits[shape.hits_at(pixel, RC_HIT_PRIMITIVE, s)];
      if (primitive == RC_NONE) continue;
      constexpr std::size_t n = RC_WORD;
      const float* at = surface.data() + shape.surface_at(pixel, 0, s);
      const ::SkyRay ray = rc_sky_ray(plan::sky_density(plan), shape.seed, pixel, rc_sky_number(samples, rays, part, i),
                                      at[RC_NORMAL_X * n], at[RC_NORMAL_Y * n], at[RC_NORMAL_Z * n]);
      ++out[s].rays;
      if (!(ray.facing > 0) || !(ray.z > 0)) continue;
      const double point[3] = {at[RC_POINT_X * n], at[RC_POINT_Y * n], at[RC_POINT_Z * n]};
      const float way[3] = {ray.x, ray.y, ray.z};
      const double open = oracle.blocked(point, way) ? 0 : 1;
      const double known = double{kOpenShares[scene.blocks[primitive / RC_BLOCK].surface[primitive % RC_BLOCK]]};
      const auto light = reference::sky_light(plan, {ray.x, ray.y, ray.z});
      const double weight = double{share.scale} * double{ray.facing} / double{ray.density};
      double largest = 0;
      for (std::size_t m = 0; m < 8; ++m) {
        out[s].sum[m] += weight * (open - known) * light[m], largest = std::max(largest, std::abs(light[m]));
      }
      out[s].size += weight * largest;
    }
  }
  return out;
}

}  // namespace

TEST_CASE("S8 S16 met sky is the same rays' sum in double: solar components, thermal ones and surroundings") {
  const auto scene = hills_with_balls();
  const test::DoubleTracer oracle(scene);
  struct Case {
    int sampler, nu, nv, solar, warm, rays;
  };
  for (const Case c : {Case{RC_SAMPLER_GRID, 5, 5, 4, 0, 25}, Case{RC_SAMPLER_LATTICE, 4, 4, 2, 2, 40},
                       Case{RC_SAMPLER_JITTERED, 3, 2, 0, 1, 5}, Case{RC_SAMPLER_GRID, 1, 2, 3, 1, 2},
                       Case{RC_SAMPLER_GRID, 4, 3, 1, 0, 200}}) {
    INFO("sampler " << c.sampler << ", " << c.nu << " x " << c.nv << " samples, " << c.rays << " rays, components "
                    << c.solar << " + " << c.warm);
    TraceShape shape;
    shape.nu = c.nu, shape.nv = c.nv, shape.sampler = c.sampler;
    shape.thermal_components = c.warm > 0 ? c.warm + 1 : 0;
    shape.components = c.solar + shape.thermal_components;
    shape.columns = shape.pixels_per_line = 18, shape.lines = 10;
    const auto groups = test::nadir_groups(shape, 0, 0, 300, 1.7, 300, 0.02);
    const auto plan = sky_plan(c.solar, c.warm, c.rays, {kOpenShares, kOpenShares + 3});
    REQUIRE(plan.components() == shape.components);
    test::TraceChain chain(first_context(), scene, shape);
    const auto hits = chain.primary(groups);
    const auto surface = chain.surface(), met = chain.sky(plan);
    std::size_t wrong = 0, unasked = 0, sent = 0, brought = 0;
    double worst = 0;
    for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel) {
      const auto expected = met_of_pixel(scene, oracle, plan, shape, pixel, hits, surface);
      for (std::uint32_t s = 0; s < shape.elements().padded; ++s)
        for (int m = 0; m < RC_SKY_PLANES_OF(shape.components); ++m) {
          const float found = met[shape.met_sky_at(pixel, std::size_t(m), s)];
          if (s >= shape.samples() || m >= shape.components || expected[s].rays == 0) {
            unasked += found != 0;
            continue;
          }
          const double apart = std::abs(double{found} - expected[s].sum[m]), size = expected[s].size;
          sent += m == 0 ? std::size_t(expected[s].rays) : 0;
          brought += found != 0;
          if (size > 0) worst = std::max(worst, apart / size);
          // A float's rounding of the direction's zenith angle moves a map near the sun by 1e-6 of itself.
          wrong += apart > 5e-6 * size;
        }
    }
    MESSAGE("rays " << sent << ", worst difference " << worst << " of what a sample's rays could bring");
    CHECK(wrong == 0);
    CHECK(unasked == 0);
    CHECK(sent > 300);
    CHECK(brought > 100);
  }
}

TEST_CASE("S8 S16 met sky is the same for all samples at once, in any chunks, and whatever the group") {
  const auto scene = hills_with_balls();
  TraceShape shape;
  shape.nu = shape.nv = 7;
  shape.components = 2;
  shape.columns = shape.pixels_per_line = 18, shape.lines = 10;
  const auto groups = test::nadir_groups(shape, 0, 0, 300, 1.7, 300, 0.02);
  test::TraceChain whole(first_context(), scene, shape);
  whole.primary(groups), whole.surface();
  constexpr std::uint32_t kChunk = 21;  // three rows
  TraceShape part = shape;
  part.chunk = kChunk;
  test::TraceChain chunked(first_context(), scene, part);
  for (const int rays : {1, 16, 49, 300}) {
    CAPTURE(rays);
    const auto plan = sky_plan(2, 0, rays, {kOpenShares, kOpenShares + 3});
    const auto met = whole.sky(plan);
    std::size_t other = 0, brought = 0;
    for (std::uint32_t first = 0; first < shape.samples(); first += kChunk) {
      chunked.primary(groups, first), chunked.surface();
      const auto found = chunked.sky(plan);
      for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
        for (std::size_t m = 0; m < 2; ++m)
          for (std::uint32_t s = first; s < std::min(first + kChunk, shape.samples()); ++s) {
            const float at_once = met[shape.met_sky_at(pixel, m, s)];
            other += found[part.met_sky_at(pixel, m, s - first)] != at_once;
            brought += at_once != 0;
          }
    }
    CHECK(other == 0);
    CHECK(brought > 50);
  }
}

TEST_CASE(
    "S8 open ground that takes its whole sky for granted is brought nothing, to the bit: the park's court lines") {
  scene::CompiledScene scene;
  scene::append_instance(scene, scene::append_mesh(scene, "court lines", test::court_lines()),
                         test::placement(0, 0, 1, 118, 76, 3.41), 0);
  scene::finish_top_tree(scene);
  TraceShape shape;
  shape.nu = shape.nv = 8;
  shape.components = 4;
  shape.pixels_per_line = 284, shape.lines = 284, shape.first_column = 140, shape.columns = 4;
  test::TraceChain chain(first_context(), scene, shape);
  const auto hits = chain.primary(test::nadir_groups(shape, 125.5, 76, 613.4, 0.1, 610, 0));
  chain.surface();
  const auto on_line = [&] {
    std::size_t count = 0;
    for (std::uint32_t pixel = 0; pixel < shape.pixels(); ++pixel)
      for (std::uint32_t s = 0; s < shape.samples(); ++s)
        count += hits[shape.hits_at(pixel, RC_HIT_INSTANCE, s)] != RC_NONE;
    return count;
  }();
  CHECK(on_line > 10'000);
  const auto open = chain.sky(sky_plan(4, 0, 512, {1.0f}));
  CHECK(std::count_if(open.begin(), open.end(), [](float met) { return met != 0; }) == 0);
  const auto half = chain.sky(sky_plan(4, 0, 512, {0.5f}));
  CHECK(std::count_if(half.begin(), half.end(), [](float met) { return met != 0; }) > 10'000);
}
