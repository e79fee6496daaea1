// Scattering by molecules. Oracles: the fit that Bodhaine et al. (1999) printed beside their full formula, King factors
// at two wavelengths, quadrature of the phase function, the pressure's column, a calculation by another hand.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <numbers>
#include <string>
#include <vector>

#include "atmos_tables/optics/gauss_legendre.h"
#include "atmos_tables/optics/profile_scaling.h"
#include "atmos_tables/optics/rayleigh_air.h"
#include "atmos_tables/optics/standard_air.h"
#include "atmos_tables/rayleigh.h"
#include "tests/support/anchor_rows.h"
#include "tests/support/relative.h"

using namespace raycube::atmos;
using raycube::test::relative;

TEST_CASE("S18 Rayleigh: the full formula equals the printed fit (Bodhaine et al. 1999, eq. 29) for 360 ppmv CO2") {
  // The paper states 0.01 % from 0.25 to 0.85 um and 0.05 % to 1 um for its fit.
  for (double l = 0.25; l <= 1.0001; l += 0.01) {
    CAPTURE(l);
    const double l2 = l * l, il2 = 1 / l2;
    const double fit =
        1e-28 * (1.0455996 - 341.29061 * il2 - 0.90230850 * l2) / (1 + 0.0027059889 * il2 - 85.968563 * l2);
    CHECK(relative(rayleigh_cross_section_cm2(l, 360), fit) <= (l <= 0.8501 ? 1e-4 : 5e-4));
  }
}

TEST_CASE("S18 Rayleigh: figures at single wavelengths") {
  CHECK(relative(rayleigh_cross_section_cm2(0.55, 360), 4.5105e-27) <= 1e-4);  // printed digits
  CHECK(std::abs(air_king_factor(0.55, 360) - 1.0488) <= 0.6e-4);
  CHECK(std::abs(air_king_factor(0.4, 360) - 1.0513) <= 0.6e-4);
  CHECK(std::abs(air_depolarization(0.55, 360) - 0.0283) <= 0.6e-4);
  CHECK(std::abs(air_depolarization(0.4, 360) - 0.0297) <= 0.6e-4);
  // King factor and depolarisation state the same: F = (6 + 3 rho) / (6 - 7 rho).
  const double rho = air_depolarization(0.7, 420);
  CHECK((6 + 3 * rho) / (6 - 7 * rho) == doctest::Approx(air_king_factor(0.7, 420)).epsilon(1e-14));
}

TEST_CASE("S18 Rayleigh: moments are those of the phase function by quadrature; its integral is 4 pi") {
  const GaussRule rule = gauss_legendre_rule(8);
  for (double rho : {0.0, 0.0283, 0.2}) {
    std::vector<double> phase;
    for (double cosine : rule.node) phase.push_back(phase_rayleigh(rho, cosine));
    const std::vector<double> by_quadrature = legendre_moments(rule, phase, 5), closed = rayleigh_moments(rho);
    for (std::size_t k = 0; k < 6; ++k)
      CHECK(std::abs(by_quadrature[k] - (k < closed.size() ? closed[k] : 0)) <= 1e-14);
    CHECK(legendre_series(closed, -0.3) == doctest::Approx(phase_rayleigh(rho, -0.3)).epsilon(1e-13));
  }
}

TEST_CASE("S18 Rayleigh: depth above a height follows the pressure there, and is proportional to the ground's") {
  for (AfglModel model :
       {AfglModel::tropical, AfglModel::midlatitude_summer, AfglModel::subarctic_winter, AfglModel::us_standard}) {
    const AirProfile profile = afgl_profile(model);
    CAPTURE(profile.source());
    for (double height : {0.0, 0.61, 3.0, 12.0}) {
      CAPTURE(height);
      // Bodhaine eq. 30 carries the pressure's column; the tables' densities and pressures agree to their printed
      // digits, moist air is up to 1 % lighter (tropical), gravity falls 0.3 % per 10 km.
      CHECK(relative(rayleigh_depth_above(profile, height, 0.55),
                     rayleigh_depth(0.55, profile.at(height).pressure_hPa)) <= 1e-2);
    }
    const double here = rayleigh_depth_above(profile, 0, 0.45);
    const AirProfile other = with_ground_pressure(profile, 850);
    CHECK(rayleigh_depth_above(other, 0, 0.45) / here ==
          doctest::Approx(850 / profile.levels()[0].pressure_hPa).epsilon(1e-12));
  }
  // A profile that ends at 10 km loses nothing: the pressure there tells what lies above (moist air and gravity as
  // before).
  const AirProfile whole = afgl_profile(AfglModel::us_standard);
  std::vector<AirLevel> low(whole.levels().begin(), whole.levels().begin() + 11);
  CHECK(relative(rayleigh_depth_above(AirProfile(low, "low part"), 0, 0.55), rayleigh_depth_above(whole, 0, 0.55)) <=
        2e-3);
}

TEST_CASE("S18 Rayleigh: an independent calculation of refractivity, King factor, cross-section and extinction") {
  const std::string name = "lidar/rayleigh_cross_section.csv";
  const auto anchors = raycube::testing::anchor_rows(name, "Rayleigh scattering was not compared with " + name);
  if (anchors.empty()) return;
  CHECK(anchors.size() >= 19);
  for (const auto& row : anchors) {
    const double um = row.at("wavelength_um");
    CAPTURE(um);
    // The file leaves out the step from 300 to 360 ppmv CO2: 3.2e-5 in n - 1, 6.5e-5 in the cross-section.
    CHECK(relative(air_refractivity(um, 300), row.at("refractivity")) <= 2e-6);
    CHECK(std::abs(air_king_factor(um, 360) - row.at("king_factor")) <= 0.6e-5);
    CHECK(std::abs(air_depolarization(um, 360) - row.at("depolarisation")) <= 0.6e-5);
    CHECK(relative(rayleigh_cross_section_cm2(um, 360), row.at("sigma_cm2")) <= 8e-5);
    const double backscatter =
        rayleigh_cross_section_cm2(um, 360) * phase_rayleigh(air_depolarization(um, 360), -1) / (4 * std::numbers::pi);
    CHECK(relative(backscatter, row.at("dsigma_pi_cm2_sr")) <= 8e-5);
  }
}
