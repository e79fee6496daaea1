// Closed forms of the reference itself. Geometry: small scenes around the origin, camera straight above, sun and sky of
// unit strength, so that the expected radiance is a number one can write down. Rays and vertices are fp32: tolerances
// of 1e-6 are their rounding (2^-24 each, a dozen of them); everything else is double.
#include <doctest/doctest.h>

#include "host/base/error.h"
#include "host/reference/radiance.h"
#include "host/sensors/psf.h"
#include "tests/oracle/reference_plan.h"
#include "tests/oracle/reference_scene.h"

using namespace raycube;
using namespace raycube::reference;
using namespace raycube::test;
using doctest::Approx;

namespace {

BandRadiance render(const scene::CompiledScene& compiled, const plan::Plan& plan, const NadirPixel& pixel,
                    std::uint64_t seed = 1) {
  const ReferenceScene scene(compiled);
  const SampledPixel traced = scene.sample_pixel(pixel.instrument, plan, seed, pixel.address);
  const auto rays = numbered_rays(plan, pixel.instrument, seed, traced.number);
  std::vector<SentRays> sent;
  for (const Sample& sample : traced.samples)
    sent.push_back(sent_rays(scene, plan, seed, traced.number, sample, rays[sent.size()]));
  return ArithmeticModel(compiled, plan).radiance(traced, sent);
}

/// A 40 m plane through the origin, turned about the y axis so that its normal is (sin, 0, cos).
scene::CompiledScene tilted_plane(double sine, double cosine, double rho) {
  SceneBuilder builder;
  const std::uint32_t surface = builder.material("grey", {0.3, 1.0}, {rho, rho});
  std::vector<Triangle> list;
  const glm::vec3 along(static_cast<float>(cosine), 0, static_cast<float>(-sine));
  add_quad(list, -20.0f * along - glm::vec3(0, 20, 0), 40.0f * along, {0, 40, 0}, surface);
  builder.instance(builder.mesh(list));
  return builder.finish();
}

}  // namespace

TEST_CASE("S15: tilted Lambertian plane under the sun, L = rho E cos / pi") {
  for (double tilt_deg : {0.0, 20.0, 50.0}) {
    const double tilt = tilt_deg * kPi / 180;
    const plan::Plan plan = sun_plan(30, 90);  // sun in the east, where the plane leans
    const BandRadiance l = render(tilted_plane(std::sin(tilt), std::cos(tilt), 0.37), plan, nadir_pixel(0, 0, 100, 1));
    const double expected = 0.37 * std::cos(tilt - 30 * kPi / 180) / kPi;
    CHECK(l.sun[0] == Approx(expected).epsilon(1e-6));
    CHECK(l.sun[1] == Approx(expected).epsilon(1e-6));
    CHECK(l.sky[0] == 0);
    CHECK(l.path[0] == 0);
  }
  // Turned away from the sun by more than 90 degrees: dark.
  CHECK(render(tilted_plane(std::sin(1.2), std::cos(1.2), 0.37), sun_plan(80, 270), nadir_pixel(0, 0, 100, 1)).sun[0] ==
        0);
}

TEST_CASE("S16: tilted plane under a uniform sky, E = pi (1 + cos b) / 2") {
  // Tilts on the nodes of the 65-node map, where the map is exact: sin b / (sin b + cos b) = k / 32.
  for (int k : {0, 8, 16, 29}) {
    const double tilt = std::atan2(static_cast<double>(k), static_cast<double>(32 - k));
    plan::Plan plan = sun_plan();
    plan.sun_up = false;
    add_uniform_sky(plan, 65, 16);
    const BandRadiance l = render(tilted_plane(std::sin(tilt), std::cos(tilt), 0.5), plan, nadir_pixel(0, 0, 100, 1));
    // Where the plane's own backside would hide a direction, n.d < 0: nothing is subtracted.
    CHECK(l.sky[0] == Approx(0.5 * (1 + std::cos(tilt)) / 2).epsilon(1e-6));
    CHECK(l.sun[0] == 0);
  }
}

TEST_CASE("S16: irradiance map between nodes: linear functions of the octahedron are kept exactly, both halves") {
  plan::IrradianceMap map;
  map.size = 9;
  for (int j = 0; j < 9; ++j)
    for (int i = 0; i < 9; ++i) {
      const double u = i / 4.0 - 1, v = j / 4.0 - 1, z = 1 - std::abs(u) - std::abs(v);
      const double x = z < 0 ? (1 - std::abs(v)) * (u < 0 ? -1 : 1) : u,
                   y = z < 0 ? (1 - std::abs(u)) * (v < 0 ? -1 : 1) : v;
      map.value.push_back(
          {static_cast<float>(2 + x + 3 * y + 5 * z), static_cast<float>(z), static_cast<float>(std::abs(x)), 1});
    }
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2000; ++i) {
    const double a = normal(random), b = normal(random);
    const glm::dvec3 n = glm::normalize(glm::dvec3(a, b, normal(random)));
    const glm::dvec3 p = n / (std::abs(n.x) + std::abs(n.y) + std::abs(n.z));
    const auto value = unoccluded_irradiance(map, n);
    CHECK(value[0] == Approx(2 + p.x + 3 * p.y + 5 * p.z).epsilon(1e-6));
    CHECK(std::abs(value[1] - p.z) < 1e-6);
    CHECK(std::abs(value[2] - std::abs(p.x)) < 1e-6);
    CHECK(value[3] == Approx(1).epsilon(1e-12));
  }
  map.size = 8;
  CHECK_THROWS_AS(unoccluded_irradiance(map, {0, 0, 1}), base::Error);
}

TEST_CASE("S15 S16: sky beside a wall against the closed view factor") {
  // Floor point 2 m from the foot of a wall 3 m high and 40 m long, uniform sky. View factor of a horizontal element to
  // a perpendicular rectangle of height a, width b from its foot, distance c (Howell, catalogue B-4):
  //   F = (1/2 pi) [atan(b/c) - c/sqrt(a^2+c^2) atan(b/sqrt(a^2+c^2))], twice for both halves of the wall.
  SceneBuilder builder;
  const std::uint32_t surface = builder.material("grey", {0.3, 1.0}, {0.5, 0.5});
  std::vector<Triangle> list;
  add_quad(list, {-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, surface);
  add_quad(list, {2, -20, 0}, {0, 40, 0}, {0, 0, 3}, surface);
  builder.instance(builder.mesh(list));
  const double a = 3, b = 20, c = 2, s = std::sqrt(a * a + c * c);
  const double wall = 2 * (std::atan(b / c) - c / s * std::atan(b / s)) / (2 * kPi);
  plan::Plan plan = sun_plan();
  plan.sun_up = false;
  const int rays = 20000;
  add_uniform_sky(plan, 65, rays);
  const BandRadiance l = render(builder.finish(), plan, nadir_pixel(0, 0, 100, 0.001, 1));
  // A lattice of N points misses the area under one edge by about N^-3/4: 6e-4 of the hemisphere.
  CHECK(l.sky[0] == Approx(0.5 * (1 - wall)).epsilon(1.2e-3));
  CHECK(wall == Approx(0.2215).epsilon(1e-3));
}

TEST_CASE("S26 S43: a checkerboard's samples carry the exact area where cell edges fall between samples") {
  SceneBuilder builder;
  const std::uint32_t dark = builder.material("dark", {0.3, 1.0}, {0.1, 0.1}),
                      bright = builder.material("bright", {0.3, 1.0}, {0.8, 0.8});
  std::vector<Triangle> list;
  for (int j = -4; j < 4; ++j)
    for (int i = -4; i < 4; ++i)
      add_quad(list, {0.5f * static_cast<float>(i), 0.5f * static_cast<float>(j), 0}, {0.5f, 0, 0}, {0, 0.5f, 0},
               (i + j) % 2 ? dark : bright);
  builder.instance(builder.mesh(list));
  const scene::CompiledScene scene = builder.finish();
  // The pixel reaches 0.3 m over one column and 0.5 + 0.2 m over the next two, likewise in y: areas by hand.
  const NadirPixel pixel = nadir_pixel(0.2, 0.2, 100, 1);
  const double columns_even = 0.3 + 0.2, columns_odd = 0.5;  // cells -1 (0.3), 0 (0.5), 1 (0.2)
  const double bright_area = columns_odd * columns_odd + columns_even * columns_even;
  CHECK(render(scene, sun_plan(), pixel).sun[0] ==
        Approx((0.8 * bright_area + 0.1 * (1 - bright_area)) / kPi).epsilon(1e-6));
  const double phase = 0.3;  // x only: 0.2 | 0.5 | 0.3 by y as before
  CHECK(render(scene, sun_plan(), nadir_pixel(phase, 0.2, 100, 1)).sun[0] == Approx(0.45 / kPi).epsilon(1e-6));
}

TEST_CASE("S15 S26: shadow of a box ends where the sun says") {
  SceneBuilder builder;
  const std::uint32_t surface = builder.material("grey", {0.3, 1.0}, {0.5, 0.5});
  std::vector<Triangle> list;
  add_quad(list, {-50, -60, 0}, {100, 0, 0}, {0, 100, 0}, surface);  // its diagonal passes no sample
  add_box(list, {-1, -1, 0}, {1, 1, 2}, surface);
  builder.instance(builder.mesh(list));
  const scene::CompiledScene compiled = builder.finish();
  const ReferenceScene scene(compiled);
  const plan::Plan plan = sun_plan(40, 270);  // sun in the west: the shadow lies east, from x = 1 to 1 + 2 tan 40
  const double reach = 1 + 2 * std::tan(40 * kPi / 180);
  const SampledPixel pixel =
      scene.sample_pixel(nadir_pixel(2, 0, 100, 4, 40).instrument, plan, 1, nadir_pixel(2, 0, 100, 4, 40).address);
  int lit = 0, dark = 0;
  for (const Sample& sample : pixel.samples) {
    if (sample.point.z > 0.5) {  // the roof is lit
      CHECK(sample.sun_visible);
      continue;
    }
    const bool shadow = sample.point.x > 1 && sample.point.x < reach && std::abs(sample.point.y) < 1;
    CHECK(sample.sun_visible == !shadow);
    CHECK(scene.sees_in_double(sample, to_double(plan.sun_direction)) ==
          (shadow ? Visibility::blocked : Visibility::visible));
    ++(shadow ? dark : lit);
  }
  CHECK(dark > 100);
  CHECK(lit > 100);
}

TEST_CASE("S15: path radiance alone, linear between height, view and azimuth nodes; none without air") {
  plan::Plan plan = sun_plan();
  plan.sun_up = false;
  plan.height = {0, 100, 2};
  plan.path_x = {-0.5f, 1, 2};
  plan.source_spectrum.assign(2, std::vector<double>(5, 1 / kPi));
  // channel (h, y, x): 10 h + x + wavelength
  plan.path_spectrum.clear();
  for (int h = 0; h < 2; ++h)
    for (int x = 0; x < 2; ++x)
      plan.path_spectrum.push_back(
          {10.0 * h + x + 0.4, 10.0 * h + x + 0.5, 10.0 * h + x + 0.6, 10.0 * h + x + 0.7, 10.0 * h + x + 0.8});
  SceneBuilder builder;
  const std::uint32_t surface = builder.material("black", {0.3, 1.0}, {0, 0});
  std::vector<Triangle> list;
  add_quad(list, {-20, -20, 25}, {40, 0, 0}, {0, 40, 0}, surface);
  builder.instance(builder.mesh(list));
  const scene::CompiledScene scene = builder.finish();
  const BandRadiance l = render(scene, plan, nadir_pixel(0, 0, 125, 1));
  CHECK(l.path[0] == Approx(10 * 0.25 + 0.5 + 0.5).epsilon(1e-6));  // z = 25: a quarter; x = 0: half; band centre 0.5
  CHECK(l.path[1] == Approx(10 * 0.25 + 0.5 + 0.7).epsilon(1e-6));
  CHECK(l.sun[0] + l.sky[0] == 0);
  SUBCASE("a ray that meets nothing: path to the lowest node, no material") {
    const BandRadiance miss = render(scene, plan, nadir_pixel(1000, 0, 125, 1));
    CHECK(miss.path[0] == Approx(0.5 + 0.5).epsilon(1e-6));
    CHECK(miss.sun[0] + miss.sky[0] == 0);
  }
  SUBCASE("half a pixel over the edge") {
    const BandRadiance half = render(scene, plan, nadir_pixel(20, 0, 125, 1));
    CHECK(half.path[0] == Approx(10 * 0.125 + 0.5 + 0.5).epsilon(1e-6));
  }
  SUBCASE("vacuum") {
    const BandRadiance none = render(scene, sun_plan(), nadir_pixel(0, 0, 125, 1));
    CHECK(none.total(0) == 0);  // black plane, no air
  }
}

TEST_CASE("S15: reflected sun, linear between height and view nodes; mixed surfaces; curves over wavelength") {
  plan::Plan plan = sun_plan();
  plan.height = {0, 100, 2};
  plan.view = {1, 0.5f, 2};
  plan.source_spectrum.clear();
  for (int h = 0; h < 2; ++h)
    for (int v = 0; v < 2; ++v) plan.source_spectrum.push_back(std::vector<double>(5, 1 + 4.0 * h + 2.0 * v));
  plan.path_spectrum.assign(2, std::vector<double>(5, 0.0));
  SceneBuilder builder;
  builder.material("ramp", {0.4, 0.8}, {0.0, 0.4});
  builder.material("flat", {0.3, 1.0}, {0.5, 0.5});
  shared::Surface mix{};
  mix.material[0] = 1, mix.material[1] = 2;
  mix.fraction[0] = 0.75f, mix.fraction[1] = 0.25f;
  builder.scene.surfaces.push_back(mix);
  std::vector<Triangle> list;
  add_quad(list, {-200, -200, 25}, {400, 0, 0}, {0, 400, 0}, 2);
  builder.instance(builder.mesh(list));
  NadirPixel pixel = nadir_pixel(0, 0, 125, 1);
  pixel.address.group.d0 = {0.75f, 0, -1, 0};  // sec = 1.25: half way between the view nodes
  const BandRadiance l = render(builder.finish(), plan, pixel);
  CHECK(l.sun[0] == Approx((0.75 * 0.1 + 0.25 * 0.5) * (1 + 4 * 0.25 + 2 * 0.5)).epsilon(1e-6));  // ramp at 0.5 um: 0.1
  CHECK(l.sun[1] == Approx((0.75 * 0.3 + 0.25 * 0.5) * (1 + 4 * 0.25 + 2 * 0.5)).epsilon(1e-6));
}

TEST_CASE("S17: a pixel that looks up is refused") {
  NadirPixel pixel = nadir_pixel(0, 0, 10, 1);
  pixel.address.group.d0 = {1, 0, 0, 0};
  CHECK_THROWS_AS(render(tilted_plane(0, 1, 0.5), sun_plan(), pixel), base::Error);
}

TEST_CASE("S43: sample weights of a blurred detector, independently of the renderer's") {
  scene::Instrument instrument;
  instrument.samples_u = 11, instrument.samples_v = 9;
  for (double w : sample_weights(instrument)) CHECK(w == Approx(1.0 / 99).epsilon(1e-12));
  instrument.psf_sigma_px = 0.4, instrument.psf_support_px = 3;
  const std::vector<double> ours = sample_weights(instrument);
  const std::vector<float> theirs = sensors::psf_weights(instrument);
  REQUIRE(ours.size() == theirs.size());
  double sum = 0;
  for (std::size_t i = 0; i < ours.size(); ++i) {
    sum += ours[i];
    CHECK(ours[i] == Approx(static_cast<double>(theirs[i])).epsilon(2e-7));
  }
  CHECK(sum == Approx(1).epsilon(1e-12));
}
