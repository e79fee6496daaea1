// The layered table with gases resolved to lines. Scene: midlatitude summer without aerosol, sun at 40 degrees, sensor
// at 3 km looking down, one line of methane near 1.6537 um. Oracle: density times Voigt profile, integrated over height
// by the test's own rule.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/compiler/line_air.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/lines/molecular_lines.h"
#include "atmos_tables/lines/voigt.h"
#include "atmos_tables/optics/standard_air.h"
#include "host/base/error.h"
#include "tests/support/hitran_record.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

const SpectralLine kLine{6, 1, 6046.9636, 1.4e-21, 0.06, 0.08, 62.88, 0.75, -0.008};

scene::AtmosphereSpec air() {
  scene::AtmosphereSpec spec;
  spec.layered.emplace();
  spec.layered->profile = "midlatitude_summer";
  spec.layered->aerosol = "none";
  spec.layered->streams = 4;
  return spec;
}

/// Vertical depth of the line from the ground to a height, midpoint rule over 20 m.
double column_depth(const AirProfile& profile, double wavenumber, double top_km) {
  const PartitionSums sums;
  double depth = 0;
  const double step = 0.02;
  for (double z = 0.5 * step; z < top_km; z += step) {
    const AirLevel level = profile.at(z);
    const double t = level.temperature_K, atm = level.pressure_hPa / 1013.25,
                 share = level.gas(Gas::ch4) / level.air_per_cm3;
    const double gamma =
        std::pow(296 / t, kLine.n_air) * atm * (kLine.gamma_air * (1 - share) + kLine.gamma_self * share);
    const VoigtProfile voigt(kLine.wavenumber_per_cm * 3.581163e-7 * std::sqrt(t / 16.0313), gamma);
    depth += 1e5 * step * level.gas(Gas::ch4) * line_intensity(kLine, t, sums) *
             voigt(wavenumber - kLine.wavenumber_per_cm - kLine.delta_air * atm);
  }
  return depth;
}

}  // namespace

TEST_CASE(
    "AIR 9 layered table: a methane line on the table's own wavelengths, down from 3 km and from the top of the air") {
  const testing::TestFolder folder;
  folder.write("ch4.par", testing::hitran_record(kLine));
  scene::AtmosphereSpec with = air();
  with.layered->lines = folder / "ch4.par";
  scene::AtmosphereSpec without = air();
  without.layered->ch4_ppmv = 0;
  scene::Sun sun;
  sun.zenith_deg = 40;
  std::vector<double> um;
  for (double offset : {0.5, 0.1, 0.03, 0.0, -0.05}) um.push_back(1e4 / (kLine.wavenumber_per_cm + offset));
  const RenderTable lines = build_layered(with, sun, 3000, um, {0}), none = build_layered(without, sun, 3000, um, {0});
  const AirProfile profile = afgl_profile(AfglModel::midlatitude_summer);
  const auto& down = lines.rows.at("sun_optical_depth").values;
  const auto &up = lines.rows.at("view_optical_depth").values, &up_none = none.rows.at("view_optical_depth").values;
  const std::size_t views = lines.axis("view_zenith").nodes.size();
  double worst = 0, worst_sun = 0;
  for (std::size_t i = 0; i < um.size(); ++i) {
    const double truth = column_depth(profile, 1e4 / um[i], 3);
    worst = std::max(worst, std::abs(up[i * views] - up_none[i * views] - truth) / truth);
    const double slant = column_depth(profile, 1e4 / um[i], 100) / std::cos(40 * 3.14159265358979 / 180);
    worst_sun = std::max(worst_sun, std::abs(down[i] - none.rows.at("sun_optical_depth").values[i] - slant) / slant);
  }
  MESSAGE("line's depth from 3 km " << worst << ", along the sun " << worst_sun << "; on line "
                                    << up[3 * views] - up_none[3 * views]);
  CHECK(worst <= 2e-4);
  // Spherical refracting shells against sec(40 deg): methane's airmass is 1.3e-3 lower.
  CHECK(worst_sun <= 3e-3);
  // Where nothing but lines absorbs, paths multiply.
  CHECK(lines.rows.at("two_way_factor").values[3 * views] ==
        doctest::Approx(none.rows.at("two_way_factor").values[3 * views]).epsilon(1e-5));
  // Light scattered in the line's core is absorbed on its way.
  CHECK(path_radiance(lines, 0, 0, 0)[3] < 0.9 * path_radiance(lines, 0, 0, 0)[0]);
  CHECK(lines.provenance_json.find(
            "holds no lines of h2o, co2, o3, n2o, co, o2; a table of sun and sky takes them from the band model") !=
        std::string::npos);
  CHECK(lines.provenance_json.find("choose a finer spectral step") != std::string::npos);
}

TEST_CASE(
    "AIR 9 layered table: cross-sections of a gas the profile lacks by its mixing ratio; unknown gases and too many "
    "wavelengths refused") {
  const testing::TestFolder folder;
  folder.write("ethane.csv",
               "wavenumber_per_cm,pressure_hPa,temperature_K,cross_section_cm2\n2980,1013.25,296,2e-19\n2990,1013.25,"
               "296,2e-19\n");
  scene::AtmosphereSpec with = air();
  with.layered->cross_sections = {{"ethane", folder / "ethane.csv", 0.002}};
  scene::Sun sun;
  sun.zenith_deg = 40;
  const std::vector<double> um = {1e4 / 2986, 1e4 / 2985};
  const RenderTable table = build_layered(with, sun, 3000, um, {0}), none = build_layered(air(), sun, 3000, um, {0});
  const std::size_t views = table.axis("view_zenith").nodes.size();
  const double column = 2e-9 * afgl_profile(AfglModel::midlatitude_summer).air_column_per_cm2(0, 3) * 2e-19;
  for (std::size_t i = 0; i < um.size(); ++i)
    CHECK(std::abs(table.rows.at("view_optical_depth").values[i * views] -
                   none.rows.at("view_optical_depth").values[i * views] - column) <= 1e-4 * column + 1e-6);
  with.layered->cross_sections[0].ppmv = -1;
  CHECK_THROWS_WITH_AS(build_layered(with, sun, 3000, um, {0}), doctest::Contains("the profile carries no 'ethane'"),
                       base::Error);
  with.layered->cross_sections[0].ppmv = 0.002;
  std::vector<double> many;
  for (std::size_t i = 0; i <= kMostResolvedNodes; ++i) many.push_back(3.3 + 1e-7 * static_cast<double>(i));
  CHECK_THROWS_WITH_AS(build_layered(with, sun, 3000, many, {0}), doctest::Contains("at most 20000 wavelengths"),
                       base::Error);
}

TEST_CASE("AIR 9 lines of the layered model: which gases are resolved, what is left out and said") {
  const testing::TestFolder folder;
  SpectralLine water = kLine, ammonia = kLine, far_ozone = kLine;
  water.molecule = 1, ammonia.molecule = 11;
  far_ozone.molecule = 3, far_ozone.wavenumber_per_cm = 1000;
  folder.write("some.par", testing::hitran_record(far_ozone) + testing::hitran_record(kLine) +
                               testing::hitran_record(water) + testing::hitran_record(ammonia));
  scene::AirSpec spec;
  spec.lines = folder / "some.par";
  const LineAir lines = read_line_air(spec, 6046, 6047);
  CHECK(lines.resolves(Gas::ch4));
  CHECK(lines.resolves(Gas::h2o));
  CHECK(lines.resolves(Gas::o3));  // the list has ozone, and says that there is none here
  CHECK(!lines.resolves(Gas::co2));
  std::string said;
  for (const auto& notice : lines.notices) said += notice + "\n";
  CHECK(said.find("carries no nh3; their lines are left out") != std::string::npos);
  CHECK(said.find("holds no lines of co2, n2o, co, o2;") != std::string::npos);
  // Water leaves its pedestal to the continuum.
  const GasState state{1013.25, 296, 0};
  for (const AbsorbingGas& gas : lines.gases) {
    const double edge = gas.absorber->cross_section_cm2({kLine.wavenumber_per_cm + 24.99}, state)[0];
    if (gas.name == "h2o") CHECK(edge < 1e-27);
    if (gas.name == "ch4") CHECK(edge > 1e-26);
  }
  const AirProfile profile = without_resolved(afgl_profile(AfglModel::us_standard), lines);
  CHECK(profile.levels()[0].gas(Gas::h2o) == 0);
  CHECK(profile.levels()[0].gas(Gas::co2) > 0);
}
