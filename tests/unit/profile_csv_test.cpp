// A user's profile read from CSV: units by column name, all faults with their lines.
#include <doctest/doctest.h>

#include <cmath>
#include <sstream>
#include <string>

#include "atmos_tables/optics/profile_csv.h"
#include "atmos_tables/optics/profile_scaling.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {
AirProfile read(const std::string& text) {
  std::istringstream in(text);
  return read_profile_csv(in, "air.csv").air;
}

std::string message(const std::string& text) {
  return testing::refusal([&] { read(text); });
}

bool holds(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }
}  // namespace

TEST_CASE("S18 profile files: the same air in two sets of units, upwards and downwards, gives one profile") {
  const AirProfile a = read(
      "# "
      "sounding\nheight_km,pressure_hPa,temperature_K,h2o_ppmv,co2_ppmv\n0,1000,290,10000,420\n2,790,278.15,4000,"
      "420\n");
  // 10000 ppmv of p / (k T): 2.497576e17 cm-3 at 1000 hPa and 290 K.
  const AirProfile b = read(
      "\xef\xbb\xbfheight_m, temperature_C ,pressure_Pa,h2o_per_cm3,co2_ppmv\r\n"
      "2000,5,79000,8.228577e16,420\r\n\r\n0,16.85,100000,2.497576e17,420\r\n");
  REQUIRE(a.levels().size() == 2);
  REQUIRE(b.levels().size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    CHECK(a.levels()[i].height_km == doctest::Approx(b.levels()[i].height_km).epsilon(1e-14));
    CHECK(a.levels()[i].pressure_hPa == doctest::Approx(b.levels()[i].pressure_hPa).epsilon(1e-14));
    CHECK(a.levels()[i].temperature_K == doctest::Approx(b.levels()[i].temperature_K).epsilon(1e-14));
    CHECK(a.levels()[i].air_per_cm3 == doctest::Approx(b.levels()[i].air_per_cm3).epsilon(1e-14));
    CHECK(a.levels()[i].gas(Gas::h2o) == doctest::Approx(b.levels()[i].gas(Gas::h2o)).epsilon(1e-6));
    CHECK(a.levels()[i].ppmv(Gas::co2) == doctest::Approx(420).epsilon(1e-14));
  }
  // Loschmidt's number: 1013.25 hPa and 273.15 K.
  const AirProfile standard = read("height_km,pressure_hPa,temperature_C\n0,1013.25,0\n1,900,-5\n");
  CHECK(standard.levels()[0].air_per_cm3 == doctest::Approx(kLoschmidt_per_cm3).epsilon(1e-9));
  CHECK(standard.levels()[0].gas(Gas::ch4) == 0);
}

TEST_CASE("S18 profile files: humidity as mass and as relative humidity") {
  // 100 % at 20 C are 17.3 g m-3 in every table of meteorology; Magnus' formula holds to 0.4 %.
  const AirProfile mass = read("height_km,pressure_hPa,temperature_C,h2o_g_per_m3\n0,1013,20,17.3\n1,900,15,5\n");
  const AirProfile relative =
      read("height_km,pressure_hPa,temperature_C,h2o_relative_humidity_percent\n0,1013,20,100\n1,900,15,50\n");
  CHECK(mass.levels()[0].gas(Gas::h2o) == doctest::Approx(relative.levels()[0].gas(Gas::h2o)).epsilon(4e-3));
  CHECK(mass.levels()[0].gas(Gas::h2o) == doctest::Approx(17.3e-6 / 18.0153 * 6.02214076e23).epsilon(1e-12));
}

TEST_CASE("S18 profile files: every fault is listed with file and line") {
  const std::string head = "height_km,pressure_hPa,temperature_K,h2o_ppmv\n";
  const std::string text =
      message(head + "0,1000,290,nan\n1,900,280\n2,-5,280,10\n3,700,abc,10\n4,600,260,2e6\n5,,250,1\n");
  for (const char* part :
       {"air.csv:2", "air.csv:3", "air.csv:4", "air.csv:5", "air.csv:6", "air.csv:7", "'nan'", "'abc'", "'-5'", "''"}) {
    CAPTURE(part);
    CHECK(holds(text, part));
  }
  CHECK(holds(message(head + "0,1000,290,1\n1,1001,280,1\n"), "air.csv:3"));
  CHECK(holds(message(head + "0,1000,290,1\n1,1001,280,1\n"), "pressure must fall"));
  CHECK(holds(message(head + "0,1000,290,1\n1,900,280,1\n1,800,270,1\n"), "air.csv:4"));
  CHECK(holds(message(head + "0,1000,290,1\n"), "at least 2 levels"));
  CHECK(holds(message(""), "no header"));
  CHECK(holds(message("z,pressure_hPa,temperature_K,xe_ppmv\n"), "unknown column"));
  CHECK(holds(message("z,pressure_hPa,temperature_K,xe_ppmv\n"), "'xe_ppmv'"));
  CHECK(holds(message("height_km,pressure_hPa\n"), "no column for temperature"));
  CHECK(holds(message("height_km,height_m,pressure_hPa,temperature_K\n"), "two columns give height"));
  CHECK(holds(
      message("height_km,pressure_hPa,temperature_K,air_per_cm3,o3_per_cm3\n0,1000,290,2e19,3e19\n1,900,280,1e19,1\n"),
      "more than all the air"));
  CHECK_THROWS_AS(read_profile_csv("/nowhere/air.csv"), base::Error);
}
