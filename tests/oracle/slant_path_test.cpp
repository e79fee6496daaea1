// Slant paths through spherical air: chords and Chapman's function, then LOWTRAN7's spherical refracting ray
// trace.
#include <doctest/doctest.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>

#include "atmos_tables/solver/slant_path.h"
#include "host/base/error.h"
#include "tests/support/solver_cases.h"

using namespace raycube::atmos::solver;
using namespace raycube::test;

namespace {
constexpr double kPi = std::numbers::pi;

/// Straight-ray air to 100 km in shells of 1 km.
RefractingAir plain_air() {
  RefractingAir air;
  for (int i = 100; i >= 0; --i) air.height_m.push_back(1000.0 * i);
  return air;
}
}  // namespace

TEST_CASE("S18 A-17 rays are chords where nothing refracts") {
  const RefractingAir air = plain_air();
  const std::vector<double> one(air.height_m.size(), 1.0);
  const double r = 6371.23e3, top = r + 100e3;
  for (double zenith : {0.0, 30.0, 75.0, 89.0, 90.0}) {
    const double s = std::sin(zenith * kPi / 180), c = std::cos(zenith * kPi / 180);
    CHECK(slant_amount(air, one, zenith) ==
          doctest::Approx(std::sqrt(top * top - r * r * s * s) - r * c).epsilon(1e-9));
  }
}

TEST_CASE("S18 A-17 an exponential absorber has Chapman's airmass at the horizon") {
  // x K1(x) e^x = sqrt(pi x / 2) (1 + 3/(8x) - 15/(128 x^2)), x = r/H (Chapman 1931). The air above 100 km,
  // e^-20, is not in it.
  const RefractingAir air = plain_air();
  std::vector<double> density;
  for (double height : air.height_m) density.push_back(std::exp(-height / 5000));
  const double x = 6371.23e3 / 5000;
  CHECK(relative_airmass(air, density, 90) ==
        doctest::Approx(std::sqrt(kPi * x / 2) * (1 + 3 / (8 * x) - 15 / (128 * x * x))).epsilon(1e-7));
  CHECK(relative_airmass(air, density, 0) == 1);
  CHECK(relative_airmass(air, std::vector<double>(density.size(), 0.0), 80) == 1);
}

TEST_CASE("S18 A-17 uniform refraction bends nothing; air thinning upward lengthens the horizontal path's amount") {
  RefractingAir air = plain_air();
  std::vector<double> density;
  for (double height : air.height_m) density.push_back(std::exp(-height / 8000));
  const double straight = relative_airmass(air, density, 90);
  air.refractivity.assign(density.size(), 3e-4);
  CHECK(relative_airmass(air, density, 90) == doctest::Approx(straight).epsilon(1e-12));
  // Bouguer near the ground: the ray's curvature is that of a planet of radius r / (1 - r N / H), so the
  // airmass of a horizontal ray grows by about 1/sqrt(1 - r N / H), less what the curvature loses with height
  // (of order r N / H squared).
  const double n1 = 1e-5, bend = 6371.23e3 * n1 / 8000;
  for (std::size_t i = 0; i < density.size(); ++i) air.refractivity[i] = n1 * density[i];
  const double gain = relative_airmass(air, density, 90) / straight - 1;
  CHECK(gain > 0);
  CHECK(gain < 1 / std::sqrt(1 - bend) - 1);
}

TEST_CASE(
    "S18 A-17 airmass of air, ozone, water continuum and haze, and length of the ray: LOWTRAN7 to 0.3 % (80 "
    "deg), 1 % (88 deg), 3 % (90 deg)") {
  const std::vector<CsvRow> reference = benchmark("../anchors/lowtran7_airmass_mls.csv", "A-17");
  if (reference.empty()) return;
  const std::vector<CsvRow> profile = benchmark("../profiles/afgl_midlatitude_summer.csv", "A-17");
  RefractingAir air;
  std::vector<double> molecules, ozone, water, haze_low, haze_high;
  const std::vector<CsvRow> haze = benchmark("../aerosol/lowtran7_aerosol_profiles.csv", "A-17");
  for (auto row = profile.rbegin(); row != profile.rend(); ++row) {
    if (number(*row, "z_km") > 100) continue;  // where LOWTRAN7 ends
    const double density = number(*row, "air_cm3");
    air.height_m.push_back(1000 * number(*row, "z_km"));
    // Visible refractivity at 1013.25 hPa and 288.15 K: 2.77e-4 (Edlen 1966), proportional to p / T.
    air.refractivity.push_back(2.77e-4 * number(*row, "p_hPa") / 1013.25 * 288.15 / number(*row, "T_K"));
    molecules.push_back(density);
    ozone.push_back(density * number(*row, "o3_ppmv"));
    water.push_back(density * density * number(*row, "h2o_ppmv"));  // foreign continuum: product of the densities
    double low = 0, high = 0;  // rural haze of 23 km, spring-summer: 0 to 2 km and 2 to 10 km
    for (const CsvRow& level : haze)
      if (number(level, "z_km") == number(*row, "z_km")) {
        low = number(level, "bl_vis23");
        high = number(level, "trop_ss_vis23");
      }
    haze_low.push_back(low);
    haze_high.push_back(high);
  }
  REQUIRE(air.height_m.size() > 40);
  const std::vector<double> one(air.height_m.size(), 1.0);
  double worst[3] = {};
  for (const CsvRow& row : reference) {
    const double zenith = number(row, "zenith_deg");
    const int band = zenith <= 80 ? 0 : zenith <= 88 ? 1 : 2;
    const double errors[] = {relative_airmass(air, molecules, zenith) / number(row, "mol") - 1,
                             relative_airmass(air, ozone, zenith) / number(row, "o3") - 1,
                             relative_airmass(air, water, zenith) / number(row, "h2o_cont") - 1,
                             relative_airmass(air, haze_low, zenith) / number(row, "aer1") - 1,
                             relative_airmass(air, haze_high, zenith) / number(row, "aer2") - 1,
                             slant_amount(air, one, zenith) / 1000 / number(row, "range_km") - 1};
    for (double error : errors) worst[band] = std::max(worst[band], std::abs(error));
  }
  std::cout << "A-17 air, ozone, water continuum, haze, length: worst " << worst[0] << " to 80 deg, " << worst[1]
            << " to 88, " << worst[2] << " to 90\n";
  CHECK(worst[0] <= 0.003);
  CHECK(worst[1] <= 0.01);
  CHECK(worst[2] <= 0.03);
}

TEST_CASE("S18 a wrong slant path is refused with every fault named") {
  RefractingAir air;
  air.height_m = {0, 1000};
  air.refractivity = {1};
  try {
    slant_amount(air, {std::numeric_limits<double>::quiet_NaN(), 1}, 91);
    FAIL("accepted");
  } catch (const raycube::base::Error& error) {
    const std::string text = error.what();
    for (const char* part : {"heights must fall", "refractivity", "density", "zenith"})
      CHECK_MESSAGE(text.find(part) != std::string::npos, part);
  }
}
