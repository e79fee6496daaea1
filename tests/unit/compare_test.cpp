// The comparison must pass what is right, explain what is a tie, and fail on everything else: a device made from the
// reference's own numbers, rounded to fp32, then spoiled.
#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <csignal>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/reference/compare.h"
#include "host/base/parallel.h"
#include "tests/oracle/reference_plan.h"
#include "tests/oracle/reference_scene.h"

using namespace raycube;
using namespace raycube::reference;
using namespace raycube::test;

namespace {

struct Fixture {
  scene::CompiledScene compiled;
  plan::Plan plan = sun_plan(40, 270);
  NadirPixel at[3] = {nadir_pixel(1.5, 0, 100, 1), nadir_pixel(2.5, 0, 100, 1), nadir_pixel(-3, 0.3, 100, 1)};

  Fixture() {
    SceneBuilder builder;
    const std::uint32_t ground = builder.material("ground", {0.3, 1.0}, {0.2, 0.4}),
                        roof = builder.material("roof", {0.3, 1.0}, {0.5, 0.5});
    std::vector<Triangle> list;
    add_quad(list, {-50, -60, 0}, {100, 0, 0}, {0, 100, 0}, ground);
    add_box(list, {-1, -1, 0}, {1, 1, 2}, roof);
    builder.instance(builder.mesh(list));
    compiled = builder.finish();
    compiled.lo = {-50, -60, 0}, compiled.hi = {50, 40, 2};
    add_uniform_sky(plan, 33, 1600);
    for (std::size_t i = 0; i < 3; ++i) {
      at[i].instrument.pixels = 3;
      at[i].address.sample = static_cast<std::uint32_t>(i);
    }
  }

  /// turn: sample and its ray whose fate the "device" sees the other way.
  DevicePixel device(std::size_t i, int turn_sample = -1, int turn_ray = -1) const {
    const ReferenceScene scene(compiled);
    const SampledPixel pixel = scene.sample_pixel(at[i].instrument, plan, 9, at[i].address);
    DevicePixel out;
    out.address = at[i].address;
    const auto rays = numbered_rays(plan, at[i].instrument, 9, pixel.number);
    std::vector<SentRays> sent;
    for (const Sample& sample : pixel.samples) {
      out.hits.push_back(sample.hit);
      out.sun_visible.push_back(sample.sun_visible);
      sent.push_back(sent_rays(scene, plan, 9, pixel.number, sample, rays[sent.size()]));
    }
    if (turn_sample >= 0) {
      SentRay& ray = sent[static_cast<std::size_t>(turn_sample)][static_cast<std::size_t>(turn_ray)];
      ray.open = !ray.open;
    }
    for (const SentRays& of_sample : sent) {
      double met = 0;  // the sky's radiance is 1, and all of it is taken for granted
      for (const SentRay& ray : of_sample) met += ray.open ? 0 : -ray.weight;
      for (float value : {static_cast<float>(met), 0.0f, 0.0f, 0.0f}) out.sky_met.push_back(value);
    }
    const BandRadiance l = ArithmeticModel(compiled, plan).radiance(pixel, sent);
    for (std::size_t b = 0; b < plan.bands.size(); ++b) out.radiance.push_back(static_cast<float>(l.total(b)));
    return out;
  }

  Report compare(const std::vector<DevicePixel>& pixels) const {
    Comparison comparison(compiled, plan, at[0].instrument, 9, {});
    comparison.add(pixels);
    return comparison.report();
  }
};

}  // namespace

TEST_CASE("S61: equal numbers pass, with the rounding of float and nothing else") {
  const Fixture f;
  const Report report = f.compare({f.device(0), f.device(1), f.device(2)});
  CHECK(report.failures().empty());
  CHECK(report.pixels == 3);
  CHECK(report.rays == 300);
  CHECK(report.hits[0] == 300);
  CHECK(report.sky_rays == 4800);
  CHECK(report.sun_rays > 250);
  CHECK(report.worst < 6e-8);
  CHECK(report.worst > 0);
  const auto json = nlohmann::json::parse(report.json());
  CHECK(json["passed"] == true);
  CHECK(json["band_median"].size() == 2);
  const Picture picture = difference_picture(report);
  CHECK(picture.width == 2);
  CHECK(picture.height == 3);
  CHECK(picture.rgb.size() == 18);
}

TEST_CASE("S61: a spoiled device fails, each in its own line of the report") {
  const Fixture f;
  DevicePixel pixel = f.device(0);
  SUBCASE("radiance off by 1e-4 in one band of one pixel") {
    pixel.radiance[1] *= 1.0001f;
    const Report report = f.compare({pixel, f.device(1), f.device(2)});
    CHECK(report.beyond_pixels == 1);
    CHECK(report.worst_band == 1);
    CHECK(report.worst_sample == 0);
    CHECK(report.failures().size() == 1);
    CHECK(report.text({"a", "b"}).find("BEYOND LIMITS") != std::string::npos);
  }
  SUBCASE("radiance off by 3e-6 everywhere: the median tells") {
    std::vector<DevicePixel> all = {f.device(0), f.device(1), f.device(2)};
    for (DevicePixel& p : all)
      for (float& value : p.radiance) value *= 1.000003f;
    const Report report = f.compare(all);
    CHECK(report.beyond_pixels == 0);
    CHECK(report.failures().size() == 1);
  }
  SUBCASE("not a number") {
    pixel.radiance[0] = NAN;
    CHECK(f.compare({pixel}).beyond_pixels == 1);
  }
  SUBCASE("a hit on another triangle") {
    pixel.hits[50].primitive ^= 1u;  // the ground's other half
    const Report report = f.compare({pixel});
    CHECK(report.hits[static_cast<std::size_t>(Cause::unexplained)] == 1);
    CHECK(report.excluded_pixels == 1);
    CHECK(!report.failures().empty());
  }
  SUBCASE("a hit lost") {
    pixel.hits[50] = {};
    const Report report = f.compare({pixel});
    CHECK(report.hit_miss == 1);
    CHECK(!report.failures().empty());
  }
  SUBCASE("sun in the shadow") {
    pixel.sun_visible[50] = !pixel.sun_visible[50];
    const Report report = f.compare({pixel});
    CHECK(report.sun_unexplained == 1);
    CHECK(!report.failures().empty());
  }
  SUBCASE("a sky ray turned that is no tie") {
    const Report report = f.compare({f.device(2, 50, 3)});
    CHECK(report.sky_unexplained == 1);
    CHECK(report.excluded_pixels == 1);
    CHECK(!report.failures().empty());
  }
  SUBCASE("no pixels at all") { CHECK(!f.compare({}).failures().empty()); }
  SUBCASE("rows of the wrong length are our bug") {
    pixel.radiance.pop_back();
    CHECK_THROWS_AS(f.compare({pixel}), base::Error);
  }
}

TEST_CASE("S61: first hits alone: every ray counted, a spoiled one named, double asked whether each hits at all") {
  const Fixture f;
  const ReferenceScene scene(f.compiled);
  std::vector<PixelHits> pixels;
  for (std::size_t i = 0; i < 3; ++i) {
    PixelHits& pixel = pixels.emplace_back(PixelHits{f.at[i].address, {}});
    for (const Sample& sample : scene.sample_pixel(f.at[i].instrument, f.plan, 9, f.at[i].address).samples)
      pixel.hits.push_back(sample.hit);
  }
  const auto compare = [&] {
    HitComparison comparison(f.compiled, f.at[0].instrument, 9);
    comparison.add(pixels);
    return comparison.report();
  };
  const HitReport good = compare();
  CHECK(good.rays == 300);
  CHECK(good.of(Cause::agree) == 300);
  CHECK(good.explained() + good.hit_miss + good.hit_miss_double + good.unexplained.size() == 0);
  SUBCASE("another triangle") { pixels[1].hits[7].primitive ^= 1u; }
  SUBCASE("a miss") { pixels[1].hits[7] = {}; }
  SUBCASE("a triangle that is none") { pixels[1].hits[7] = {9, 1u << 20}; }
  if (pixels[1].hits[7] == scene.sample_pixel(f.at[1].instrument, f.plan, 9, f.at[1].address).samples[7].hit) return;
  const HitReport bad = compare();
  const bool lost = pixels[1].hits[7].miss();
  CHECK(bad.of(Cause::agree) == 299);
  CHECK(bad.of(Cause::unexplained) == 1);
  CHECK(bad.hit_miss == (lost ? 1 : 0));
  CHECK(bad.hit_miss_double == (lost ? 1 : 0));
  REQUIRE(bad.unexplained.size() == 1);
  CHECK(bad.unexplained[0].sample == 1);
  CHECK(bad.unexplained[0].ray == 7);
  CHECK(bad.unexplained[0].device == pixels[1].hits[7]);
  CHECK(bad.unexplained[0].embree == bad.unexplained[0].exact);
  Report report = f.compare({f.device(0)});
  REQUIRE(report.failures().empty());
  report.first_hits = bad;
  REQUIRE(report.failures().size() == 1);
  CHECK(report.failures()[0].find("line 0, sample 1, ray 7") != std::string::npos);
  const auto json = nlohmann::json::parse(report.json())["first_hits"];
  CHECK(json["rays"] == 300);
  CHECK(json["unexplained"] == 1);
  CHECK(json["unexplained_rays"][0]["ray"] == 7);
  CHECK(json["unexplained_rays"][0]["device"].is_null() == lost);
  pixels[2].hits.pop_back();
  CHECK_THROWS_AS(compare(), base::Error);
}

TEST_CASE("S61: of many unexplained rays the report names the first by place") {
  HitReport all;
  for (std::uint32_t line = 40; line-- > 0;) {
    HitReport one;
    one.rays = 10;
    one.hits[static_cast<std::size_t>(Cause::agree)] = 7;
    one.hits[static_cast<std::size_t>(Cause::edge_tie)] = 2;
    one.hits[static_cast<std::size_t>(Cause::unexplained)] = 1;
    one.unexplained.push_back({line, 3, 5, {}, {}, {}});
    all.add(one);
  }
  CHECK(all.rays == 400);
  CHECK(all.explained() == 80);
  CHECK(all.explained_share() == 0.2);
  REQUIRE(all.unexplained.size() == HitReport::kMostNamed);
  CHECK(all.unexplained[0].line == 0);
  CHECK(all.unexplained.back().line == HitReport::kMostNamed - 1);
}

TEST_CASE("S61: ties fall either way and are counted: sun on a shadow's edge, a sky ray over a box's edge") {
  Fixture f;
  // The box's upper edge x = 1, z = 2 throws its shadow's edge onto the middle column of samples of pixel 0.
  const double reach = 1 + 2 * std::tan(40 * kPi / 180);
  f.at[0] = nadir_pixel(reach, 0, 100, 1, 11);
  f.at[0].instrument.pixels = 3;
  DevicePixel pixel = f.device(0);
  const std::size_t edge = 5 * 11 + 5;
  pixel.sun_visible[edge] = !pixel.sun_visible[edge];
  const ReferenceScene scene(f.compiled);
  const SampledPixel traced = scene.sample_pixel(f.at[0].instrument, f.plan, 9, f.at[0].address);
  const auto rays = numbered_rays(f.plan, f.at[0].instrument, 9, traced.number);
  std::vector<SentRays> sent;
  for (const Sample& sample : traced.samples)
    sent.push_back(sent_rays(scene, f.plan, 9, traced.number, sample, rays[sent.size()]));
  SampledPixel turned = traced;
  turned.samples[edge].sun_visible = !turned.samples[edge].sun_visible;
  const BandRadiance l = ArithmeticModel(f.compiled, f.plan).radiance(turned, sent);
  for (std::size_t b = 0; b < 2; ++b) pixel.radiance[b] = static_cast<float>(l.total(b));
  const Report sun = f.compare({pixel});
  CHECK(sun.sun_explained == 1);
  CHECK(sun.failures().empty());

  // Beside the box's foot: the point is moved to where one of its rays passes the upper edge x = 1, z = 2 exactly. The
  // ray does not depend on the point, since the ground is level.
  Fixture g;
  const auto one_sample = [&](double x) {
    g.at[0] = nadir_pixel(x, 0, 100, 0.2, 1);
    g.at[0].instrument.pixels = 3;
  };
  one_sample(2);
  const ReferenceScene beside(g.compiled);
  const SampledPixel single = beside.sample_pixel(g.at[0].instrument, g.plan, 9, g.at[0].address);
  const SentRays sky = sent_rays(beside, g.plan, 9, single.number, single.samples[0],
                                 numbered_rays(g.plan, g.at[0].instrument, 9, single.number)[0]);
  const auto passes = [](const SentRay& ray) {  // towards the box, over the middle of its edge
    return ray.direction.x < -0.2 && ray.direction.z > 0.5 && std::abs(ray.direction.y) < 0.2;
  };
  const auto at = std::find_if(sky.begin(), sky.end(), passes);
  REQUIRE(at != sky.end());
  one_sample(1 - 2 * at->direction.x / at->direction.z);
  const int over_edge = static_cast<int>(at - sky.begin());
  const Report tie = g.compare({g.device(0, 0, over_edge)});
  CHECK(tie.sky_explained == 1);
  CHECK(tie.failures().empty());
  one_sample(2);  // here none of them is a tie
  const auto high = std::find_if(sky.begin(), sky.end(), [](const SentRay& ray) { return ray.direction.z > 0.95; });
  REQUIRE(high != sky.end());
  const Report plain = g.compare({g.device(0, 0, static_cast<int>(high - sky.begin()))});
  CHECK(plain.sky_unexplained == 1);
  CHECK(!plain.failures().empty());
}

TEST_CASE("S61: a signal stops the comparison of a pixel") {
  base::install_signal_handlers();
  Fixture f;
  std::raise(SIGTERM);
  CHECK_THROWS_AS(f.compare({f.device(0)}), base::Error);
  base::clear_interrupt();
  std::atomic<int> done{0};
  std::atomic<bool> raised{false};  // later items wait for it: nothing else says which thread comes first
  CHECK_THROWS_AS(base::for_each_index(1000, 2,
                                       [&](std::size_t i) {
                                         ++done;
                                         if (i == 3) {
                                           std::raise(SIGTERM);
                                           raised = true;
                                         }
                                         while (i > 3 && !raised) std::this_thread::yield();
                                       }),
                  base::Error);
  CHECK(done < 1000);
  base::clear_interrupt();
  CHECK(f.compare({f.device(0)}).failures().empty());
}
