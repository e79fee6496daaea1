// A radiosonde's profile completed from a model atmosphere. Oracle: the model itself, where the sonde is made
// of it; hydrostatics and the gas law where it is not.
#include <doctest/doctest.h>

#include <cmath>
#include <cstdio>
#include <sstream>

#include "atmos_tables/compiler/air_stack.h"
#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/optics/profile_fill.h"
#include "atmos_tables/optics/profile_scaling.h"
#include "host/base/error.h"
#include "tests/unit/import_kit.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::testing::holds;
using raycube::testing::refusal;
using raycube::testing::TestFolder;

namespace {

/// The model's levels from low to high km as a sonde has them: pressure times a factor, temperature, water.
std::string sonde(AfglModel model, double low_km, double high_km, double pressure_factor = 1, bool water = true) {
  std::string out = std::string("height_m,pressure_hPa,temperature_K") + (water ? ",h2o_ppmv" : "") + "\n";
  const AirProfile whole = afgl_profile(model);
  for (const AirLevel& level : whole.levels()) {
    if (level.height_km < low_km || level.height_km > high_km) continue;
    char line[200];
    std::snprintf(line, sizeof line, "%.17g,%.17g,%.17g", 1000 * level.height_km, pressure_factor * level.pressure_hPa,
                  level.temperature_K);
    out += line;
    std::snprintf(line, sizeof line, ",%.17g", level.ppmv(Gas::h2o));
    out += (water ? line : "") + std::string("\n");
  }
  return out;
}

ProfileFile read(const std::string& text) {
  std::istringstream in(text);
  return read_profile_csv(in, "sonde.csv");
}

/// Largest relative difference of columns over layers of 1 km between two profiles, air and all gases, to 80
/// km.
double worst_column(const AirProfile& a, const AirProfile& b) {
  double worst = 0;
  const auto differ = [&](double x, double y) { worst = std::max(worst, std::abs(x - y) / std::max(y, 1e-3)); };
  for (double low = 0; low < 80; ++low) {
    differ(a.air_column_per_cm2(low, low + 1), b.air_column_per_cm2(low, low + 1));
    for (std::size_t g = 0; g < kGases; ++g)
      differ(a.gas_column_per_cm2(Gas(g), low, low + 1), b.gas_column_per_cm2(Gas(g), low, low + 1));
  }
  return worst;
}

}  // namespace

TEST_CASE("S18 a sonde made of a model's own lowest 14 km becomes that model again") {
  for (const AfglModel model : {AfglModel::midlatitude_summer, AfglModel::subarctic_winter}) {
    const auto whole = completed(read(sonde(model, 0, 14)), model, kTopOfStack_km);
    const double worst = worst_column(whole.air, afgl_profile(model));
    MESSAGE(kAfglNames[static_cast<std::size_t>(model)] << ": columns of 1 km within " << worst);
    CHECK(worst < 5e-3);  // the model's densities are printed to three digits, a sonde's follow from the gas law
    CHECK(whole.air.top_km() == 120);
    REQUIRE(whole.notices.size() == 1);
    CHECK(holds(whole.notices[0], "sonde.csv: co2, o3, n2o, co, ch4, o2 and everything above 14 km as in"));
  }
  // Between levels far apart the model's structure is kept: the ozone layer of a profile with levels at 0, 10
  // and 40 km.
  const AirProfile model = afgl_profile(AfglModel::us_standard);
  std::string coarse = "height_km,pressure_hPa,temperature_K,h2o_ppmv\n";
  for (const double z : {0.0, 10.0, 40.0}) {
    const AirLevel level = model.at(z);
    coarse += std::to_string(z) + "," + std::to_string(level.pressure_hPa) + "," + std::to_string(level.temperature_K) +
              "," + std::to_string(level.ppmv(Gas::h2o)) + "\n";
  }
  const double ozone = completed(read(coarse), AfglModel::us_standard, kTopOfStack_km).air.ozone_atm_cm();
  MESSAGE("ozone of three levels: " << ozone << " atm-cm for " << model.ozone_atm_cm());
  CHECK(ozone == doctest::Approx(model.ozone_atm_cm()).epsilon(0.1));
}

TEST_CASE(
    "S18 above the sonde pressures meet its own by one factor; gas law and mixing ratios hold; columns of "
    "zeros stay zeros") {
  const auto model = afgl_profile(AfglModel::us_standard);
  const auto whole =
      completed(read(sonde(AfglModel::us_standard, 0, 20, 1.03)), AfglModel::us_standard, kTopOfStack_km);
  for (const double z : {25.0, 40.0, 70.0, 99.0}) {
    const AirLevel here = whole.air.at(z), there = model.at(z);
    CHECK(here.pressure_hPa == doctest::Approx(1.03 * there.pressure_hPa).epsilon(1e-9));
    CHECK(here.temperature_K == doctest::Approx(there.temperature_K).epsilon(1e-9));
    CHECK(here.air_per_cm3 == doctest::Approx(1.03 * there.air_per_cm3).epsilon(1e-9));
    for (std::size_t g = 0; g < kGases; ++g)
      CHECK(here.ppmv(Gas(g)) == doctest::Approx(there.ppmv(Gas(g))).epsilon(1e-9));
  }
  CHECK(whole.air.at(10).ppmv(Gas::o2) == doctest::Approx(model.at(10).ppmv(Gas::o2)).epsilon(1e-9));
  const auto none =
      completed(read("height_km,pressure_hPa,temperature_K,h2o_ppmv,o3_ppmv\n0,1000,290,9000,0\n5,540,258,900,0\n"),
                AfglModel::tropical, kTopOfStack_km);
  CHECK(none.air.ozone_atm_cm() == 0);
  CHECK(none.air.gas_column_per_cm2(Gas::o2, 0, 80) > 0);
  // Water that a sonde of cold air has no column for: the model's, at most saturation.
  const auto cold = completed(read("height_km,pressure_hPa,temperature_K\n0,1000,250\n5,500,220\n"),
                              AfglModel::tropical, kTopOfStack_km);
  CHECK(cold.air.at(0).gas(Gas::h2o) == doctest::Approx(saturation_per_cm3(250)));
  // A file with everything to 100 km comes back as it is.
  std::string all =
      "height_km,pressure_hPa,temperature_K,h2o_ppmv,co2_ppmv,o3_ppmv,n2o_ppmv,co_ppmv,ch4_ppmv,o2_ppmv\n";
  for (const char* level : {"0,1000,290", "50,0.8,270", "100,0.0003,195"})
    all += std::string(level) + ",1,1,1,1,1,1,1\n";
  const auto same = completed(read(all), AfglModel::tropical, kTopOfStack_km);
  CHECK(same.notices.empty());
  CHECK(same.air.levels().size() == 3);
}

TEST_CASE("S18 oxygen's A band through a sonde: that of the model it was made of") {
  const TestFolder folder;
  folder.write("sonde.csv", sonde(AfglModel::midlatitude_summer, 0, 14));
  scene::AtmosphereSpec model, own;
  for (auto* spec : {&model, &own})
    spec->layered.emplace(), spec->layered->profile = "midlatitude_summer", spec->layered->streams = 4;
  own.layered->profile_file = folder / "sonde.csv";
  scene::Sun sun;
  sun.zenith_deg = 40;
  const std::vector<double> um = {0.7600, 0.7605, 0.7610, 0.7615, 2.05};
  const auto want = build_layered(model, sun, 3000, um, {0}), found = build_layered(own, sun, 3000, um, {0});
  const auto t_want = sun_transmission(want, 0), t_found = sun_transmission(found, 0);
  for (std::size_t i = 0; i < um.size(); ++i) {
    MESSAGE(um[i] << " um: sun to ground " << t_found[i] << ", the model " << t_want[i]);
    CHECK(std::abs(t_found[i] - t_want[i]) < 2e-3);
  }
  CHECK(t_want[1] < 0.5);
  CHECK(found.provenance_json.find("as in midlatitude_summer") != std::string::npos);
}

TEST_CASE("S18 the ground at the height of the sonde's first level, whichever way its height is rounded") {
  const TestFolder folder;
  for (const char* head :
       {"height_m,pressure_hPa,temperature_K\n350,970,288\n", "height_km,pressure_hPa,temperature_K\n0.35,970,288\n",
        "height_m,pressure_hPa,temperature_K\n350.2,970,288\n",
        "height_m,pressure_hPa,temperature_K\n349.8,970,288\n"}) {
    folder.write("sonde.csv", std::string(head) + (std::string(head).find("_km") != std::string::npos
                                                       ? "3,705,272\n12,200,220\n"
                                                       : "3000,705,272\n12000,200,220\n"));
    scene::AirSpec spec;
    spec.profile_file = folder / "sonde.csv";
    for (const double ground_km : {0.35, 350 * 1e-3, 350.0 / 1000}) {
      std::vector<std::string> notices;
      const AirProfile air = make_profile(spec, ground_km, notices);
      CHECK(air.ground_km() == ground_km);
      CHECK(air.levels().front().pressure_hPa == doctest::Approx(970).epsilon(1e-4));  // half a metre is 6e-5 of it
      CHECK(air.levels()[1].height_km - ground_km > kSameHeight_km);
    }
  }
}

TEST_CASE(
    "bad input: 140 % of relative humidity is refused with its line, as are ppmv that amount to it; 103 % is "
    "held at 100 % and said") {
  const auto humid = [](const char* percent) {
    return std::string(
               "height_km,pressure_hPa,temperature_C,h2o_relative_humidity_percent\n0,1000,20,80\n1,900,"
               "14,") +
           percent + "\n2,800,8,70\n";
  };
  const std::string said = refusal([&] { read(humid("140")); });
  CHECK(holds(said, "sonde.csv:3"));
  CHECK(holds(said, "140 % at 287.15 K"));
  CHECK(holds(said, "held at 100 %"));
  CHECK(holds(refusal([&] { read(humid("105.1")); }), "105.1 %"));
  const ProfileFile held = read(humid("103"));
  CHECK(held.air.levels()[1].gas(Gas::h2o) == doctest::Approx(saturation_per_cm3(287.15)).epsilon(1e-12));
  REQUIRE(held.notices.size() == 1);
  CHECK(holds(held.notices[0], "held at 100 % relative humidity at 1 level"));
  CHECK(read(humid("100")).notices.empty());
  // 40 000 ppmv of 900 hPa are 36 hPa of vapour; saturation at 14 C is 16.
  CHECK(
      holds(refusal([&] { read("height_km,pressure_hPa,temperature_C,h2o_ppmv\n0,1000,20,10000\n1,900,14,40000\n"); }),
            "sonde.csv:3"));
}
