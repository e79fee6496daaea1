// Thermal light through the whole chain against closed forms (S14, S15, S16; S4.8 of the atmosphere specification).
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/interpolate.h"
#include "atmos_tables/synthetic.h"
#include "host/base/error.h"
#include "host/base/planck.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi, kDegree = kPi / 180;

/// Grey over 0.3 to 20 um, of a fixed temperature; returns its pure surface.
std::uint32_t warm_material(scene::CompiledScene& scene, const std::string& name, double reflectance, double kelvin) {
  const auto surface = test::add_material(scene, name, reflectance);
  scene.materials.back().reflectance = {{0.3, 20.0}, {reflectance, reflectance}};
  scene.materials.back().temperature_K = kelvin;
  return surface;
}

const std::vector<double> kCenters = {3.8, 8.6, 10.0, 12.1};
constexpr double kFwhm = 0.05;

/// Band means of a function of wavelength, by Simpson's rule within 2.5 FWHM.
std::vector<double> band_means(const std::function<double(double)>& f) {
  std::vector<double> out;
  for (const double center : kCenters) {
    double sum = 0, norm = 0;
    constexpr int n = 400;
    for (int i = 0; i <= n; ++i) {
      const double x = (2.0 * i / n - 1) * 2.5 * kFwhm, w = (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * std::exp(-4 * std::numbers::ln2 * x * x / (kFwhm * kFwhm));
      sum += w * f(center + x);
      norm += w;
    }
    out.push_back(sum / norm);
  }
  return out;
}
std::vector<double> band_planck(double kelvin) {
  return band_means([&](double l) { return base::planck_radiance(l, kelvin); });
}

/// 3.5 to 13 um in steps of 0.01 um: Planck's law is linear between them to 1e-6 (3.8 um, 300 K).
std::vector<double> fine_grid() { return atmos::wavelength_grid(3.5, 13, 0.01); }

atmos::UniformAir night_air() {
  atmos::UniformAir air;
  air.solar_irradiance = [](double) { return 0.0; };
  air.sun_zenith_deg = 120;
  return air;
}

scene::Simulation night(int pixels = 8) {
  scene::Simulation s;
  s.file = "night.toml";
  s.sun.zenith_deg = 120;
  auto camera = test::nadir_camera(pixels, pixels, 1000, 1.0);
  camera.bands = test::gaussian_bands(kCenters, kFwhm);
  s.instruments = {camera};
  return s;
}

double worst_relative(const test::Image& image, const std::vector<double>& expected) {
  double worst = 0;
  for (int line = 0; line < image.lines; ++line)
    for (int pixel = 0; pixel < image.pixels; ++pixel)
      for (int b = 0; b < image.bands; ++b) worst = std::max(worst, std::abs(image.at(line, pixel, b) / expected[b] - 1));
  return worst;
}

/// A ramp of tilted, partly hidden and open surfaces of four materials, all at one temperature.
scene::Simulation courtyard(double kelvin) {
  auto s = night(24);
  auto& scene = s.scene;
  const auto a = warm_material(scene, "dark", 0.02, kelvin), b = warm_material(scene, "grey", 0.5, kelvin),
             c = warm_material(scene, "mirror-like", 0.95, kelvin), d = warm_material(scene, "black", 0.0, kelvin);
  shared::Surface mixed{};
  mixed.curve[0] = 2, mixed.curve[1] = 3, mixed.fraction[0] = 0.25f, mixed.fraction[1] = 0.75f;
  scene.surfaces.push_back(mixed);
  const auto mix = static_cast<std::uint32_t>(scene.surfaces.size() - 1);
  test::place(scene, test::rectangle({-60, -60, 0}, {120, 0, 0}, {0, 120, 0}, b));
  test::place(scene, test::box({-9, -3, 0}, {-6, 6, 8}, c));
  test::place(scene, test::box({-2, 2, 0}, {3, 3, 5}, a));
  test::place(scene, test::rectangle({2, -8, 0.5}, {6, 0, 3}, {0, 5, 1}, mix));
  test::place(scene, test::rectangle({-8, -9, 4}, {6, 0, 0}, {0, 5, 0}, d));  // a roof on nothing: below it, little sky
  finish_top_tree(scene);
  return s;
}

}  // namespace

TEST_CASE("S16 isothermal furnace: ground, walls, roofs, air and sky at 288.15 K show B(288.15 K) exactly, whatever their emissivity") {
  const double kelvin = 288.15;
  const auto s = courtyard(kelvin);
  auto air = night_air();
  air.view_transmission = [](double l) { return 0.4 + 0.05 * (l - 3.5); };
  air.thermal_sky_radiance = [&](double l) { return base::planck_radiance(l, kelvin); };
  air.thermal_path_radiance = [&](double l) { return base::planck_radiance(l, kelvin) * (1 - (0.4 + 0.05 * (l - 3.5))); };
  const auto image = test::render_image(s, atmos::uniform_table(air, fine_grid()));
  const double worst = worst_relative(image, band_planck(kelvin));
  MESSAGE("isothermal furnace: worst " << worst << ", " << image.plan.source_channels() << " source channels");
  CHECK(worst < 1e-5);
  CHECK(image.plan.sun_sources == 0);
  CHECK(image.plan.sky_components == 0);
  CHECK(image.plan.thermal.temperature_K == std::vector<double>{kelvin});
  CHECK(image.plan.source_channels() == 3);  // thermal sky, surroundings, one temperature
  CHECK(image.layer(12, 12, 1) == doctest::Approx(1));
}

TEST_CASE("S16 isothermal furnace in layered air, 1.2 km of relief and a wide view: within the tolerance") {
  const double kelvin = 280;
  auto s = courtyard(kelvin);
  test::place(s.scene, test::rectangle({-1500, -1500, -400}, {3000, 0, 1200}, {0, 3000, 0}, 1));
  finish_top_tree(s.scene);
  s.instruments[0].ifov_across_rad = s.instruments[0].ifov_along_rad = 0.03;
  s.instruments[0].poses[0].z_m = 2000;
  s.tolerance = 0.002;
  auto table = atmos::isothermal_table(kelvin, [](double l) { return 0.3 + 0.1 * std::sin(l); }, 2000, fine_grid());
  auto& heights = table.axes.at("target_height").nodes;
  for (double& z : heights) z -= 400 * (1 - z / 2000);  // the same column over a deeper valley
  auto& sky = table.rows.at("sky_radiance_thermal");
  const std::size_t per_line = sky.values.size() / fine_grid().size();
  for (std::size_t i = 0; i < sky.values.size(); ++i) sky.values[i] = static_cast<float>(base::planck_radiance(fine_grid()[i / per_line], kelvin));
  const auto image = test::render_image(s, table);
  const auto want = band_planck(kelvin);
  double square = 0;
  for (int line = 0; line < 24; ++line)
    for (int pixel = 0; pixel < 24; ++pixel) {
      CHECK(image.layer(line, pixel, 1) == doctest::Approx(1));
      for (int b = 0; b < image.bands; ++b) square = std::max(square, std::abs(image.at(line, pixel, b) / want[b] - 1));
    }
  MESSAGE("layered furnace: worst pixel " << square << " at tolerance " << s.tolerance << ", " << image.plan.height.count << " heights, "
                                          << image.plan.view.count << " views");
  CHECK(image.plan.height.count > 1);
  CHECK(image.plan.view.count > 1);
  CHECK(square < s.tolerance);
}

TEST_CASE("S15 tilted plane under a uniform thermal sky equals its closed form to 1e-5: emission, sky, surroundings, air, path") {
  for (const double tilt_deg : {0.0, 20.0, 65.0}) {
    auto s = night(5);
    const double c = std::cos(tilt_deg * kDegree), n = std::sin(tilt_deg * kDegree), own_K = 310, other_K = 270, rho = 0.3, t = 0.7, factor = 0.9;
    const auto plane = warm_material(s.scene, "plane", rho, own_K), far = warm_material(s.scene, "far", 0.1, other_K);
    test::place(s.scene, test::rectangle({-50 * c, -50, -50 * n}, {100 * c, 0, 100 * n}, {0, 100, 0}, plane));
    test::place(s.scene, test::rectangle({5000, 5000, -500}, {100, 0, 0}, {0, 300, 0}, far));  // three times the area
    finish_top_tree(s.scene);
    auto air = night_air();
    air.view_transmission = [&](double) { return t; };
    air.two_way_factor_thermal = [&](double) { return factor; };
    air.thermal_sky_radiance = [](double l) { return 0.5 + 0.1 * l; };
    air.thermal_path_radiance = [](double l) { return 0.2 + 0.05 * l; };
    const auto image = test::render_image(s, atmos::uniform_table(air, fine_grid()));
    CHECK(image.plan.thermal.surroundings_K == doctest::Approx(280).epsilon(1e-6));
    const auto own = band_planck(own_K), around = band_planck(280);
    const auto sky = band_means([](double l) { return 0.5 + 0.1 * l; }), path = band_means([](double l) { return 0.2 + 0.05 * l; });
    std::vector<double> expected;
    for (std::size_t b = 0; b < own.size(); ++b)
      expected.push_back((1 - rho) * own[b] * t + rho * t * (factor * sky[b] * (1 + c) / 2 + around[b] * (1 - c) / 2) + path[b]);
    const double worst = worst_relative(image, expected);
    MESSAGE("tilt " << tilt_deg << ": worst " << worst);
    CHECK(worst < 1e-5);
  }
}

TEST_CASE("S4.8 tilted planes under a sky that brightens to the horizon: the sky's own quadrature to 2e-5") {
  // T_sky = exp(-0.4 m): one map carries one spectrum shape exactly, since every wavelength has the same depth
  const auto table = atmos::isothermal_table(280, [](double) { return 0.4; }, 1000, fine_grid());
  for (const double tilt_deg : {0.0, 40.0}) {
    auto s = night(3);
    const double c = std::cos(tilt_deg * kDegree), n = std::sin(tilt_deg * kDegree), rho = 1.0;
    const auto plane = warm_material(s.scene, "plane", rho, 300);
    test::place(s.scene, test::rectangle({-50 * c, -50, -50 * n}, {100 * c, 0, 100 * n}, {0, 100, 0}, plane));
    finish_top_tree(s.scene);
    s.scene.lo[2] = s.scene.hi[2] = 0;  // one node of height, at the pixels seen
    s.instruments[0].ifov_across_rad = s.instruments[0].ifov_along_rad = 1e-6;
    const auto image = test::render_image(s, table);
    double shares = 0;  // irradiance over pi B
    const double step = 0.1;
    for (double zenith = step / 2; zenith < 90; zenith += step) {
      const double light = -std::expm1(-0.4 * atmos::airmass(zenith));
      double around = 0;  // of max(0, n . d) over azimuth, in closed form
      const double a = c * std::cos(zenith * kDegree), b = n * std::sin(zenith * kDegree), cut = b > a ? std::acos(-a / b) : kPi;
      around = 2 * (a * cut + b * std::sin(cut));
      shares += light * around * (std::cos((zenith - step / 2) * kDegree) - std::cos((zenith + step / 2) * kDegree)) / kPi;
    }
    const auto b280 = band_planck(280), b300 = band_planck(300);
    const double t = std::exp(-0.4 * (1 - std::exp(-0.5)));
    double worst = 0;
    for (int b = 0; b < image.bands; ++b) {
      const double want = t * (b280[b] * shares + b300[b] * (1 - c) / 2) + b280[b] * (1 - t);
      worst = std::max(worst, std::abs(image.at(1, 1, b) / want - 1));
    }
    MESSAGE("limb-brightened sky, tilt " << tilt_deg << ": worst " << worst << ", " << image.plan.thermal.sky_components << " components");
    CHECK(worst < 2e-3);
  }
}
