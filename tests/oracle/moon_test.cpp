// The moon. Oracles: LOWTRAN7's lunar runs (phase angle 30 degrees), which follow the same sun and the same air.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "atmos_tables/moon.h"
#include "host/base/error.h"
#include "tests/support/anchor_rows.h"

using namespace raycube;
using namespace raycube::atmos;

TEST_CASE("S4.11 moon: the full moon is 2e-6 of the sun in the visible, and wanes to nothing") {
  CHECK(moon_over_sun(0, 0.5) == doctest::Approx(2.04472e-6).epsilon(1e-12));
  CHECK(moon_over_sun(90, 0.5) == doctest::Approx(0.067 * 2.04472e-6).epsilon(1e-12));
  double before = 1;
  for (double angle = 0; angle <= 180; angle += 2.5) {
    const double now = moon_over_sun(angle, 0.7);
    CHECK(now < before);
    before = now;
  }
  CHECK(moon_over_sun(170, 0.7) == doctest::Approx(moon_over_sun(160, 0.7) / 2));
  CHECK(moon_over_sun(180, 0.7) == 0);
  CHECK(moon_over_sun(0, 12) == doctest::Approx(0.4 * 2.04472e-5));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (double angle : {-1.0, 180.1, nan}) CHECK_THROWS_AS(moon_over_sun(angle, 0.5), base::Error);
  for (double wave : {0.29, 31.0, nan}) CHECK_THROWS_AS(moon_over_sun(30, wave), base::Error);
}

TEST_CASE("S4.11 moon: LOWTRAN7's lunar irradiance above the air and on the ground, 0.3 to 2.5 um") {
  const std::string name = "anchors/lowtran7_direct_vnir_swir.csv";
  const auto anchors = testing::anchor_rows(name, "the moon was not compared with " + name);
  if (anchors.empty()) return;
  int rows = 0;
  for (const auto& row : anchors) {
    const double wavelength_um = 1e4 / row.at("nu_cm1"), sun = row.at("E0"), transmission = row.at("T_0.0_s40"),
                 moon = row.at("Emoon0"), moon_on_ground = row.at("Emoon_0.0_s40");
    if (wavelength_um < 0.3) continue;
    CAPTURE(wavelength_um);
    // 4 printed digits: 5e-4 of the smallest mantissa.
    CHECK(std::abs(moon_over_sun(30, wavelength_um) * sun / moon - 1) <= 7e-4);
    // The transmission is printed to 5e-6.
    if (transmission > 0.02)
      CHECK(std::abs(moon_over_sun(30, wavelength_um) * sun * transmission / moon_on_ground - 1) <=
            1e-3 + 5e-6 / transmission);
    ++rows;
  }
  CHECK(rows >= 1400);
}
