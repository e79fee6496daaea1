// Profiles for LIDAR. Oracles: closed forms of molecular scattering, profiles and lidar ratios computed elsewhere
// (reference lidar/), columns of the same air by other code, Beer's law at a methane line.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "atmos_tables/aerosol/aerosol_column.h"
#include "atmos_tables/compiler/air_provenance.h"
#include "atmos_tables/compiler/air_stack.h"
#include "atmos_tables/compiler/lidar_profiles.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/lines/molecular_lines.h"
#include "atmos_tables/optics/rayleigh_air.h"
#include "atmos_tables/optics/standard_air.h"
#include "atmos_tables/rct_file.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"
#include "tests/support/anchor_rows.h"
#include "tests/support/hitran_record.h"
#include "tests/support/refusal.h"
#include "tests/support/relative.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::test::relative;
using raycube::testing::anchor_rows;

namespace {

scene::AtmosphereSpec rural(const std::string& aerosol = "rural") {
  scene::AtmosphereSpec spec;
  spec.ground_height_m = 0;
  spec.layered.emplace();
  spec.layered->profile = "midlatitude_summer";
  spec.layered->aerosol = aerosol;
  spec.layered->visibility_km = 23;
  spec.layered->humidity_percent = 70;
  return spec;
}

double at(const RenderTable& table, const char* row, std::size_t wavelength, std::size_t height) {
  return table.rows.at(row).values[wavelength * table.axis("range_height").nodes.size() + height];
}

std::string message(const scene::AtmosphereSpec& spec, const std::vector<double>& um, const std::vector<double>& m,
                    const LidarOptions& o = {}) {
  return testing::refusal([&] { build_lidar(spec, um, m, o); });
}

}  // namespace

TEST_CASE("AIR 9 LIDAR: midlatitude summer, rural, 23 km at five wavelengths against the profile computed elsewhere") {
  const auto rows = anchor_rows("lidar/lidar_profile_mls_rural23.csv", "LIDAR profiles are not compared");
  if (rows.empty()) return;
  const std::vector<std::pair<double, std::string>> waves = {
      {0.532, "0.532"}, {1.064, "1.064"}, {1.55, "1.55"}, {1.645, "1.645"}, {3.3, "3.3"}};
  std::vector<double> um, heights;
  for (const auto& [value, name] : waves) um.push_back(value);
  for (const auto& row : rows) heights.push_back(1000 * row.at("z_km"));
  // That profile takes optics linear between LOWTRAN7's wavelengths.
  scene::AtmosphereSpec lowtran = rural();
  lowtran.layered->gas_bands = "lowtran";
  const RenderTable table = build_lidar(lowtran, um, heights), power = build_lidar(rural(), um, heights);
  double molecular = 0, extinction = 0, back = 0, back_high = 0, by_power = 0;
  for (std::size_t i = 0; i < um.size(); ++i)
    for (std::size_t h = 0; h < heights.size(); ++h) {
      const auto truth = [&](const char* what) { return 1e-3 * rows[h].at(std::string(what) + "_" + waves[i].second); };
      molecular = std::max({molecular, relative(at(table, "lidar_extinction_molecular", i, h), truth("alpha_mol")),
                            relative(at(table, "lidar_backscatter_molecular", i, h), truth("beta_mol"))});
      const double e = relative(at(table, "lidar_extinction_aerosol", i, h), truth("alpha_aer"));
      const double b = relative(at(table, "lidar_backscatter_aerosol", i, h), truth("beta_aer"));
      extinction = std::max(extinction, e);
      (heights[h] <= 10000 ? back : back_high) = std::max(heights[h] <= 10000 ? back : back_high, b);
      by_power = std::max(by_power, relative(at(power, "lidar_extinction_aerosol", i, h), truth("alpha_aer")));
    }
  MESSAGE("worst: molecules " << molecular << ", aerosol extinction " << extinction << ", backscatter " << back
                              << ", above 10 km " << back_high << "; extinction by the default rule " << by_power);
  // Printed digits and 360 instead of 330 ppmv of CO2.
  CHECK(molecular <= 1e-4);
  CHECK(extinction <= 1e-4);
  // Between tabulated wavelengths Mie functions are mixed here, the logarithm of P(180) is linear there: the
  // stratosphere's differ by a factor of 1.8 from 0.355 to 0.532 um.
  CHECK(back <= 0.012);
  CHECK(back_high <= 0.03);
  // Extinction as a power law of wavelength instead of linear, 12 % in the hollow between 2.5 and 3.39 um.
  CHECK(by_power <= 0.12);
}

TEST_CASE("AIR 9 LIDAR: molecular backscatter, lidar ratio and depolarisation") {
  // 532 nm, 1013.25 hPa, 288.15 K.
  const double air_per_cm3 = 101325 / (kBoltzmann_J_per_K * 288.15) * 1e-6;
  const RenderTable table = build_lidar(rural("none"), {0.532}, {0, 1000});
  const double ratio = at(table, "lidar_extinction_molecular", 0, 0) / at(table, "lidar_backscatter_molecular", 0, 0);
  CHECK(std::abs(ratio - 8.4966) <= 0.001);
  const double per_molecule = 1e3 * at(table, "lidar_extinction_molecular", 0, 0) /
                              afgl_profile(AfglModel::midlatitude_summer).levels()[0].air_per_cm3;
  CHECK(relative(per_molecule * air_per_cm3, 0.01316) <= 1e-3);
  CHECK(relative(per_molecule * air_per_cm3 / ratio, 1.549e-3) <= 1e-3);
  // (45 + 4 x) and 3 x with x = 4.5 (F - 1), F = 1.04899: 0.01444; the Cabannes line with x / 4: 0.00365.
  CHECK(std::abs(at(table, "lidar_depolarization", 0, 0) - 0.01441) <= 1e-4);
  LidarOptions cabannes;
  cabannes.cabannes_only = true;
  const RenderTable line = build_lidar(rural("none"), {0.532}, {0, 1000}, cabannes);
  CHECK(std::abs(at(line, "lidar_backscatter_molecular", 0, 0) / at(table, "lidar_backscatter_molecular", 0, 0) -
                 0.975) <= 0.001);
  CHECK(at(line, "lidar_extinction_molecular", 0, 0) == at(table, "lidar_extinction_molecular", 0, 0));
  CHECK(std::abs(at(line, "lidar_depolarization", 0, 0) - 0.00365) <= 5e-5);

  const auto rows = anchor_rows("lidar/rayleigh_cross_section.csv", "molecular lidar ratios are not compared");
  std::vector<double> um;
  for (const auto& row : rows) um.push_back(row.at("wavelength_um"));
  if (rows.empty()) return;
  const RenderTable many = build_lidar(rural("none"), um, {0, 1000});
  double worst = 0;
  for (std::size_t i = 0; i < um.size(); ++i)
    worst = std::max(
        worst, relative(at(many, "lidar_extinction_molecular", i, 0) / at(many, "lidar_backscatter_molecular", i, 0),
                        rows[i].at("lidar_ratio_sr")));
  MESSAGE("molecular lidar ratio, worst of " << um.size() << " wavelengths: " << worst);
  CHECK(worst <= 2e-5);
}

TEST_CASE("AIR 9 LIDAR: stated lidar ratios and depolarisation of components") {
  LidarOptions own;
  own.particles = {{"rural", 55, 0.3}};
  const RenderTable plain = build_lidar(rural(), {0.532}, {0, 5000}),
                    stated = build_lidar(rural(), {0.532}, {0, 5000}, own);
  CHECK(relative(at(stated, "lidar_extinction_aerosol", 0, 0) / at(stated, "lidar_backscatter_aerosol", 0, 0), 55) <=
        1e-6);
  CHECK(at(stated, "lidar_backscatter_aerosol", 0, 1) == at(plain, "lidar_backscatter_aerosol", 0, 1));  // troposphere
  // Mixed: beta_perp = sum beta d / (1 + d).
  const double aerosol = at(stated, "lidar_backscatter_aerosol", 0, 0),
               molecules = at(stated, "lidar_backscatter_molecular", 0, 0);
  const double crossed = aerosol * 0.3 / 1.3 + molecules * 0.01441 / 1.01441;
  CHECK(relative(at(stated, "lidar_depolarization", 0, 0), crossed / (aerosol + molecules - crossed)) <= 1e-3);
  CHECK(at(plain, "lidar_depolarization", 0, 0) < at(stated, "lidar_depolarization", 0, 0));
}

TEST_CASE("AIR 9 LIDAR: default heights hold the columns; reading is exponential in height and its integral exact") {
  for (double ground_m : {0.0, 350.0}) {
    scene::AtmosphereSpec spec = rural();
    spec.ground_height_m = ground_m;
    spec.layered->clouds = {{"cumulus", 1.23, 1.57, 2.0}};
    const std::vector<double> heights = lidar_heights(spec), um = {0.355, 0.532, 1.064};
    CHECK(heights.size() >= 33);
    CHECK(heights.size() <= 100);
    CHECK(heights.front() == 0);
    const RenderTable table = build_lidar(spec, um, heights);
    std::vector<std::string> notices;
    const AirProfile profile = make_profile(*spec.layered, ground_m / 1000, notices);
    const AerosolColumn aerosols(make_aerosols(*spec.layered), profile);
    // A base of exponential pieces between AFGL levels (5e-5), and cloud edges 0.5 m wide (1e-3 of the cloud).
    const std::pair<double, double> paths[] = {
        {0.0, 610.0}, {0.0, 1400.0 - ground_m}, {130.0, 2900.0}, {2000.0, 20000.0}, {0.0, 60000.0}};
    for (const auto& [low, high] : paths) {
      const std::vector<double> depth = lidar_optical_depth(table, low, high);
      const double a = (ground_m + low) / 1000, b = (ground_m + high) / 1000;
      for (std::size_t i = 0; i < um.size(); ++i) {
        double truth =
            rayleigh_cross_section_cm2(um[i], profile.levels()[0].ppmv(Gas::co2)) * profile.air_column_per_cm2(a, b);
        for (std::size_t c = 0; c < aerosols.components(); ++c)
          truth += aerosols.optics(c, um[i]).extinction_ratio * aerosols.depth_550(c, a, b);
        CHECK(relative(depth[i], truth) <= 2e-3);
      }
    }
    const LidarAir low = lidar_air(table, 100), mid = lidar_air(table, 150), high = lidar_air(table, 200);
    for (std::size_t i = 0; i < um.size(); ++i) {
      CHECK(relative(mid.extinction_molecular_per_m[i],
                     std::sqrt(low.extinction_molecular_per_m[i] * high.extinction_molecular_per_m[i])) <= 1e-6);
      CHECK(relative(mid.backscatter_aerosol_per_m_sr[i],
                     std::sqrt(low.backscatter_aerosol_per_m_sr[i] * high.backscatter_aerosol_per_m_sr[i])) <= 1e-6);
    }
    CHECK_THROWS_AS(lidar_air(table, -1), base::Error);
    CHECK_THROWS_AS(lidar_optical_depth(table, 200, 100), base::Error);
    CHECK_THROWS_AS(lidar_optical_depth(table, 0, 2e5), base::Error);
  }
}

TEST_CASE(
    "AIR 9 LIDAR: gas at a methane line by Beer's law; absent with a word where no lines are given; a file keeps it "
    "all") {
  const testing::TestFolder folder;
  const SpectralLine line{6, 1, 3057.687, 2.1e-19, 0.058, 0.078, 104.77, 0.75, -0.006};
  folder.write("one.par", testing::hitran_record(line));
  scene::AtmosphereSpec spec = rural("none");
  spec.layered->lines = folder / "one.par";
  spec.layered->ch4_ppmv = 2;
  const std::vector<double> um = {1e4 / 3058.4, 1e4 / 3057.687};
  const RenderTable table = build_lidar(spec, um, {0, 3000});
  std::vector<std::string> notices;
  const AirLevel ground = make_profile(*spec.layered, 0, notices).levels()[0];
  const MolecularLines lines({line}, {}, std::make_shared<PartitionSums>());
  const double own = ground.pressure_hPa * ground.gas(Gas::ch4) / ground.air_per_cm3;
  const auto sigma = lines.cross_section_cm2({3057.687, 3058.4}, {ground.pressure_hPa, ground.temperature_K, own});
  // The difference of both wavelengths leaves the water continuum out, 0.25 km-1 after LOWTRAN7, but for its slope.
  const double on = at(table, "lidar_extinction_gas", 1, 0), off = at(table, "lidar_extinction_gas", 0, 0);
  CHECK(relative(on - off, 100 * ground.gas(Gas::ch4) * (sigma[0] - sigma[1])) <= 2e-3);
  CHECK(on > 10 * off);
  CHECK(table.provenance_json.find("holds no lines of h2o, co2, o3, n2o, co, o2") != std::string::npos);
  // Wavelengths far apart are read by themselves and change nothing.
  const RenderTable apart = build_lidar(spec, {0.532, um[0], um[1]}, {0, 3000});
  CHECK(at(apart, "lidar_extinction_gas", 2, 0) == at(table, "lidar_extinction_gas", 1, 0));
  CHECK(at(apart, "lidar_extinction_gas", 1, 1) == at(table, "lidar_extinction_gas", 0, 1));
  spec.layered->lines.clear();
  const RenderTable without = build_lidar(spec, um, {0, 3000});
  CHECK(!without.has("lidar_extinction_gas"));
  CHECK(without.provenance_json.find("absorption by gases is absent") != std::string::npos);
  CHECK(lidar_air(without, 100).extinction_gas_per_m == std::vector<double>{0, 0});

  write_rct(table, folder / "lidar.rct", base::IfExists::refuse);
  const RenderTable back = read_rct(folder / "lidar.rct");
  CHECK(wavelengths(back) == um);
  CHECK(back.rows.at("lidar_extinction_gas").values == table.rows.at("lidar_extinction_gas").values);
}

TEST_CASE("LIDAR: what gases would take without a line list, and from where on it is a notice") {
  // At the peak of Chappuis' band, 5.1e-21 cm2 at 0.602 um, two columns of ozone differ by Beer's law.
  // LOWTRAN7's figures are older means over 200 cm-1 and measured 7 % off; the share is told to two digits.
  const auto depth = [](double ozone_atm_cm) {
    scene::AtmosphereSpec spec = rural("none");
    spec.layered->ozone_atm_cm = ozone_atm_cm;
    return -std::log1p(-gases_left_out(*spec.layered, 0, {0.602}).share);
  };
  CHECK(relative(depth(0.5) - depth(0.1), 0.4 * 2.6868e19 * 5.1e-21) <= 0.1);
  // The wavelength that loses most speaks for all; from kTellsGases on it is a notice, below it a limit.
  const auto said = [](const std::vector<double>& um, const char* list) {
    const auto told = nlohmann::json::parse(build_lidar(rural(), um, {0, 1000}).provenance_json)[list];
    return told.empty() ? std::string() : told[0].get<std::string>();
  };
  CHECK(said({0.532, 0.76, 1.064}, "notices").find("near 760 nm they have 5") != std::string::npos);
  CHECK(said({0.532, 0.76, 1.064}, "limits").empty());
  CHECK(said({0.532, 1.064}, "limits").find("near 532 nm they have 2.") != std::string::npos);
  CHECK(said({0.532, 1.064}, "notices").empty());
  // Drier air takes less of 940 nm.
  scene::AtmosphereSpec dry = rural();
  dry.layered->water_g_cm2 = 0.1;
  const double moist = gases_left_out(*rural().layered, 0, {0.94}).share;
  CHECK(gases_left_out(*dry.layered, 0, {0.94}).share < 0.3 * moist);
}

TEST_CASE("AIR 9 LIDAR: no aerosol has no visibility") {
  const auto parameters = [](const std::string& aerosol) {
    return nlohmann::json::parse(build_lidar(rural(aerosol), {0.532}, {0}).provenance_json)["parameters"];
  };
  CHECK(parameters("none")["visibility_km"].is_null());
  CHECK(parameters("none")["aod_550_from"] == "no aerosol");
  CHECK(parameters("rural")["visibility_km"] == 23);
  CHECK(parameters("rural")["aod_550_from"] == "visibility");
}

TEST_CASE("AIR 9 LIDAR: bad input is told, all at once") {
  CHECK(message(rural(), {}, {0}).find("LIDAR wavelengths") != std::string::npos);
  const std::string all = message(rural(), {0.1, 0.1}, {5000, 2e5});
  for (const char* part : {"must lie in 0.25", "must ascend strictly", "must lie in -1000"})
    CHECK(all.find(part) != std::string::npos);
  LidarOptions own;
  own.particles = {{"dust", 50, 0}, {"rural", 0.2, 2}};
  const std::string parts = message(rural(), {0.532}, {0}, own);
  CHECK(parts.find("it has rural, troposphere, stratosphere, upper air") != std::string::npos);
  CHECK(parts.find("must lie in 1 to 1000 sr") != std::string::npos);
  CHECK(parts.find("depolarisation must lie in 0 to 1") != std::string::npos);
}
