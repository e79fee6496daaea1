// Thermal light below 3 um, where a table holds none of it: hot surfaces, and where nothing may change.
// Oracle: Planck's law through the table's transmission on a flat plate, in closed form.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/synthetic.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"
#include "host/base/planck.h"
#include "host/base/units.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi, kZenith_deg = 35, kFwhm = 0.02;

double sunlight(double l) { return 1700 * std::exp(-1.4 * l) + 4; }
double through(double l) { return 0.75 - 0.05 * std::sin(3 * l); }
constexpr double kSunThrough = 0.8, kTwoWay = 1.03, kRho = 0.1;
double sky(double l) { return 8 / (l * l); }
double path(double l) { return 0.3 / (l * l); }

atmos::UniformAir day_air() {
  atmos::UniformAir air;
  air.sun_zenith_deg = kZenith_deg;
  air.solar_irradiance = sunlight, air.view_transmission = through, air.sky_radiance = sky, air.path_radiance = path;
  air.sun_transmission = [](double) { return kSunThrough; };
  air.two_way_factor = [](double) { return kTwoWay; };
  return air;
}

/// A flat plate of reflectance 0.1 that fills the view.
scene::Simulation plate(double kelvin, const std::vector<double>& centers_um) {
  scene::Simulation s;
  s.file = "plate.toml";
  s.sun.zenith_deg = kZenith_deg;
  const auto surface = test::add_material(s.scene, "lava", kRho);
  s.scene.materials.back().reflectance = {{0.3, 20.0}, {kRho, kRho}};
  s.scene.materials.back().temperature_K = kelvin;
  test::place(s.scene, test::rectangle({-60, -60, 0}, {120, 0, 0}, {0, 120, 0}, surface));
  finish_top_tree(s.scene);
  auto camera = test::nadir_camera(4, 4, 1000, 1.0);
  camera.bands = test::gaussian_bands(centers_um, kFwhm);
  s.instruments = {camera};
  return s;
}

/// Mean of a function over a band of kFwhm, by Simpson's rule within 2.5 FWHM.
template <class Function>
double band_mean(double center, Function f) {
  double sum = 0, norm = 0;
  constexpr int n = 400;
  for (int i = 0; i <= n; ++i) {
    const double x = (2.0 * i / n - 1) * 2.5 * kFwhm;
    const double w = (i == 0 || i == n ? 1
                      : i % 2          ? 4
                                       : 2) *
                     std::exp(-4 * std::numbers::ln2 * x * x / (kFwhm * kFwhm));
    sum += w * f(center + x), norm += w;
  }
  return sum / norm;
}

double sunlit(double l) {
  return kRho * (sunlight(l) * kSunThrough * std::cos(base::rad_from_deg(kZenith_deg)) / kPi + sky(l)) * through(l) *
             kTwoWay +
         path(l);
}
double glow(double l, double kelvin) { return (1 - kRho) * base::planck_radiance(l, kelvin) * through(l); }

/// Steps of 1 nm: between them Planck's law at 600 K and 1 um is off a line by (24 / 1 um)^2 (1 nm)^2 / 8 =
/// 7e-5 of itself at most; the plan puts its nodes at the midpoints too, and integrates quadratics.
std::vector<double> grid(double last_um) { return atmos::wavelength_grid(0.9, last_um, 0.001); }

bool says(const std::vector<std::string>& notices, const std::string& what) {
  return std::any_of(notices.begin(), notices.end(), [&](const auto& n) { return n.find(what) != std::string::npos; });
}

}  // namespace

TEST_CASE(
    "S14 a plate at 600, 1200 and 1500 K at 1.0, 1.6, 2.2 and 3.9 um: Planck's law through the table's "
    "transmission, by day") {
  for (const double kelvin : {600.0, 1200.0, 1500.0})
    for (const std::vector<double>& centers : {std::vector<double>{1.0, 1.6, 2.2}, {1.0, 1.6, 2.2, 3.9}}) {
      const auto image =
          test::render_image(plate(kelvin, centers), atmos::uniform_table(day_air(), grid(centers.back() + 0.1)));
      CHECK(image.plan.thermal.on);
      for (std::size_t b = 0; b < centers.size(); ++b) {
        const double own = band_mean(centers[b], [&](double l) { return glow(l, kelvin); }),
                     rest = band_mean(centers[b], sunlit);
        const double found = image.at(1, 2, static_cast<int>(b)), error = std::abs(found / (own + rest) - 1);
        MESSAGE(kelvin << " K, " << centers[b] << " um: " << found << ", closed form " << own + rest << " (own light "
                       << own << "), off by " << error);
        // 0.001: sun and sky may be left out where they are that part of a band's light (1500 K at 3.9 um);
        // else float and the grid.
        CHECK(error < (rest < 0.01 * own ? 1e-3 : 1e-5));
      }
    }
  const double lava = band_mean(2.2, [](double l) { return 0.9 * base::planck_radiance(l, 1200); });
  CHECK(lava == doctest::Approx(8975).epsilon(1e-3));
}

TEST_CASE("S60 what no band sees changes no bit, costs no source and asks for no temperature") {
  const auto table = atmos::uniform_table(day_air(), grid(2.1));
  const auto bare = plate(0, {1.0, 1.5, 2.0});
  const auto cold = test::render_image(bare, table);
  CHECK(cold.plan.notices.empty());
  for (const double kelvin :
       {300.0, 330.0}) {  // 330 K: 8e-4 of the sunlit light at 2 um, the tenth of the tolerance is 1e-3
    const auto warm = test::render_image(plate(kelvin, {1.0, 1.5, 2.0}), table);
    CHECK(!warm.plan.thermal.on);
    CHECK(warm.radiance == cold.radiance);
    CHECK(warm.plan.source_channels() == cold.plan.source_channels());
    CHECK(warm.plan.notices.empty());
    CHECK(warm.plan.report.thermal_left_out.has_value());
  }
}

TEST_CASE(
    "S14 thermal light comes on where one material makes a tenth of the tolerance in one band, and not "
    "before") {
  // B of the temperatures just below and above the limit, from the closed form.
  const double l = 2.2, limit = 1e-3 * sunlit(l) / ((1 - kRho) * through(l));
  const double kelvin =
      base::kSecondRadiationConstant / (l * std::log1p(base::kFirstRadiationConstant / (std::pow(l, 5) * limit)));
  const auto table = atmos::uniform_table(day_air(), grid(2.3));
  for (const auto& [factor, on] : {std::pair{0.99, false}, {1.01, true}}) {
    const auto s = plate(kelvin * factor, {1.0, 2.2});
    const auto image = test::render_image(s, table);
    CHECK(image.plan.thermal.on == on);
    const double whole = sunlit(l) + glow(l, kelvin * factor);
    CHECK(std::abs(image.at(1, 1, 1) / whole - 1) <
          (on ? 1e-4 : 1.1e-3));  // at the band's centre: a line of 20 nm bends by 1e-4
    auto fine = s;
    fine.tolerance = 0.001;
    CHECK(test::render_image(fine, table).plan.thermal.on);
    fine.thermal_below_3um = false;
    CHECK(!test::render_image(fine, table).plan.thermal.on);
  }
}

TEST_CASE(
    "S14 one hot material among cold ones: it glows, those without a temperature do not, and a notice names "
    "them") {
  auto s = plate(0, {1.0, 2.2});
  s.scene.materials[0].name = "grass";
  const auto lava = test::add_material(s.scene, "lava", 0.05);
  s.scene.materials.back().temperature_K = 1200;
  test::place(s.scene, test::rectangle({-2, 0, 0.02}, {4, 0, 0}, {0, 2, 0}, lava));
  finish_top_tree(s.scene);
  const auto image = test::render_image(s, atmos::uniform_table(day_air(), grid(2.3)));
  const double hot = band_mean(2.2, [](double l) {
    return 0.95 * base::planck_radiance(l, 1200) * through(l) + 0.5 * (sunlit(l) - path(l)) + path(l);
  });
  CHECK(std::abs(image.at(0, 1, 1) / hot - 1) < 1e-3);
  CHECK(std::abs(image.at(3, 1, 1) / band_mean(2.2, sunlit) - 1) < 1e-3);
  REQUIRE(image.plan.notices.size() == 2);
  CHECK(says(image.plan.notices, "'grass'"));
  CHECK(says(image.plan.notices, "material 'lava' at 1200 K"));
  CHECK(says(image.plan.notices, "falls on other surfaces"));
}

TEST_CASE("S14 by night a plate of 300 K is seen at 2.2 um, and nothing is at 0.95 um") {
  auto s = plate(300, {2.2});
  s.sun.zenith_deg = 120;
  auto air = day_air();
  air.sun_zenith_deg = 120;
  air.solar_irradiance = air.sky_radiance = air.path_radiance = [](double) { return 0.0; };
  const auto night = test::render_image(s, atmos::uniform_table(air, grid(2.3)));
  CHECK(std::abs(night.at(1, 1, 0) / band_mean(2.2, [](double l) { return glow(l, 300); }) - 1) < 1e-5);
  s.instruments[0].bands = test::gaussian_bands({0.96}, kFwhm);
  const auto dark = test::render_image(s, atmos::uniform_table(air, grid(1.1)));
  CHECK(!dark.plan.thermal.on);
  CHECK(*std::max_element(dark.radiance.begin(), dark.radiance.end()) == 0);
}

TEST_CASE(
    "S4.9 by night ground and air light each other with nothing: radiance is 0, under a table that couples "
    "them and where a sky is dark in the bands") {
  auto s = plate(0, {0.96, 1.5});
  s.sun.zenith_deg = 120;
  auto air = day_air();
  air.sun_zenith_deg = 120;
  air.sky_radiance = air.path_radiance = [](double) { return 0.0; };
  auto table = atmos::uniform_table(air, grid(1.6));
  test::add_ground_coupling(table);
  const auto night = test::render_image(s, table);
  CHECK(night.plan.sky_components == 0);
  CHECK(std::count(night.radiance.begin(), night.radiance.end(), 0.0f) ==
        static_cast<std::ptrdiff_t>(night.radiance.size()));
  air.sky_radiance = [](double l) { return l > 1.2 ? 1.0 : 0.0; };
  s.instruments[0].bands = test::gaussian_bands({0.96}, kFwhm);
  const auto blind = test::render_image(s, atmos::uniform_table(air, grid(1.6)));
  CHECK(std::count(blind.radiance.begin(), blind.radiance.end(), 0.0f) ==
        static_cast<std::ptrdiff_t>(blind.radiance.size()));
}

TEST_CASE(
    "S21 a table that says what the path emits and not what the sky does, below 3 um: the path's light is "
    "in, temperatures are not asked for") {
  auto table = atmos::uniform_table(day_air(), grid(2.6));
  auto& emitted = add_row(table, "path_radiance_thermal", "as a .chn has it");
  const auto& um = table.axis("wavelength").nodes;
  for (std::size_t i = 0; i < um.size(); ++i)
    emitted.values[i] = static_cast<float>(10 * base::planck_radiance(um[i], 300));
  const auto image = test::render_image(plate(0, {1.0, 2.45}), table);
  CHECK(image.plan.thermal.on);
  const double want = band_mean(2.45, [](double l) { return sunlit(l) + 10 * base::planck_radiance(l, 300); });
  CHECK(std::abs(image.at(1, 1, 1) / want - 1) < 1e-5);
  CHECK(says(image.plan.notices, "the air of the table"));
  // 1.0 to 1.6 um: it makes nothing there, so bits are those of the table without
  const auto near = test::render_image(plate(0, {1.0, 1.6}), table);
  table.rows.erase("path_radiance_thermal");
  CHECK(!near.plan.thermal.on);
  CHECK(near.radiance == test::render_image(plate(0, {1.0, 1.6}), table).radiance);
}

TEST_CASE("S14 bands on both sides of 3 um: the table's thermal rows ask for temperatures, as they do beyond") {
  auto air = day_air();
  air.thermal_sky_radiance = [](double l) { return 0.01 * l; };
  air.thermal_path_radiance = [](double l) { return 0.005 * l; };
  const auto table = atmos::uniform_table(air, grid(3.2));
  const auto image = test::render_image(plate(310, {2.2, 3.1}), table);
  for (const auto& [b, center] : {std::pair{0, 2.2}, {1, 3.1}}) {
    const double want =
        band_mean(center, [](double l) { return sunlit(l) + glow(l, 310) + kRho * 0.01 * l * through(l) + 0.005 * l; });
    CHECK(std::abs(image.at(1, 1, b) / want - 1) < 1e-5);
  }
  CHECK_THROWS_AS(test::render_image(plate(0, {2.2, 3.1}), table), base::Error);
}

TEST_CASE(
    "S16 model = \"none\": a black body in vacuum from 2.2 to 100 um, and beyond 4 um every material needs a "
    "temperature") {
  for (const auto& [center, kelvin] :
       {std::pair{2.2, 1200.0}, {3.9, 300.0}, {10.0, 300.0}, {12.0, 77.0}, {90.0, 300.0}}) {
    auto s = plate(kelvin, {center});
    s.scene.materials[0].reflectance = {{0.3, 100.0}, {0.0, 0.0}};
    s.atmosphere.none = true;
    s.sun.zenith_deg = 120;
    const auto table = atmos::vacuum_table(s.sun, 1000, atmos::vacuum_wavelengths(center - 0.06, center + 0.06), {0});
    const auto image = test::render_image(s, table);
    const double want = band_mean(center, [kelvin = kelvin](double l) { return base::planck_radiance(l, kelvin); });
    const double error = std::abs(image.at(1, 1, 0) / want - 1);
    MESSAGE(center << " um, " << kelvin << " K in vacuum: " << image.at(1, 1, 0) << ", off by " << error);
    CHECK(error < 1e-5);
  }
  auto s = plate(0, {10.0});
  s.atmosphere.none = true;
  const auto table = atmos::vacuum_table(s.sun, 1000, atmos::vacuum_wavelengths(9.9, 10.1), {0});
  CHECK_THROWS_WITH_AS(test::render_image(s, table),
                       doctest::Contains("has no temperature, and bands without air reach beyond 4 um"), base::Error);
}
