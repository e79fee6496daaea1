// Lamps seen by cameras (S6): the inverse square of the distance times the cosine, cones, surfaces, shadows, light
// through leaves, lamps drawn among several, and by way of a second surface. Oracles: closed forms.
#include <doctest/doctest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "atmos_tables/synthetic.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi, kReflectance = 0.4, kLeafR = 0.3, kLeafT = 0.25, kHeight_m = 300;
constexpr double kFlat_per_um = 2, kPower_W = 30;
constexpr double kPixel_m = 0.25;
constexpr int kPixels = 8;

/// As much at all wavelengths from 0.4 to 0.9 um.
scene::Lamp lamp_at(const glm::dvec3& at, scene::LampShape shape = scene::LampShape::point) {
  scene::Lamp lamp;
  lamp.name = "lamp", lamp.shape = shape, lamp.flux_W = kPower_W;
  lamp.position_m = {{at.x, at.y, at.z}};
  lamp.spectrum = {{0.4, 0.9}, {kFlat_per_um, kFlat_per_um}, 0};
  return lamp;
}

/// A floor of 400 m at night, seen from above, one sample in the middle of each pixel.
struct Floor {
  scene::Simulation simulation;
  std::uint32_t floor = 0, leaf = 0, board = 0;
  explicit Floor(int samples = 1) {
    floor = test::add_material(simulation.scene, "floor", kReflectance);
    leaf = test::add_material(simulation.scene, "leaf", kLeafR);
    auto& material = simulation.scene.materials[1];
    material.transmittance = {material.reflectance.wavelength_um,
                              std::vector<double>(material.reflectance.wavelength_um.size(), kLeafT)};
    board = test::add_material(simulation.scene, "board", 0.0);
    test::place(simulation.scene, level(0, 200, floor));
    simulation.instruments = {test::nadir_camera(kPixels, kPixels, kHeight_m, kPixel_m)};
    simulation.instruments[0].bands = test::gaussian_bands({0.55}, 0.01);
    simulation.instruments[0].samples_u = simulation.instruments[0].samples_v = samples;
    simulation.sun.zenith_deg = 120;
    simulation.atmosphere.none = true;
  }
  static scene::TriangleMesh level(double z, double half, std::uint32_t surface) {
    return test::rectangle({-half, -half, z}, {2 * half, 0, 0}, {0, 2 * half, 0}, surface);
  }
  test::Image render() {
    finish_top_tree(simulation.scene);
    atmos::UniformAir air;
    air.sun_zenith_deg = simulation.sun.zenith_deg;
    return test::render_image(simulation, atmos::uniform_table(air, atmos::wavelength_grid(0.5, 0.6, 0.01)));
  }
  /// Of level ground z m high that a pixel's middle sees, m.
  static glm::dvec3 middle(int line, int pixel, double z = 0) {
    const double scale = (kHeight_m - z) / kHeight_m * kPixel_m, half = 0.5 * (kPixels - 1);
    return {(pixel - half) * scale, (half - line) * scale, z};
  }
};

/// Largest error of an image that should have `curve / pi` times the irradiance, relative to the brightest pixel.
double worst(const test::Image& image, double curve, double z, const std::function<double(const glm::dvec3&)>& wanted) {
  double most = 0, brightest = 0;
  for (int line = 0; line < kPixels; ++line)
    for (int pixel = 0; pixel < kPixels; ++pixel) {
      const double want = curve / kPi * kFlat_per_um * wanted(Floor::middle(line, pixel, z));
      brightest = std::max(brightest, want);
      most = std::max(most, std::abs(static_cast<double>(image.at(line, pixel, 0)) - want));
    }
  return most / brightest;
}

/// Of a point of intensity I(cosine with straight down) on a level surface, on the side where the lamp is.
double of_point(const glm::dvec3& lamp, const glm::dvec3& at, const std::function<double(double)>& intensity) {
  const glm::dvec3 way = lamp - at;
  const double d = glm::length(way), cosine = std::abs(way.z) / d;
  return intensity(way.z / d) * cosine / (d * d);
}

double even(double) { return kPower_W / (4 * kPi); }

}  // namespace

// 1e-5: a dozen roundings of fp32, and those of places 1 m and more apart, 300 m below the sensor.
TEST_CASE("S6 lamps: a point falls off with the square of the distance, times the cosine") {
  for (const glm::dvec3& at : {glm::dvec3(0.3, -0.2, 1.5), glm::dvec3(-4, 2, 0.7)}) {
    Floor scene;
    scene.simulation.lamps = {lamp_at(at)};
    CHECK(worst(scene.render(), kReflectance, 0, [&](const glm::dvec3& p) { return of_point(at, p, even); }) < 1e-5);
  }
}

TEST_CASE("S6 lamps: the cones of a spot, and its flux") {
  const glm::dvec3 at(0.3, -0.2, 1.5);
  Floor scene;
  scene.simulation.lamps = {lamp_at(at, scene::LampShape::spot)};
  scene.simulation.lamps[0].cone_deg = {15, 30};
  const double inner = std::cos(15 * kPi / 180), outer = std::cos(30 * kPi / 180);
  const double largest = kPower_W / (2 * kPi * (1 - inner + (inner - outer) / 3));
  const auto cone = [&](double c) {
    return largest * std::pow(std::clamp((c - outer) / (inner - outer), 0.0, 1.0), 2);
  };
  // A cosine's rounding, 1e-7, between cones 0.1 apart.
  CHECK(worst(scene.render(), kReflectance, 0, [&](const glm::dvec3& p) { return of_point(at, p, cone); }) < 2e-5);
}

TEST_CASE("S6 lamps: a distribution by both angles, C0 north and C90 west of a lamp that shines down") {
  const glm::dvec3 at(0.1, 0.2, 1.5);
  Floor scene;
  scene.simulation.lamps = {lamp_at(at)};
  auto& light = scene.simulation.lamps[0].distribution;
  light.vertical_deg = {0, 90};
  light.horizontal_deg = {0, 90, 180, 270, 360};
  light.value = {1, 1, 0.2, 0.2, 0.6, 0.6, 0.4, 0.4, 1, 1};
  const auto image = scene.render();
  // Mean over C: 0.55, all the way from 0 to 90 degrees: 2 pi times that.
  const auto wanted = [&](const glm::dvec3& p) {
    const glm::dvec3 to = p - at;
    double c = std::atan2(-to.x, to.y) * 180 / kPi / 90;
    if (c < 0) c += 4;
    const double value[] = {1, 0.2, 0.6, 0.4, 1};
    const int low = std::min(3, static_cast<int>(c));
    const double of_c = value[low] + (c - low) * (value[low + 1] - value[low]);
    return of_point(at, p, [&](double) { return kPower_W / (2 * kPi * 0.55) * of_c; });
  };
  CHECK(worst(image, kReflectance, 0, wanted) < 3e-5);  // angles are rounded to 2e-6 of 90 degrees
}

TEST_CASE("S6 lamps: a disc on its axis, a rectangle over its corner") {
  const double h = 1.5, r = 1.0;
  const auto mean = [](const test::Image& image) {
    double sum = 0;
    for (const float value : image.radiance)
      sum += static_cast<double>(value) / static_cast<double>(image.radiance.size());
    return sum;
  };
  const auto on_one_spot = [](Floor& scene) {
    auto& camera = scene.simulation.instruments[0];
    camera.ifov_across_rad *= 0.01, camera.ifov_along_rad *= 0.01;
  };
  Floor disc(16);
  disc.simulation.lamps = {lamp_at({0, 0, h}, scene::LampShape::disc)};
  disc.simulation.lamps[0].size_m = {2 * r, 2 * r};
  on_one_spot(disc);
  // 16384 draws of a value that varies by a third: 0.3 % if they were independent.
  CHECK(mean(disc.render()) ==
        doctest::Approx(kReflectance / kPi * kFlat_per_um * kPower_W / (kPi * (r * r + h * h))).epsilon(2e-3));
  Floor panel(16);
  const double width = 2, length = 3, a = width / h, b = length / h;
  panel.simulation.lamps = {lamp_at({length / 2, width / 2, h}, scene::LampShape::rectangle)};
  panel.simulation.lamps[0].size_m = {width, length};  // the width along north
  on_one_spot(panel);
  const double factor = (a / std::hypot(1, a) * std::atan(b / std::hypot(1, a)) +
                         b / std::hypot(1, b) * std::atan(a / std::hypot(1, b))) /
                        (2 * kPi);  // Howell, A Catalog of Radiation Heat Transfer Configuration Factors, C-3
  CHECK(mean(panel.render()) ==
        doctest::Approx(kReflectance / kPi * kFlat_per_um * kPower_W / (width * length) * factor).epsilon(2e-3));
}

TEST_CASE("S6 lamps: what lies between is in the way, what lies behind the lamp is not") {
  const glm::dvec3 at(0, 0, 1.5);
  for (const double z : {1.0, 1.5, 2.0}) {  // the middle one: on the board's own plane
    Floor scene;
    scene.simulation.lamps = {lamp_at(at)};
    test::place(scene.simulation.scene, test::rectangle({0.02, -3, z}, {3, 0, 0}, {0, 6, 0}, scene.board));
    const auto image = scene.render();
    for (int line = 0; line < kPixels; ++line)
      for (int pixel = 0; pixel < kPixels / 2; ++pixel) {  // beside the board
        const glm::dvec3 p = Floor::middle(line, pixel);
        const double want = kReflectance / kPi * kFlat_per_um * of_point(at, p, even);
        CHECK(image.at(line, pixel, 0) == doctest::Approx(want).epsilon(1e-5));
      }
  }
  Floor shaded;
  shaded.simulation.lamps = {lamp_at(at)};
  test::place(shaded.simulation.scene, test::rectangle({-0.4, -0.4, 1.2}, {0.8, 0, 0}, {0, 0.8, 0}, shaded.board));
  const auto image = shaded.render();  // its shadow is 2 m from the middle to each side, wider than the image
  for (const float value : image.radiance) CHECK(value == 0);
}

TEST_CASE("S6 S23 lamps: light comes through a leaf from a lamp below it") {
  const glm::dvec3 at(0.3, 0.1, 1.5);
  Floor scene;
  scene.simulation.lamps = {lamp_at(at)};
  test::place(scene.simulation.scene, Floor::level(2.2, 20, scene.leaf));
  CHECK(worst(scene.render(), kLeafT, 2.2, [&](const glm::dvec3& p) { return of_point(at, p, even); }) < 1e-5);
}

TEST_CASE("S6 lamps: one of several is drawn by what it sends, and stands for all") {
  const glm::dvec3 near(0.3, -0.2, 1.5), far(-3, 2, 2.5);
  Floor scene;
  scene.simulation.lamps = {lamp_at(near), lamp_at(far)};
  const auto both = [&](const glm::dvec3& p) { return of_point(near, p, even) + of_point(far, p, even); };
  CHECK(worst(scene.render(), kReflectance, 0, both) < 1e-5);  // in the open whichever is drawn says the same
  // A board hides the far one: the near one, drawn by chance, has to stand for itself alone.
  Floor half(16);
  half.simulation.lamps = scene.simulation.lamps;
  test::place(half.simulation.scene, test::rectangle({-2.5, -3, 0.1}, {0, 6, 0}, {0, 0, 5}, half.board));
  const auto image = half.render();
  double found = 0, wanted = 0;
  for (int line = 0; line < kPixels; ++line)
    for (int pixel = 0; pixel < kPixels; ++pixel) {
      found += static_cast<double>(image.at(line, pixel, 0));
      wanted += kReflectance / kPi * kFlat_per_um * of_point(near, Floor::middle(line, pixel), even);
    }
  // The middle of a pixel for all of it: (0.25 m / 1.5 m)^2 / 12 and less; and 16384 draws of 0 or 1.3: 0.4 % if
  // they were independent.
  CHECK(found == doctest::Approx(wanted).epsilon(6e-3));
}

TEST_CASE("S6 LIGHT 2 lamps: from a spot to the floor, to a leaf above it and through it") {
  Floor scene(8);
  scene.simulation.lamps = {lamp_at({0.3, 0.1, 2.5}, scene::LampShape::spot)};
  scene.simulation.lamps[0].cone_deg = {50, 60};
  scene.simulation.lamps.push_back(scene.simulation.lamps[0]);
  scene.simulation.lamps[1].spectrum = {{0.7, 0.9}, {5, 5}, 0};  // seen by no band: a source less
  scene.simulation.lamps.push_back(scene.simulation.lamps[0]);
  scene.simulation.lamps[2].spectrum = {{0.5, 0.6}, {10, 10}, 0};  // a source more, five times as bright in the band
  test::place(scene.simulation.scene, Floor::level(3, 50, scene.leaf));
  auto& camera = scene.simulation.instruments[0];
  camera = test::nadir_camera(40, 40, kHeight_m, 2.5);
  camera.bands = test::gaussian_bands({0.55}, 0.01);
  camera.samples_u = camera.samples_v = 8;
  scene.simulation.bounces = 1, scene.simulation.bounces_given = true;
  scene.simulation.sky_directions = 4096;
  const auto image = scene.render();
  double found = 0;
  for (const float value : image.radiance) found += static_cast<double>(value);
  const double pixel_m = 2.5 * (kHeight_m - 3) / kHeight_m;
  const double lit = 6 * kFlat_per_um * kPower_W * kReflectance;  // W um-1, of both sources, sent up by the floor
  // 3 m below a leaf of 100 m, 0.4 % goes past its edges; the rest is the paths' noise.
  CHECK(found * pixel_m * pixel_m == doctest::Approx(kLeafT / kPi * lit).epsilon(0.02));
}
