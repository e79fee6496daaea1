// Where the cube's sums, spectra and scenes fail (REQUIREMENTS section 4, Sampling and sums, Spectral, Geometry), on
// every device found. Oracle: the closed form of a level Lambertian plane under the sun and a uniform sky, L = T rho
// (E0 cos / pi + L_sky) + L_path.
#include <doctest/doctest.h>

#include <cmath>
#include <cstring>
#include <numbers>

#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "tests/support/devices.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kSun = 1000, kSky = 30, kPath = 5;

/// Transmission to the sensor falls from 0.9 by `slope` per um; nodes every 0.1 um, linear between.
double transmission(double wavelength_um, double slope, double factor) {
  return factor * (0.9 - slope * (wavelength_um - 0.4));
}

atmos::RenderTable table(double slope = 0, double factor = 1, double path = kPath) {
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return kSun; };
  air.view_transmission = [=](double um) { return transmission(um, slope, factor); };
  air.sky_radiance = [](double) { return kSky; };
  air.path_radiance = [=](double) { return path; };
  return atmos::uniform_table(air, atmos::wavelength_grid(0.3, 1.1, 0.1));
}

double plane_radiance(double reflectance, double view_transmission, double path = kPath) {
  return view_transmission * reflectance * (kSun / std::numbers::pi + kSky) + path;
}

scene::Simulation plane(double reflectance, int samples, double height_m = 500) {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "m", reflectance);
  test::place(simulation.scene, test::rectangle({-20000, -20000, 0}, {40000, 0, 0}, {0, 40000, 0}, surface));
  finish_top_tree(simulation.scene);
  auto camera = test::nadir_camera(5, 3, height_m, height_m / 500);
  camera.samples_u = camera.samples_v = samples;
  simulation.instruments = {camera};
  return simulation;
}

/// Largest distance of any pixel and band from what `expected(band)` says, relative.
template <typename F>
double worst(const test::Image& image, const F& expected) {
  double most = 0;
  for (int line = 0; line < image.lines; ++line)
    for (int pixel = 0; pixel < image.pixels; ++pixel)
      for (int band = 0; band < image.bands; ++band) {
        const double wanted = expected(band), found = image.at(line, pixel, band);
        if (!std::isfinite(found) || found < 0) return 1e30;
        most = std::max(most, wanted == 0 ? std::abs(found) : std::abs(found / wanted - 1));
      }
  return most;
}

}  // namespace

TEST_CASE(
    "stability: grids of 1 x 1, 4 x 4 and 31 x 31, from 500 m and 400 km, reflectance 0, 1e-6 and 1: the plane's "
    "radiance") {
  for (const auto& device : test::device_numbers())
    for (const int n : {1, 4, 31})
      for (const double reflectance : {0.0, 1e-6, 1.0})
        for (const double height_m : {500.0, 400000.0}) {
          if (n == 1 && height_m > 500) continue;
          CAPTURE(n);
          CAPTURE(reflectance);
          CAPTURE(height_m);
          const auto image = test::render_image(plane(reflectance, n, height_m), table(), {.device = device});
          // Rows, map and band value round once each in fp32 (6e-8), and so does the weight of a sample.
          CHECK(worst(image, [&](int) { return plane_radiance(reflectance, 0.9); }) < 1e-6);
        }
}

TEST_CASE("stability: bands narrower than the table's step, out of order, duplicate and overlapping") {
  auto simulation = plane(0.5, 4);
  auto& bands = simulation.instruments[0].bands;
  bands = test::gaussian_bands({0.7, 0.45, 0.4512, 0.7, 0.96}, 1e-5);
  const auto wide = test::gaussian_bands({0.701, 0.7}, 0.05);  // over a node, where the line goes on straight
  bands.insert(bands.end(), wide.begin(), wide.end());
  for (const auto& device : test::device_numbers()) {
    const auto image = test::render_image(simulation, table(0.6), {.device = device});
    CHECK(worst(image, [&](int band) {
            return plane_radiance(0.5, transmission(bands[std::size_t(band)].center_um, 0.6, 1));
          }) < 2e-6);
  }
}

TEST_CASE(
    "stability: transmission of 1e-12 without and beside path radiance: the closed form, nothing negative, nothing "
    "lost") {
  for (const auto& device : test::device_numbers())
    for (const double path : {0.0, 1e-9, kPath}) {
      CAPTURE(path);
      const auto image = test::render_image(plane(1.0, 4), table(0, 1e-12 / 0.9, path), {.device = device});
      CHECK(worst(image, [&](int) { return plane_radiance(1, 1e-12, path); }) < 2e-6);
    }
}

TEST_CASE("stability: an empty scene shows the path, a sensor in a closed box no sun") {
  for (const auto& device : test::device_numbers()) {
    auto simulation = plane(0.5, 4);
    simulation.scene = {};
    finish_top_tree(simulation.scene);
    CHECK(worst(test::render_image(simulation, table(), {.device = device}), [](int) { return kPath; }) < 1e-6);
    scene::Simulation inside;
    const auto surface = test::add_material(inside.scene, "m", 0.5);
    test::place(inside.scene, test::box({-600, -500, -1}, {500, 600, 700}, surface));
    finish_top_tree(inside.scene);
    inside.instruments = plane(0.5, 4).instruments;
    const auto image = test::render_image(inside, table(), {.device = device});
    for (int line = 0; line < image.lines; ++line)
      for (int pixel = 0; pixel < image.pixels; ++pixel) {
        CHECK(image.layer(line, pixel, render::truth::hit_fraction) == 1);  // hit fraction
        CHECK(image.layer(line, pixel, render::truth::sun_fraction) == 0);  // sun fraction
      }
  }
}

TEST_CASE("stability: pages of 4 KiB, tiles of one line and one thread give the same bytes") {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "m", 0.5);
  test::place(simulation.scene, test::rectangle({-20000, -20000, 0}, {40000, 0, 0}, {0, 40000, 0}, surface));
  test::place(simulation.scene, test::box({-1, -1, 0}, {1, 1, 2}, surface));
  finish_top_tree(simulation.scene);
  simulation.instruments = plane(0.5, 4).instruments;
  for (const auto& device : test::device_numbers()) {
    const auto whole = test::render_image(simulation, table(), {.device = device});
    for (const render::RenderOptions& options : {render::RenderOptions{.device = device, .page_bytes = 4096},
                                                 {.device = device, .tile_lines = 1},
                                                 {.device = device, .row_capacity = 1}}) {
      const auto part = test::render_image(simulation, table(), options);
      CHECK(std::memcmp(whole.radiance.data(), part.radiance.data(), whole.radiance.size() * sizeof(float)) == 0);
      CHECK(std::memcmp(whole.truth.data(), part.truth.data(), whole.truth.size() * sizeof(float)) == 0);
    }
  }
}
