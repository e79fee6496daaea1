// The model of Bird & Riordan against the program its authors' laboratory distributes.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "atmos_tables/bird_riordan.h"
#include "tests/support/skipped.h"

using namespace raycube::atmos;

namespace {
BirdRiordanCase worked_example() {
  BirdRiordanCase c;  // the case of pvlib-python's spectrl2_example_spectra.csv, made with NREL's spectrl2_2.c
  c.sun_zenith_deg = 47.912086486816406;
  c.airmass = 1.4899535986910446;
  c.ozone_atm_cm = 0.344;
  c.water_cm = 1.42;
  return c;
}
}  // namespace

TEST_CASE("S18 Bird and Riordan's worked example, figures restated") {
  // wavelength, diffuse horizontal, direct normal, extraterrestrial; W m-2 um-1; six printed digits.
  const double rows[][4] = {{0.3, 0.766597, 0.403357, 541.685},
                            {0.31, 36.4874, 25.0514, 628.714},
                            {0.35, 206.687, 304.39, 986.03},
                            {0.4, 274.637, 717.152, 1495.07}};
  const auto light = bird_riordan_model(worked_example());
  const auto& table = bird_riordan_table();
  REQUIRE(table.size() == 122);
  for (const auto& row : rows) {
    std::size_t i = 0;
    while (i < table.size() && std::abs(table[i].wavelength_um - row[0]) > 1e-9) ++i;
    REQUIRE(i < table.size());
    // 1e-5: five of six printed digits of two programs in float and double.
    CHECK(light[i].diffuse_horizontal == doctest::Approx(row[1]).epsilon(1e-5));
    CHECK(light[i].direct_normal == doctest::Approx(row[2]).epsilon(1e-5));
    CHECK(light[i].extraterrestrial == doctest::Approx(row[3]).epsilon(1e-5));
  }
}

TEST_CASE("A-21 S18 Bird and Riordan's worked example, all 122 wavelengths") {
  const char* shared = std::getenv("RAYCUBE_SHARED");
  if (!shared) {
    raycube::testing::skip_part("the 122 wavelengths of the worked example were not compared");
    return;
  }
  std::ifstream file(std::string(shared) + "/reference/atmosphere/gas/spctrl2_example_output.csv");
  REQUIRE(file.good());
  const auto light = bird_riordan_model(worked_example());
  std::size_t i = 0;
  for (std::string line; std::getline(file, line);) {
    double wavelength, diffuse, direct, top, global;
    char comma;
    std::istringstream in(line);
    if (!(in >> wavelength >> comma >> diffuse >> comma >> direct >> comma >> top >> comma >> global)) continue;
    REQUIRE(i < light.size());
    CHECK(light[i].direct_normal == doctest::Approx(direct).epsilon(1e-5));
    CHECK(light[i].diffuse_horizontal == doctest::Approx(diffuse).epsilon(1e-5));
    ++i;
  }
  CHECK(i == 122);
}
