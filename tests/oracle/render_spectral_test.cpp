// Bands through the whole chain (S11, S18, S42; REQUIREMENTS section 4, "Spectral"): a plane seen through air whose
// spectra the test states. Oracle: fine quadrature of the same continuous spectra in double, response exp(-4 ln2 (l -
// lc)^2 / FWHM^2) cut at 2.5 FWHM as documented.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/synthetic.h"
#include "host/base/error.h"
#include "host/plan/quadrature.h"
#include "tests/support/render_kit.h"
#include "tests/support/test_scenes.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi;

/// A level plane under the sun at the zenith; its reflectance is linear in wavelength over the nodes given.
scene::Simulation plane(const std::vector<double>& wavelength_um, const std::vector<double>& reflectance) {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "plane", 0.5);
  simulation.scene.materials.back().reflectance = {wavelength_um, reflectance};
  test::place(simulation.scene, test::rectangle({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, surface));
  finish_top_tree(simulation.scene);
  simulation.instruments = {test::nadir_camera(1, 1, 500, 1.0)};
  return simulation;
}

/// Response-weighted mean by the midpoint rule in steps of at most step_um.
double fine_mean(const scene::Band& band, double step_um, const std::function<double(double)>& radiance) {
  const double half = plan::kGaussianCutFwhm * band.fwhm_um;
  const auto steps = static_cast<long>(std::ceil(2 * half / step_um));
  double sum = 0, norm = 0;
  for (long i = 0; i < steps; ++i) {
    const double l = band.center_um - half + 2 * half * (double(i) + 0.5) / double(steps),
                 t = (l - band.center_um) / band.fwhm_um;
    const double response = std::exp(-4 * std::numbers::ln2 * t * t);
    sum += response * radiance(l);
    norm += response;
  }
  return sum / norm;
}

/// Linear between nodes.
double linear(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto i =
      std::clamp<std::ptrdiff_t>(std::upper_bound(x.begin(), x.end(), at) - x.begin(), 1, std::ptrdiff_t(x.size()) - 1);
  const double f = (at - x[i - 1]) / (x[i] - x[i - 1]);
  return y[i - 1] * (1 - f) + y[i] * f;
}

}  // namespace

TEST_CASE("S11 S18 an absorption line of 0.01 nm inside a band equals fine quadrature to 1e-4") {
  constexpr double center = 0.76, width = 1e-5, depth = 3;  // um
  auto simulation = plane({0.7, 0.82}, {0.2, 0.5});
  atmos::UniformAir air;
  air.solar_irradiance = [](double l) { return 1500 - 4000 * (l - center); };
  air.sun_transmission = [](double l) { return atmos::gaussian_line(l, center, width, depth); };
  air.view_transmission = [](double l) { return atmos::gaussian_line(l, center, width, 0.3 * depth); };
  air.sky_radiance = [](double l) { return 50 * atmos::gaussian_line(l, center, width, depth); };
  air.path_radiance = [](double) { return 4.0; };
  const auto table = atmos::uniform_table(
      air, atmos::wavelength_grid_with_line(
               0.7, 0.82, 1e-3, center, 8e-5,
               5e-8));  // a band as narrow as the line needs the line resolved: 200 nodes in its width
  auto& bands = simulation.instruments[0].bands;
  bands = test::gaussian_bands({center, center + 1e-3}, 5e-3);
  for (const double fwhm : {5e-4, 5e-5, 1e-5}) bands.push_back(test::gaussian_bands({center}, fwhm)[0]);
  bands.push_back(test::gaussian_bands({center + 1e-5}, 1e-5)[0]);
  bands.push_back(test::gaussian_bands({center + 4e-6}, 3e-6)[0]);  // narrower than the line
  const auto image = test::render_image(simulation, table);
  double least = 1e9, most = 0;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const double expected = fine_mean(bands[b], 1e-8, [&](double l) {
      const double reflectance = 0.2 + 0.3 * (l - 0.7) / 0.12;
      return reflectance * (air.solar_irradiance(l) * air.sun_transmission(l) / kPi + air.sky_radiance(l)) *
                 air.view_transmission(l) +
             4.0;
    });
    const double error = image.at(0, 0, int(b)) / expected - 1;
    least = std::min(least, expected);
    most = std::max(most, expected);
    MESSAGE("band " << bands[b].center_um << " um, FWHM " << bands[b].fwhm_um * 1000 << " nm: " << expected
                    << ", relative error " << error);
    CHECK(std::abs(error) < 1e-4);
  }
  CHECK(least < 0.2 * most);  // the line shows
}

TEST_CASE("S11 S63 bands narrower than the table's step equal fine quadrature of the table's linear spectrum") {
  const std::vector<double> nodes = atmos::wavelength_grid(0.4, 0.8, 0.01);
  std::vector<double> irradiance;
  for (std::size_t i = 0; i < nodes.size(); ++i) irradiance.push_back(1000 + 500 * std::sin(double(i * i)));
  const std::vector<double> curve_um{0.4, 0.503, 0.547, 0.8}, curve{0.1, 0.6, 0.2, 0.9};
  auto simulation = plane(curve_um, curve);
  atmos::UniformAir air;
  air.solar_irradiance = [&](double l) { return linear(nodes, irradiance, l); };
  auto& bands = simulation.instruments[0].bands;
  bands.clear();
  for (const double center : {0.45, 0.4532, 0.503, 0.545, 0.5471, 0.6})
    for (const double fwhm : {1e-4, 2e-3}) bands.push_back(test::gaussian_bands({center}, fwhm)[0]);
  const auto image = test::render_image(simulation, atmos::uniform_table(air, nodes));
  double worst = 0;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const double expected = fine_mean(bands[b], bands[b].fwhm_um / 20000, [&](double l) {
      return linear(curve_um, curve, l) * linear(nodes, irradiance, l) / kPi;
    });
    worst = std::max(worst, std::abs(image.at(0, 0, int(b)) / expected - 1));
  }
  MESSAGE("worst relative error " << worst);
  CHECK(worst < 1e-6);
}

TEST_CASE("S11 S63 bands out of order, duplicate and overlapping: each as if it were alone") {
  auto simulation = plane({0.4, 0.8}, {0.1, 0.7});
  atmos::UniformAir air;
  air.solar_irradiance = [](double l) { return 2000 - 1500 * l; };
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.4, 0.8, 0.005));
  const std::vector<double> centers{0.7, 0.55, 0.5502, 0.55, 0.45};
  simulation.instruments[0].bands = test::gaussian_bands(centers, 0.01);
  const auto together = test::render_image(simulation, table);
  CHECK(together.at(0, 0, 1) == together.at(0, 0, 3));
  for (std::size_t b = 0; b < centers.size(); ++b) {
    simulation.instruments[0].bands = test::gaussian_bands({centers[b]}, 0.01);
    CHECK(test::render_image(simulation, table).at(0, 0, 0) ==
          doctest::Approx(together.at(0, 0, int(b))).epsilon(2e-7));
  }
}

TEST_CASE("S11 S63 a band outside the table, or past the end of a curve, is one clear error") {
  auto simulation = plane({0.5, 0.7}, {0.1, 0.7});
  const auto table = atmos::uniform_table({}, atmos::wavelength_grid(0.45, 0.9, 0.005));
  const auto refused = [&](double center) {
    simulation.instruments[0].bands = test::gaussian_bands({0.6, center}, 0.01);
    try {
      test::render_image(simulation, table);
    } catch (const base::Error& error) {
      CHECK(error.fault() == base::Fault::input);
      return std::string(error.what());
    }
    return std::string("rendered");
  };
  CHECK(refused(0.65) == "rendered");
  CHECK_MESSAGE(refused(0.95).find("atmosphere table") != std::string::npos, refused(0.95));
  CHECK_MESSAGE(refused(0.89).find("band 2") != std::string::npos, refused(0.89));
  CHECK_MESSAGE(refused(0.69).find("'plane'") != std::string::npos,
                refused(0.69));  // inside the table, the curve ends in the band
}

TEST_CASE("S18 S63 transmission of 1e-12: no radiance negative or not a number, on relief under a clear sky") {
  scene::Simulation simulation;
  for (int m = 0; m < 3; ++m) test::add_material(simulation.scene, "m" + std::to_string(m), 0.1 + 0.4 * m);
  auto ground = test::terrain(30, 60);
  for (std::size_t t = 0; t < ground.surface.size(); ++t) ground.surface[t] = static_cast<std::uint32_t>(t % 3);
  test::place(simulation.scene, ground);
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = 50;
  simulation.sun.azimuth_deg = 200;
  auto camera = test::nadir_camera(12, 12, 1000, 3);
  camera.bands.clear();
  for (int b = 0; b < 30; ++b) camera.bands.push_back(test::gaussian_bands({0.86 + 0.005 * b}, 0.004)[0]);
  simulation.instruments = {camera};
  const auto clear = atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 1000,
                                            atmos::wavelength_grid(0.8, 1.1, 0.002), atmos::clear_sky_heights(-8, 8));
  auto dark = clear;  // flat bottom of 1e-12 from 0.92 to 0.96 um with walls of 2 nm; soft shoulders beyond
  const auto absorption = [](double l) {
    return std::pow(10.0, -12 * std::min(1.0, std::exp(-std::max(0.0, std::abs(l - 0.94) - 0.02) / 0.004)));
  };
  dark.rows.erase("sun_optical_depth");  // the transmissions rule
  dark.rows.erase("view_optical_depth");
  const auto& um = dark.axis("wavelength").nodes;
  for (auto& [name, row] : dark.rows)
    if (name == "sun_transmission" || name == "view_transmission" || name == "sky_radiance_solar" ||
        name == "path_radiance_solar" || name == "diffuse_irradiance" || name == "direct_irradiance")
      for (std::size_t i = 0; i < row.values.size(); ++i)
        row.values[i] = static_cast<float>(row.values[i] * absorption(um[i / (row.values.size() / um.size())]));
  const auto image = test::render_image(simulation, dark), open = test::render_image(simulation, clear);
  double least = 1, most_deep = 0;
  int bad = 0, deep = 0;
  for (int line = 0; line < image.lines; ++line)
    for (int pixel = 0; pixel < image.pixels; ++pixel)
      for (int band = 0; band < image.bands; ++band) {
        const float l = image.at(line, pixel, band);
        bad += !(l >= 0) || !std::isfinite(l);
        least = std::min(least, double{l});
        const double center = camera.bands[band].center_um;
        if (std::abs(center - 0.94) > 0.008)
          continue;  // here every node is at the bottom: path radiance rules, and scales with it
        ++deep;
        most_deep = std::max(most_deep, l / (1e-12 * open.at(line, pixel, band)));
      }
  MESSAGE("least radiance " << least << ", " << deep << " deep values, at most " << most_deep
                            << " of 1e-12 of the open window");
  CHECK(bad == 0);
  CHECK(least < 1e-10);
  CHECK(deep > 0);
  CHECK(most_deep < 1);
}

TEST_CASE("S18 transmission of 1e-12 keeps its relative accuracy: a plane equals fine quadrature to 1e-5") {
  const std::vector<double> nodes = atmos::wavelength_grid(0.8, 1.1, 0.002);
  std::vector<double> transmission;
  for (const double l : nodes)
    transmission.push_back(float(std::pow(10.0, -12 * std::exp(-std::pow((l - 0.94) / 0.02, 2)))));
  auto simulation = plane({0.8, 1.1}, {0.3, 0.5});
  atmos::UniformAir air;
  air.sun_transmission = [&](double l) { return linear(nodes, transmission, l); };
  air.sky_radiance = [&](double l) { return 40 * linear(nodes, transmission, l); };
  auto& bands = simulation.instruments[0].bands;
  bands.clear();
  for (int b = 0; b < 30; ++b) bands.push_back(test::gaussian_bands({0.86 + 0.005 * b}, 0.004)[0]);
  const auto image = test::render_image(simulation, atmos::uniform_table(air, nodes));
  double worst = 0, least = 1;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    const double expected = fine_mean(bands[b], 1e-7, [&](double l) {
      return (0.3 + 0.2 * (l - 0.8) / 0.3) * (1000 / kPi + 40) * linear(nodes, transmission, l);
    });
    worst = std::max(worst, std::abs(image.at(0, 0, int(b)) / expected - 1));
    least = std::min(least, expected);
  }
  MESSAGE("least radiance " << least << ", worst relative error " << worst);
  CHECK(least < 1e-7);
  CHECK(worst < 1e-5);
}
