// A tilted Lambertian plane with nothing to block its light: the whole chain against closed forms (S15, S16, S18).
// Geometry: one rectangle tilted 25 degrees, framing camera straight above, 16 samples a pixel. The sky is integrated
// on the whole hemisphere by the test itself, in double, from the same table.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/clear_sky.h"
#include "host/base/units.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/synthetic.h"
#include "host/render/truth.h"
#include "tests/support/render_kit.h"

namespace {

using namespace raycube;
constexpr double kPi = std::numbers::pi;

/// A plane tilted by `tilt_deg` towards azimuth `azimuth_deg`, through the origin, 200 m across, reflectance 0.3.
scene::Simulation tilted_plane(double tilt_deg, double azimuth_deg, double sun_zenith_deg, double sun_azimuth_deg) {
  scene::Simulation simulation;
  const auto surface = test::add_material(simulation.scene, "grey", 0.3);
  const double c = std::cos(base::rad_from_deg(tilt_deg)), s = std::sin(base::rad_from_deg(tilt_deg));
  const double ax = std::sin(base::rad_from_deg(azimuth_deg)), ay = std::cos(base::rad_from_deg(azimuth_deg));
  const std::array<double, 3> down{100 * ax * c, 100 * ay * c, -100 * s},
      side{-200 * ay, 200 * ax, 0};  // down: along the fall line
  test::place(simulation.scene, test::rectangle({-down[0] - side[0] / 2, -down[1] - side[1] / 2, -down[2]},
                                                {2 * down[0], 2 * down[1], 2 * down[2]}, side, surface));
  finish_top_tree(simulation.scene);
  simulation.sun.zenith_deg = sun_zenith_deg;
  simulation.sun.azimuth_deg = sun_azimuth_deg;
  simulation.instruments = {test::nadir_camera(6, 5, 1000, 1.0)};
  return simulation;
}

}  // namespace

TEST_CASE("S15 tilted plane under sun, uniform sky and path radiance equals the closed form to 1e-5") {
  const double tilt_deg = 25, azimuth_deg = 110, sun_zenith_deg = 40, sun_azimuth_deg = 160;
  auto simulation = tilted_plane(tilt_deg, azimuth_deg, sun_zenith_deg, sun_azimuth_deg);
  const atmos::UniformAir air = test::uniform_air({1500, 0.8, 0.7, 1.04, 30, 5}, simulation.sun);
  const auto table = atmos::uniform_table(air, atmos::wavelength_grid(0.3, 2.5, 0.01));
  const auto image = test::render_image(simulation, table);
  const double cosine = std::cos(base::rad_from_deg(tilt_deg)) * std::cos(base::rad_from_deg(sun_zenith_deg)) +
                        std::sin(base::rad_from_deg(tilt_deg)) * std::sin(base::rad_from_deg(sun_zenith_deg)) *
                            std::cos(base::rad_from_deg(azimuth_deg - sun_azimuth_deg));
  const double sky = 30.0 * kPi * (1 + std::cos(base::rad_from_deg(tilt_deg))) / 2;
  const double expected = 0.3 / kPi * (1500 * 0.8 * 0.7 * 1.04 * cosine + sky * 0.7 * 1.04) + 5.0;
  const double worst = test::worst_relative(image, {expected, expected, expected});
  MESSAGE("largest relative error " << worst);
  CHECK(worst < 1e-5);
  CHECK(image.layer(2, 3, render::truth::hit_fraction) == doctest::Approx(1.0).epsilon(1e-6));  // every sample hit
  CHECK(image.layer(2, 3, render::truth::sun_fraction) == doctest::Approx(1.0).epsilon(1e-6));  // and saw the sun
}

TEST_CASE("S18 tilted plane under a real clear sky equals quadrature of the table to 1e-5") {
  for (const double tilt_deg : {0.0, 35.0}) {
    const double azimuth_deg = 200, sun_zenith_deg = 50, sun_azimuth_deg = 150;
    auto simulation = tilted_plane(tilt_deg, azimuth_deg, sun_zenith_deg, sun_azimuth_deg);
    // Four close wavelengths: four sky components carry the table exactly, and a product of linear spectra is linear to
    // 1e-6 (what truncation and coarse grids cost is measured by the plan's own tests).
    // One height: the table states that nothing varies with it, so that the closed form needs no height integral.
    simulation.sun.day_of_year = 264;
    const auto table =
        atmos::build_clear_sky(simulation.atmosphere, simulation.sun, 1000.0, {0.546, 0.549, 0.552, 0.555}, {0.0});
    simulation.instruments[0].bands = test::gaussian_bands({0.549, 0.5505, 0.552}, 0.001);
    simulation.tolerance = 1e-4;
    const auto image = test::render_image(simulation, table, {}, [](plan::Plan& plan) {
      // Path radiance and view transmission have their own tests; here they would add their interpolation.
      for (auto& spectrum : plan.path_spectrum) std::fill(spectrum.begin(), spectrum.end(), 0.0);
    });
    // Irradiance on the plane per sky component: midpoint rule on 0.25 degree cells of the hemisphere, weights exact in
    // zenith. The table's own sky, summed by the same rule, shows what the plan's angular maps (linear between their
    // nodes) cost.
    const auto& wavelength = atmos::wavelengths(table);
    const std::array<double, 3> normal{
        std::sin(base::rad_from_deg(tilt_deg)) * std::sin(base::rad_from_deg(azimuth_deg)),
        std::sin(base::rad_from_deg(tilt_deg)) * std::cos(base::rad_from_deg(azimuth_deg)),
        std::cos(base::rad_from_deg(tilt_deg))};
    std::array<double, 4> component{};
    std::vector<double> from_table(wavelength.size(), 0.0);
    const double step = 0.25;
    for (double zenith = step / 2; zenith < 90; zenith += step)
      for (double azimuth = step / 2; azimuth < 360; azimuth += step) {
        const double s = std::sin(base::rad_from_deg(zenith)), x = s * std::sin(base::rad_from_deg(azimuth)),
                     y = s * std::cos(base::rad_from_deg(azimuth));
        const double z = std::cos(base::rad_from_deg(zenith)), cosine = normal[0] * x + normal[1] * y + normal[2] * z;
        if (cosine <= 0) continue;
        const double omega =
            (std::cos(base::rad_from_deg(zenith - step / 2)) - std::cos(base::rad_from_deg(zenith + step / 2))) *
            base::rad_from_deg(step);
        const auto maps = plan::sky_value(image.plan.sky_basis, base::rad_from_deg(sun_azimuth_deg), x, y, z);
        for (int m = 0; m < 4; ++m) component[m] += maps[m] * cosine * omega;
        if (std::fmod(zenith, 1) != 0.625 || std::fmod(azimuth, 1) != 0.625)
          continue;  // one cell in 16 is enough for 1e-3
        const auto sky = atmos::sky_radiance(table, 0, zenith, azimuth - sun_azimuth_deg);
        for (std::size_t i = 0; i < sky.size(); ++i) from_table[i] += sky[i] * cosine * omega * 16;
      }
    const auto two_way = atmos::two_way_transmission(table, 0, 0);
    const auto view = atmos::view_transmission(table, 0, 0);
    const auto factor = atmos::two_way_factor(table, 0, 0);
    const auto sun = atmos::solar_irradiance(table);
    const double cos_sun =
        normal[0] * std::sin(base::rad_from_deg(sun_zenith_deg)) * std::sin(base::rad_from_deg(sun_azimuth_deg)) +
        normal[1] * std::sin(base::rad_from_deg(sun_zenith_deg)) * std::cos(base::rad_from_deg(sun_azimuth_deg)) +
        normal[2] * std::cos(base::rad_from_deg(sun_zenith_deg));
    std::vector<double> radiance(wavelength.size());
    for (std::size_t i = 0; i < radiance.size(); ++i) {
      const auto at = std::find_if(image.plan.wavelength_um.begin(), image.plan.wavelength_um.end(),
                                   [&](double l) { return std::abs(l - wavelength[i]) < 1e-9; }) -
                      image.plan.wavelength_um.begin();
      double sky = 0;  // radiance of unit reflectance, the air on the way to the sensor included
      for (int m = 0; m < image.plan.sky_components; ++m) sky += image.plan.source_spectrum[1 + m][at] * component[m];
      CHECK(sky == doctest::Approx(from_table[i] * view[i] * factor[i] / kPi).epsilon(2e-3));
      radiance[i] = 0.3 * (sun[i] * two_way[i] * std::max(0.0, cos_sun) / kPi + sky);
    }
    // Band averages of the piecewise-linear spectrum, by a fine trapezoid.
    std::vector<double> expected;
    for (const auto& band : simulation.instruments[0].bands) {
      double sum = 0, norm = 0;
      for (double l = 0.54601; l <= 0.55499; l += 1e-6) {
        const double response = std::exp(-4 * std::log(2.0) * std::pow((l - band.center_um) / band.fwhm_um, 2));
        const auto at = std::min<std::size_t>(
            std::upper_bound(wavelength.begin(), wavelength.end(), l) - wavelength.begin(), wavelength.size() - 1);
        const double f = (l - wavelength[at - 1]) / (wavelength[at] - wavelength[at - 1]);
        sum += response * (radiance[at - 1] * (1 - f) + radiance[at] * f);
        norm += response;
      }
      expected.push_back(sum / norm);
    }
    const double worst = test::worst_relative(image, expected);
    MESSAGE("tilt " << tilt_deg << ": largest relative error " << worst);
    CHECK(worst < 1e-5);
  }
}
