// Thermal light through the whole chain against closed forms (S14, S15, S16; S4.8 of the atmosphere specification).
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <numbers>

#include "atmos_tables/interpolate.h"
#include "atmos_tables/synthetic.h"
#include "host/base/error.h"
#include "host/base/planck.h"
#include "host/base/units.h"
#include "host/render/truth.h"
#include "tests/support/chance_checks.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi;

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
      const double x = (2.0 * i / n - 1) * 2.5 * kFwhm, w = (i == 0 || i == n ? 1
                                                             : i % 2          ? 4
                                                                              : 2) *
                                                            std::exp(-4 * std::numbers::ln2 * x * x / (kFwhm * kFwhm));
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

/// 3.5 to 13 um in steps of 2 nm: between them Planck's law is off a line by at most (x / l)^2 h^2 / 8 = 6e-6, x = 13
/// (3.8 um).
std::vector<double> fine_grid() { return atmos::wavelength_grid(3.5, 13, 0.002); }

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

/// A ramp of tilted, partly hidden and open surfaces of four materials, all at one temperature.
scene::Simulation courtyard(double kelvin) {
  auto s = night(24);
  auto& scene = s.scene;
  const auto a = warm_material(scene, "dark", 0.02, kelvin), b = warm_material(scene, "grey", 0.5, kelvin),
             c = warm_material(scene, "mirror-like", 0.95, kelvin), d = warm_material(scene, "black", 0.0, kelvin);
  shared::Surface mixed{};
  mixed.material[0] = 2, mixed.material[1] = 3, mixed.fraction[0] = 0.25f, mixed.fraction[1] = 0.75f;
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

TEST_CASE(
    "S16 isothermal furnace: ground, walls, roofs, air and sky at 288.15 K show B(288.15 K) exactly, whatever their "
    "emissivity") {
  const double kelvin = 288.15;
  const auto s = courtyard(kelvin);
  auto air = night_air();
  air.view_transmission = [](double l) { return 0.4 + 0.05 * (l - 3.5); };
  air.thermal_sky_radiance = [&](double l) { return base::planck_radiance(l, kelvin); };
  air.thermal_path_radiance = [&](double l) {
    return base::planck_radiance(l, kelvin) * (1 - (0.4 + 0.05 * (l - 3.5)));
  };
  const auto image = test::render_image(s, atmos::uniform_table(air, fine_grid()));
  const double worst = test::worst_relative(image, band_planck(kelvin));
  MESSAGE("isothermal furnace: worst " << worst << ", " << image.plan.source_channels() << " source channels");
  CHECK(worst < 1e-5);
  CHECK(image.plan.sun_sources == 0);
  CHECK(image.plan.sky_components == 0);
  CHECK(image.plan.thermal.temperature_K == std::vector<double>{kelvin});
  CHECK(image.plan.source_channels() == 3);  // thermal sky, surroundings, one temperature
  CHECK(image.layer(12, 12, render::truth::hit_fraction) == doctest::Approx(1));
}

TEST_CASE("S16 isothermal furnace in layered air, relief and several nodes of height and view: within the tolerance") {
  const double kelvin = 280;
  auto s = courtyard(kelvin);
  test::place(s.scene, test::rectangle({-500, -500, -400}, {1000, 0, 500}, {0, 1000, 0}, 1));
  finish_top_tree(s.scene);
  s.instruments[0].ifov_across_rad = s.instruments[0].ifov_along_rad = 0.012;
  s.instruments[0].poses[0].z_m = 2000;
  s.tolerance = 0.003;
  auto table = atmos::isothermal_table(
      kelvin, [](double l) { return 0.3 + 0.1 * std::sin(l); }, 2000, atmos::wavelength_grid(3.5, 13, 0.01));
  auto& heights = table.axes.at("target_height").nodes;
  for (double& z : heights) z -= 400 * (1 - z / 2000);  // the same column over a deeper valley
  auto& sky = table.rows.at("sky_radiance_thermal");
  const auto& um = atmos::wavelengths(table);
  const std::size_t per_line = sky.values.size() / um.size();
  for (std::size_t i = 0; i < sky.values.size(); ++i)
    sky.values[i] = static_cast<float>(base::planck_radiance(um[i / per_line], kelvin));
  const auto image = test::render_image(s, table);
  const auto want = band_planck(kelvin);
  double square = 0;
  for (int line = 0; line < 24; ++line)
    for (int pixel = 0; pixel < 24; ++pixel) {
      CHECK(image.layer(line, pixel, render::truth::hit_fraction) == doctest::Approx(1));
      for (int b = 0; b < image.bands; ++b) square = std::max(square, std::abs(image.at(line, pixel, b) / want[b] - 1));
    }
  MESSAGE("layered furnace: worst pixel " << square << " at tolerance " << s.tolerance << ", "
                                          << image.plan.height.count << " heights, " << image.plan.view.count
                                          << " views");
  CHECK(image.plan.height.count > 1);
  CHECK(image.plan.view.count > 1);
  CHECK(square < s.tolerance);
}

TEST_CASE(
    "S15 tilted plane under a uniform thermal sky equals its closed form to 1e-5: emission, sky, surroundings, air, "
    "path") {
  for (const double tilt_deg : {0.0, 20.0, 65.0}) {
    auto s = night(5);
    const double c = std::cos(base::rad_from_deg(tilt_deg)), n = std::sin(base::rad_from_deg(tilt_deg)), own_K = 310,
                 other_K = 270, rho = 0.3, t = 0.7, factor = 0.9;
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
    const auto sky = band_means([](double l) { return 0.5 + 0.1 * l; }),
               path = band_means([](double l) { return 0.2 + 0.05 * l; });
    std::vector<double> expected;
    for (std::size_t b = 0; b < own.size(); ++b)
      expected.push_back((1 - rho) * own[b] * t + rho * t * (factor * sky[b] * (1 + c) / 2 + around[b] * (1 - c) / 2) +
                         path[b]);
    const double worst = test::worst_relative(image, expected);
    MESSAGE("tilt " << tilt_deg << ": worst " << worst);
    CHECK(worst < 1e-5);
  }
}

TEST_CASE("S4.8 tilted planes under a sky that brightens to the horizon: quadrature of the table to 1e-4") {
  // T_sky = exp(-0.4 m): one map carries one spectrum shape exactly, since every wavelength has the same depth
  const auto table = atmos::isothermal_table(
      280, [](double) { return 0.4; }, 1000, fine_grid());
  for (const double tilt_deg : {0.0, 40.0}) {
    auto s = night(3);
    const double c = std::cos(base::rad_from_deg(tilt_deg)), n = std::sin(base::rad_from_deg(tilt_deg)), rho = 1.0;
    const auto plane = warm_material(s.scene, "plane", rho, 300);
    test::place(s.scene, test::rectangle({-50 * c, -50, -50 * n}, {100 * c, 0, 100 * n}, {0, 100, 0}, plane));
    finish_top_tree(s.scene);
    s.scene.lo[2] = s.scene.hi[2] = 0;  // one node of height, at the pixels seen
    s.instruments[0].ifov_across_rad = s.instruments[0].ifov_along_rad = 1e-6;
    const auto image = test::render_image(s, table);
    double shares = 0;  // irradiance over pi B
    const double step = 0.1;
    for (double zenith = step / 2; zenith < 90; zenith += step) {
      const double light =
          atmos::sky_radiance_thermal(table, 0, zenith)[0] / base::planck_radiance(atmos::wavelengths(table)[0], 280);
      double around = 0;  // of max(0, n . d) over azimuth, in closed form
      const double a = c * std::cos(base::rad_from_deg(zenith)), b = n * std::sin(base::rad_from_deg(zenith)),
                   cut = b > a ? std::acos(-a / b) : kPi;
      around = 2 * (a * cut + b * std::sin(cut));
      shares += light * around *
                (std::cos(base::rad_from_deg(zenith - step / 2)) - std::cos(base::rad_from_deg(zenith + step / 2))) /
                kPi;
    }
    const auto b280 = band_planck(280), b300 = band_planck(300);
    const double t = std::exp(-0.4 * (1 - std::exp(-0.5)));
    double worst = 0;
    for (int b = 0; b < image.bands; ++b) {
      const double want = t * (b280[b] * shares + b300[b] * (1 - c) / 2) + b280[b] * (1 - t);
      worst = std::max(worst, std::abs(image.at(1, 1, b) / want - 1));
    }
    MESSAGE("limb-brightened sky, tilt " << tilt_deg << ": worst " << worst << ", " << image.plan.thermal.sky_components
                                         << " components");
    CHECK(worst < 1e-4);  // maps linear between zeniths 1 degree apart
  }
}

TEST_CASE("S16 ground beside a wall: sky and wall share its hemisphere by the closed view factor") {
  const double rho = 0.4, ground_K = 300, wall_K = 330, height = 20, half_length = 400;
  for (const auto& [directions, limit] : {std::pair{16, 0.03}, {1024, 1.4e-3}}) {
    auto s = night(24);
    s.sky_directions = directions;
    s.instruments[0].poses[0].x_m = 15;  // ground 3 to 27 m before the wall
    const auto ground = warm_material(s.scene, "ground", rho, ground_K),
               wall = warm_material(s.scene, "wall", 0.1, wall_K);
    test::place(s.scene, test::rectangle({0, -400, 0}, {40, 0, 0}, {0, 800, 0}, ground));
    test::place(s.scene, test::rectangle({0, -half_length, 0}, {0, 2 * half_length, 0}, {0, 0, height}, wall));
    finish_top_tree(s.scene);
    auto air = night_air();
    air.thermal_sky_radiance = [](double) { return 2.0; };
    air.thermal_path_radiance = [](double) { return 0.0; };
    const auto image = test::render_image(s, atmos::uniform_table(air, fine_grid()));
    const double around_K = image.plan.thermal.surroundings_K;
    CHECK(around_K == doctest::Approx((ground_K * 32000 + wall_K * 16000) / 48000));
    const auto own = band_planck(ground_K), around = band_planck(around_K);
    double sum = 0, square = 0;
    for (int line = 0; line < 24; ++line)
      for (int pixel = 0; pixel < 24; ++pixel) {
        const double x = image.layer(line, pixel, render::truth::x_m), slant = std::hypot(x, height);  // x_m of the hit
        // Howell, configuration factor B-4: rectangle standing on the plane of a small level element
        const double hidden = (std::atan(half_length / x) - x / slant * std::atan(half_length / slant)) / kPi;
        const double want = (1 - rho) * own[2] + rho * (2.0 * (1 - hidden) + around[2] * hidden);
        const double error = image.at(line, pixel, 2) / want - 1;
        sum += error;
        square += error * error;
      }
    const double mean = sum / 576, rms = std::sqrt(square / 576),
                 standard_error = std::sqrt((square / 576 - mean * mean) / 575);
    MESSAGE(directions << " directions: mean " << mean / standard_error << " standard errors, rms " << rms);
    CHECK_WITHIN(mean, 4 * standard_error + 1e-5);
    CHECK_BELOW(rms, limit);
  }
}

TEST_CASE("S14 mixtures emit by material, and temperature nodes keep their stated error") {
  auto s = night(6);
  s.instruments[0].samples_u = s.instruments[0].samples_v = 2;
  const double rho_a = 0.1, rho_b = 0.6;
  // 40 materials: too many temperatures for nodes of their own
  for (int k = 0; k < 40; ++k) warm_material(s.scene, "m" + std::to_string(k), k % 2 ? rho_a : rho_b, 270 + 1.3 * k);
  std::vector<std::uint32_t> mixed;
  for (std::uint32_t k = 0; k < 36; ++k) {
    shared::Surface surface{};
    surface.material[0] = k + 1, surface.material[1] = 40 - k;
    surface.fraction[0] = 0.3f, surface.fraction[1] = 0.7f;
    if (surface.material[0] == surface.material[1]) surface.material[1] = 5;
    s.scene.surfaces.push_back(surface);
    mixed.push_back(static_cast<std::uint32_t>(s.scene.surfaces.size() - 1));
    const double x = -3.0 + k % 6, y = 3.0 - (k / 6) - 1;
    test::place(s.scene, test::rectangle({x, y, 0}, {1, 0, 0}, {0, 1, 0}, mixed.back()));
  }
  finish_top_tree(s.scene);
  auto air = night_air();
  air.thermal_sky_radiance = [](double) { return 0.0; };
  air.thermal_path_radiance = [](double) { return 0.0; };
  const auto image = test::render_image(s, atmos::uniform_table(air, fine_grid()));
  const auto nodes = image.plan.thermal.temperature_K.size();
  CHECK(nodes > 2);
  CHECK(nodes < 40);
  REQUIRE(image.plan.report.thermal);
  const double stated = image.plan.report.thermal->temperature_nodes_error;
  std::vector<double> mean(kCenters.size(), 0.0);
  std::vector<std::vector<double>> want;
  for (std::uint32_t k = 0; k < 36; ++k) {
    const auto& surface = s.scene.surfaces[mixed[k]];
    std::vector<double> sum(kCenters.size(), 0.0);
    for (int c = 0; c < 2; ++c) {
      const auto& material = s.scene.materials[surface.material[c] - 1];
      const auto b = band_planck(material.temperature_K);
      for (std::size_t i = 0; i < b.size(); ++i)
        sum[i] += double{surface.fraction[c]} * (1 - material.reflectance.value[0]) * b[i];
    }
    for (std::size_t i = 0; i < sum.size(); ++i) mean[i] += sum[i] / 36;
    want.push_back(sum);
  }
  double worst = 0;
  for (int line = 0; line < 6; ++line)
    for (int pixel = 0; pixel < 6; ++pixel)
      for (std::size_t b = 0; b < mean.size(); ++b)
        worst = std::max(worst, std::abs(image.at(line, pixel, static_cast<int>(b)) -
                                         want[static_cast<std::size_t>(line * 6 + pixel)][b]) /
                                    mean[b]);
  MESSAGE(nodes << " nodes: stated " << stated << " of the typical radiance, worst " << worst << " of the mean");
  CHECK(worst < s.tolerance);
  CHECK(worst < 1.5 * stated + 1e-6);  // typical radiance and the scene's mean differ
  CHECK(worst > 0.05 * stated);
}

TEST_CASE("S15 3.8 um by day: sun, skylight and thermal light together; at 10 um the sun gets no channel") {
  const double rho = 0.3, kelvin = 300, zenith_deg = 40;
  auto s = night(4);
  s.sun.zenith_deg = zenith_deg;
  s.sun.azimuth_deg = 120;
  const auto ground = warm_material(s.scene, "ground", rho, kelvin);
  test::place(s.scene, test::rectangle({-60, -60, 0}, {120, 0, 0}, {0, 120, 0}, ground));
  finish_top_tree(s.scene);
  atmos::UniformAir air;
  air.sun_zenith_deg = zenith_deg;
  air.sun_azimuth_deg = 120;
  const auto sun = [](double l) { return 11.0 * std::pow(3.8 / l, 4); };  // near the sun's: 11 at 3.8, 0.22 at 10.1 um
  air.solar_irradiance = sun;
  air.sun_transmission = [](double) { return 0.8; };
  air.view_transmission = [](double) { return 0.9; };
  air.two_way_factor = [](double) { return 1.02; };
  air.sky_radiance = [](double l) { return 0.01 * std::pow(3.8 / l, 4); };
  air.path_radiance = [](double) { return 0.003; };
  air.thermal_sky_radiance = [](double l) { return 0.1 * l; };
  air.thermal_path_radiance = [](double) { return 0.05; };
  const auto table = atmos::uniform_table(air, fine_grid());
  const auto day = test::render_image(s, table);
  const auto planck = band_planck(kelvin), e0 = band_means(sun),
             thermal_sky = band_means([](double l) { return 0.1 * l; });
  std::vector<double> expected, without_sky;
  for (std::size_t b = 0; b < planck.size(); ++b) {
    without_sky.push_back(
        (1 - rho) * planck[b] * 0.9 +
        rho * 0.9 * (e0[b] * 0.8 * 1.02 * std::cos(base::rad_from_deg(zenith_deg)) / kPi + thermal_sky[b]) + 0.053);
    expected.push_back(without_sky.back() + rho * 0.9 * 1.02 * e0[b] / 1100);
  }
  const double worst = test::worst_relative(day, expected);
  MESSAGE("day: worst " << worst << ", " << day.plan.sun_sources << " sun, " << day.plan.sky_components << " sky\n"
                        << plan::plan_json(day.plan).dump(2));
  CHECK(day.plan.sun_sources == 1);
  CHECK(worst < 2e-3);  // skylight, 0.8 % of the sun's, may be left out within its share of the tolerance
  // ground of reflectance 0.05: 4e-4 of its light at 9.5 um is the sun's
  s.scene.materials[0].reflectance.value = {0.05, 0.05};
  s.instruments[0].bands = test::gaussian_bands({9.5, 10, 12}, kFwhm);
  const auto window = test::render_image(s, table);
  CHECK(window.plan.sun_sources == 0);
  CHECK(window.plan.sky_components == 0);
  CHECK(window.plan.source_channels() == 3);
  CHECK(window.layer(1, 1, render::truth::sun_fraction) ==
        doctest::Approx(1));  // the truth still knows who sees the sun
  const double dark = 0.95 * planck[2] * 0.9 + 0.05 * 0.9 * thermal_sky[2] + 0.053;
  CHECK(std::abs(window.at(1, 1, 1) / dark - 1) < 1e-3);
}

TEST_CASE("S60 thermal light: row capacity, chunks of samples and the sum on the host give the same picture") {
  auto s = courtyard(290);
  for (std::size_t m = 0; m < s.scene.materials.size(); ++m)
    s.scene.materials[m].temperature_K = 280 + 9.0 * static_cast<double>(m);
  s.instruments[0].pixels = s.instruments[0].lines = 12;
  s.instruments[0].ifov_across_rad = s.instruments[0].ifov_along_rad = 0.002;
  auto air = night_air();
  air.thermal_sky_radiance = [](double l) { return 0.2 * l; };
  air.thermal_path_radiance = [](double) { return 0.1; };
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(3.5, 13, 0.05));
  const auto plain = test::render_image(s, table);
  render::RenderOptions one;
  one.row_capacity = 1;
  const auto overflown = test::render_image(s, table, one);
  CHECK(overflown.statistics.overflow_pixels > 0);
  CHECK(overflown.radiance == plain.radiance);
}

TEST_CASE(
    "S16 isothermal furnace through 1681 samples in two chunks, and through the sum on the host of 324 curves in a "
    "pixel") {
  const double kelvin = 295;
  auto air = night_air();
  air.view_transmission = [](double) { return 0.8; };
  air.thermal_sky_radiance = [&](double l) { return base::planck_radiance(l, kelvin); };
  air.thermal_path_radiance = [&](double l) { return 0.2 * base::planck_radiance(l, kelvin); };
  const auto table = atmos::uniform_table(air, fine_grid());
  auto chunks = courtyard(kelvin);
  chunks.instruments[0].pixels = chunks.instruments[0].lines = 4;
  chunks.instruments[0].ifov_across_rad = chunks.instruments[0].ifov_along_rad = 0.006;
  chunks.instruments[0].samples_u = chunks.instruments[0].samples_v = 41;
  CHECK(test::worst_relative(test::render_image(chunks, table), band_planck(kelvin)) < 1e-5);
  auto many = night(1);
  many.instruments[0].samples_u = many.instruments[0].samples_v = 18;
  for (int k = 0; k < 324; ++k) {
    const auto surface = warm_material(many.scene, "m" + std::to_string(k), k / 400.0, kelvin);
    test::place(many.scene, test::rectangle({k % 18 / 18.0 - 0.5, k / 18 / 18.0 - 0.5, 0}, {1 / 18.0, 0, 0},
                                            {0, 1 / 18.0, 0}, surface));
  }
  finish_top_tree(many.scene);
  const auto image = test::render_image(many, table);
  CHECK(image.statistics.per_sample_pixels == 1);
  CHECK(test::worst_relative(image, band_planck(kelvin)) < 1e-5);
}

TEST_CASE("bad input: thermal rows and materials without temperature, half of the thermal rows") {
  auto s = night(2);
  const auto a = warm_material(s.scene, "grass", 0.1, 0), b = warm_material(s.scene, "roof", 0.1, 300),
             c = warm_material(s.scene, "gravel", 0.1, 0);
  warm_material(s.scene, "unused", 0.1, 0);
  for (const auto surface : {a, b, c})
    test::place(s.scene, test::rectangle({-5, -5, -double(surface)}, {10, 0, 0}, {0, 10, 0}, surface));
  finish_top_tree(s.scene);
  auto air = night_air();
  air.thermal_sky_radiance = air.thermal_path_radiance = [](double) { return 1.0; };
  auto table = atmos::uniform_table(air, fine_grid());
  const auto refused = [&] {
    try {
      test::render_image(s, table);
    } catch (const base::Error& error) {
      CHECK(error.fault() == base::Fault::input);
      return std::string(error.what());
    }
    return std::string();
  };
  const std::string message = refused();
  MESSAGE(message);
  CHECK(message.find("material 'grass'") != std::string::npos);
  CHECK(message.find("material 'gravel'") != std::string::npos);
  CHECK(message.find("roof") == std::string::npos);
  CHECK(message.find("unused") == std::string::npos);
  CHECK(message.find("default_temperature_K") != std::string::npos);
  for (auto& material : s.scene.materials) material.temperature_K = 290;
  table.rows.erase("sky_radiance_thermal");
  CHECK(refused().find("sky_radiance_thermal") != std::string::npos);
}
