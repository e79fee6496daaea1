// Profiles. Oracles: the exponential atmosphere in closed form, the tables of the US Standard Atmosphere 1976, column
// amounts published for the AFGL models, hydrostatic equilibrium.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <string>
#include <vector>

#include "atmos_tables/optics/air_profile.h"
#include "atmos_tables/optics/profile_scaling.h"
#include "atmos_tables/optics/standard_air.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"
#include "tests/support/relative.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::test::relative;
using raycube::testing::refusal;

namespace {

AirLevel level(double height_km, double pressure_hPa, double temperature_K, double air) {
  AirLevel out;
  out.height_km = height_km, out.pressure_hPa = pressure_hPa, out.temperature_K = temperature_K, out.air_per_cm3 = air;
  return out;
}

}  // namespace

TEST_CASE("S18 profiles: an exponential atmosphere is met exactly, whatever the levels") {
  const double scale_km = 7.5, ground = 2.5e19;
  std::vector<AirLevel> levels;
  for (double z : {0.0, 0.3, 2.0, 2.1, 9.0, 31.0, 80.0}) {
    levels.push_back(level(z, 1000 * std::exp(-z / scale_km), 288 - z, ground * std::exp(-z / scale_km)));
    levels.back().gas(Gas::h2o) = 1e17 * std::exp(-z / 2);
    levels.back().gas(Gas::co2) = 1e13;  // the same everywhere: the limit of the layer rule
  }
  const AirProfile profile(levels, "exponential");
  for (double low : {0.0, 0.1, 2.05, 8.99, 40.0})
    for (double high : {0.2, 2.1, 30.0, 80.0}) {
      if (high < low) continue;
      const double air = ground * scale_km * 1e5 * (std::exp(-low / scale_km) - std::exp(-high / scale_km));
      CHECK(relative(profile.air_column_per_cm2(low, high), air) <= 1e-12);
      const double water = 1e17 * 2e5 * (std::exp(-low / 2) - std::exp(-high / 2));
      CHECK(relative(profile.gas_column_per_cm2(Gas::h2o, low, high), water) <= 1e-12);
      CHECK(relative(profile.gas_column_per_cm2(Gas::co2, low, high), 1e18 * (high - low)) <= 1e-12);
      CHECK(profile.gas_column_per_cm2(Gas::o3, low, high) == 0);
    }
  for (double z : {0.0, 1.0, 2.05, 50.0, 80.0}) {
    CHECK(relative(profile.at(z).pressure_hPa, 1000 * std::exp(-z / scale_km)) <= 1e-13);
    CHECK(relative(profile.at(z).gas(Gas::h2o), 1e17 * std::exp(-z / 2)) <= 1e-12);
    CHECK(relative(profile.at(z).temperature_K, 288 - z) <= 1e-14);
  }
  // A gas that ends at a level falls linearly to it.
  levels[3].gas(Gas::ch4) = 4e13;
  const AirProfile ends(levels, "a gas in two layers");
  CHECK(relative(ends.gas_column_per_cm2(Gas::ch4, 0, 80), 0.5 * 4e13 * 1e5 * (0.1 + 6.9)) <= 1e-12);
}

TEST_CASE("S18 profiles: US Standard Atmosphere 1976 at its printed values") {
  // Table 4: pressures at the layers' bases, geopotential km; here as geometric heights r H / (r - H).
  const double table[][3] = {{0, 1013.25, 288.15},    {11, 226.3206, 216.65}, {20, 54.74889, 216.65},
                             {32, 8.680187, 228.65},  {47, 1.109063, 270.65}, {51, 0.6693887, 270.65},
                             {71, 0.03956420, 214.65}};
  for (const auto& row : table) {
    CAPTURE(row[0]);
    const StandardAir air = us_standard_1976(6356.766 * row[0] / (6356.766 - row[0]));
    CHECK(relative(air.pressure_hPa, row[1]) <= 2e-7);
    CHECK(std::abs(air.temperature_K - row[2]) <= 1e-9);
  }
  // Tables I and VIII, geometric km: 5 digits.
  const double geometric[][4] = {{5, 540.48, 255.676, 1.5312e19},
                                 {10, 264.99, 223.252, 8.5976e18},
                                 {30, 11.970, 226.509, 3.8278e17},
                                 {50, 0.79779, 270.650, 2.1351e16}};
  for (const auto& row : geometric) {
    CAPTURE(row[0]);
    const StandardAir air = us_standard_1976(row[0]);
    CHECK(relative(air.pressure_hPa, row[1]) <= 5e-5);
    CHECK(std::abs(air.temperature_K - row[2]) <= 6e-4);
    CHECK(relative(air.air_per_cm3, row[3]) <= 5e-5);
  }
  CHECK(relative(us_standard_1976(0).air_per_cm3, 2.5470e19) <= 3e-5);
  CHECK(refusal([] { us_standard_1976(81); }).find("80 km") != std::string::npos);
  CHECK(refusal([] { us_standard_1976(std::nan("")); }).find("80 km") != std::string::npos);
}

TEST_CASE("S18 profiles: the AFGL models are hydrostatic and hold the published columns") {
  for (int i = 0; i < 6; ++i) {
    const AirProfile profile = afgl_profile(static_cast<AfglModel>(i));
    CAPTURE(profile.source());
    CHECK(profile.levels().size() == 50);
    // p / (m g) against the column of densities: tables of four digits; water makes tropical air 1 % lighter.
    const double by_pressure = 100 * profile.levels()[0].pressure_hPa / 9.80665 * 1e-4 / dry_air_molecule_kg(330);
    CHECK(relative(profile.air_above_per_cm2(0), by_pressure) <= 1e-2);
    // Each level is an ideal gas (densities of the tables are rounded to four digits, pressures to three or four).
    for (const AirLevel& row : profile.levels()) {
      if (row.height_km > 80) continue;
      CAPTURE(row.height_km);
      CHECK(relative(row.air_per_cm3, 1e-4 * row.pressure_hPa / (kBoltzmann_J_per_K * row.temperature_K)) <= 1e-2);
    }
  }
  // ATMOSPHERE.md S4.4, LOWTRAN7's own columns 0 to 100 km: water 2.92 g cm-2, ozone 0.3317 atm-cm.
  const AirProfile summer = afgl_profile(AfglModel::midlatitude_summer);
  // It steps by 5 km and more above 25 km, which costs it 0.8 % of the ozone: the same levels here, the printed digits.
  std::vector<AirLevel> coarse;
  for (const AirLevel& row : summer.levels()) {
    const double z = row.height_km;
    if (z <= 25 || z == 30 || z == 35 || z == 40 || z == 45 || z == 50 || z == 70 || z == 100) coarse.push_back(row);
  }
  const AirProfile lowtran(coarse, "LOWTRAN7's levels");
  CHECK(std::abs(lowtran.water_g_cm2() - 2.92) <= 0.005);
  // Its atm-cm per molecule are 3.7194e-21 instead of 1e5 km-1 / Loschmidt's number = 3.7219e-21.
  CHECK(std::abs(lowtran.ozone_atm_cm() * 3.7194 / 3.7219 - 0.3317) <= 0.6e-4);
  CHECK(relative(summer.ozone_atm_cm(), lowtran.ozone_atm_cm()) <= 1e-2);
  // The tables restate the standard atmosphere of 1976: its formulas, to their digits (and 0.1 K).
  const AirProfile standard = afgl_profile(AfglModel::us_standard);
  for (const AirLevel& row : standard.levels()) {
    if (row.height_km > 30) continue;
    CAPTURE(row.height_km);
    CHECK(relative(row.pressure_hPa, us_standard_1976(row.height_km).pressure_hPa) <= 1e-3);
    CHECK(std::abs(row.temperature_K - us_standard_1976(row.height_km).temperature_K) <= 0.06);
    CHECK(relative(row.air_per_cm3, us_standard_1976(row.height_km).air_per_cm3) <= 1.2e-3);
  }
}

TEST_CASE("ground below a profile's lowest level: US Standard Atmosphere formulas below the sea") {
  // The Dead Sea's shore, -0.43 km: formulas of US Standard 1976 against the AFGL profile carried on by its lowest
  // layer.
  const AirProfile low = extended_down(afgl_profile(AfglModel::us_standard), -0.43);
  const StandardAir exact = us_standard_1976(-0.43);
  CHECK(low.ground_km() == -0.43);
  CHECK(low.levels().front().temperature_K == doctest::Approx(exact.temperature_K).epsilon(2e-4));
  CHECK(low.levels().front().pressure_hPa == doctest::Approx(exact.pressure_hPa).epsilon(2e-3));
  CHECK(low.levels().front().air_per_cm3 == doctest::Approx(exact.air_per_cm3).epsilon(2e-3));
  CHECK(low.levels().size() == afgl_profile(AfglModel::us_standard).levels().size() + 1);
  CHECK(extended_down(low, 0.5).ground_km() == -0.43);
  CHECK_THROWS_AS(extended_down(low, -2), base::Error);
  // A thin inversion at the ground does not run away: 2 K over 10 m would be 100 K at -0.5 km.
  auto levels = afgl_profile(AfglModel::us_standard).levels();
  AirLevel thin = afgl_profile(AfglModel::us_standard).at(0.01);
  thin.temperature_K += 2;
  levels.insert(levels.begin() + 1, thin);
  const AirLevel below = extended_down(AirProfile(levels, "inversion"), -0.5).levels().front();
  CHECK(std::abs(below.temperature_K - levels[0].temperature_K) < 5);
}

TEST_CASE("S18 profiles: scaling meets the stated columns and mixing ratios") {
  const AirProfile profile = afgl_profile(AfglModel::midlatitude_summer);
  CHECK(relative(with_ozone_column(profile, 0.3).ozone_atm_cm(), 0.3) <= 1e-12);
  CHECK(relative(with_ground_mixing_ratio(profile, Gas::co2, 420).at(5).ppmv(Gas::co2), 420) <= 1e-12);
  CHECK(relative(with_ground_mixing_ratio(profile, Gas::ch4, 1.9).levels()[0].ppmv(Gas::ch4), 1.9) <= 1e-12);

  const WaterScaling half = with_water_column(profile, 1.5);
  CHECK(half.capped_levels == 0);
  CHECK(relative(half.profile.water_g_cm2(), 1.5) <= 1e-11);
  CHECK(relative(half.factor, 1.5 / profile.water_g_cm2()) <= 1e-11);
  CHECK(with_water_column(profile, 0).profile.water_g_cm2() == 0);

  const WaterScaling wet = with_water_column(profile, 4.3);
  CHECK(wet.capped_levels > 0);
  CHECK(relative(wet.profile.water_g_cm2(), 4.3) <= 1e-9);
  for (std::size_t i = 0; i < profile.levels().size(); ++i) {
    const AirLevel& row = wet.profile.levels()[i];
    const double vapour_hPa = 1e4 * row.gas(Gas::h2o) * kBoltzmann_J_per_K * row.temperature_K;
    CHECK((vapour_hPa <= saturation_pressure_hPa(row.temperature_K) * (1 + 1e-12) ||
           row.gas(Gas::h2o) == profile.levels()[i].gas(Gas::h2o)));
  }
  // Nearly saturated: no air above the tropopause is moister than what passes its cold.
  const AirProfile moist = with_water_column(profile, 5.3).profile;
  double passes = 1;
  for (const AirLevel& row : moist.levels()) {
    if (row.height_km < 12 || row.height_km > 60) continue;  // above 300 hPa; below the table's own moist mesosphere
    passes = std::min(passes, saturation_pressure_hPa(row.temperature_K) / row.pressure_hPa);
    CHECK(1e-6 * row.ppmv(Gas::h2o) <= passes * (1 + 1e-3));  // densities of the tables are ideal to 1e-3
  }
  CHECK(refusal([&] { with_water_column(profile, 5.6); }).find("fit below saturation") != std::string::npos);
  CHECK(refusal([&] { with_water_column(profile, 9); }).find("fit below saturation") != std::string::npos);
  CHECK(refusal([&] { with_water_column(profile, std::nan("")); }).find("0 to 20") != std::string::npos);
  CHECK(relative(saturation_pressure_hPa(293.15), 23.39) <= 4e-3);  // steam tables, 20 C; Alduchov & Eskridge: 0.4 %

  const AirProfile mountain = cut_at_ground(profile, 1.5);
  CHECK(mountain.ground_km() == 1.5);
  CHECK(mountain.at(1.5).pressure_hPa == profile.at(1.5).pressure_hPa);
  CHECK(relative(mountain.air_column_per_cm2(1.5, 40), profile.air_column_per_cm2(1.5, 40)) <= 1e-12);
  CHECK(refusal([&] { cut_at_ground(profile, 130); }).find("outside") != std::string::npos);

  const AirProfile low = with_ground_pressure(profile, 900);
  CHECK(relative(low.air_above_per_cm2(0) / profile.air_above_per_cm2(0), 900.0 / 1013) <= 1e-12);
  CHECK(relative(low.water_g_cm2(), profile.water_g_cm2()) <= 1e-12);
  CHECK(relative(low.ozone_atm_cm(), profile.ozone_atm_cm()) <= 1e-12);
  CHECK(relative(low.levels()[7].ppmv(Gas::ch4), profile.levels()[7].ppmv(Gas::ch4)) <= 1e-12);
  CHECK(refusal([&] { with_ground_pressure(profile, 101325); }).find("hPa") != std::string::npos);
}

TEST_CASE("S18 profiles: every fault of the levels is listed") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::string text = refusal([&] {
    AirProfile({level(0, 1000, 288, 2.5e19), level(0, 1001, 288, 2e19), level(5, nan, 20, -1)}, "bad");
  });
  for (const char* part :
       {"level 2", "ascend", "fall with height", "level 3", "0, up to 1200 hPa", "100 to 1000 K", "must be positive"})
    CHECK(text.find(part) != std::string::npos);
  CHECK(refusal([] { AirProfile({}, "empty"); }).find("at least 2") != std::string::npos);
  const AirProfile fine({level(0, 1000, 288, 2.5e19), level(5, 500, 260, 1.4e19)}, "fine");
  CHECK(refusal([&] { fine.at(6); }).find("outside") != std::string::npos);
  CHECK(refusal([&] { fine.at(nan); }).find("outside") != std::string::npos);
}
