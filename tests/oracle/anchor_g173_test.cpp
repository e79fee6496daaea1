// ASTM G173-03 (solar/astm_g173_03.csv): its integrals, and its direct normal spectrum from the inputs it states
// and its own extraterrestrial column. Inputs: US standard air of 1976, sun at airmass 1.5, water 1.42 cm, ozone 0.344
// atm-cm, CO2 370 ppmv, rural aerosol (Shettle & Fenn) of depth 0.084 at 0.5 um; the direct column holds the sky within
// 2.9 degrees of the sun.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "atmos_tables/aerosol/aerosol_column.h"
#include "atmos_tables/compiler/air_stack.h"
#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/interpolate.h"
#include "tests/support/layered_anchor.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

constexpr double kPi = 3.14159265358979, kSun_deg = 48.19;
const char* const kFile = "solar/astm_g173_03.csv";

/// Trapezoidal integral of a column from one wavelength (nm) to another, nodes as they stand.
double integral(const std::vector<testing::AnchorRow>& rows, const std::string& column, double from_nm, double to_nm) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < rows.size(); ++i) {
    const double a = rows[i].at("wavelength_nm"), b = rows[i + 1].at("wavelength_nm");
    if (a < from_nm - 1e-6 || b > to_nm + 1e-6) continue;
    sum += 0.5 * (rows[i].at(column) + rows[i + 1].at(column)) * (b - a);
  }
  return sum;
}

scene::AtmosphereSpec stated_air() {
  scene::AtmosphereSpec spec;
  spec.layered.emplace();
  scene::AirSpec& air = *spec.layered;
  air.profile = "us_standard", air.pressure_hPa = 1013.25;
  air.water_g_cm2 = 1.42, air.ozone_atm_cm = 0.344, air.co2_ppmv = 370;
  air.aod_550 = 0.075;
  return spec;
}

/// Vertical aerosol depth.
double aerosol_depth(const scene::AirSpec& air, double um) {
  std::vector<std::string> notices;
  const AirProfile profile = make_profile(air, 0, notices);
  const AerosolColumn column(make_aerosols(air), profile);
  double depth = 0;
  for (std::size_t c = 0; c < column.components(); ++c)
    depth += column.depth_550(c, 0, 100) * column.optics(c, um).extinction_ratio;
  return depth;
}

/// Sky within 2.9 degrees of the sun over the direct light, its disc (0.27 degrees) not in it.
double circumsolar_share(const RenderTable& table) {
  double sum = 0;
  constexpr int rings = 12, turns = 24;
  const double sun = kSun_deg * kPi / 180, first = 0.27, step = (2.9 - first) / rings;
  for (int r = 0; r < rings; ++r)
    for (int k = 0; k < turns; ++k) {
      const double away = (first + (r + 0.5) * step) * kPi / 180, turn = 2 * kPi * (k + 0.5) / turns;
      const double cosine = std::cos(sun) * std::cos(away) + std::sin(sun) * std::sin(away) * std::cos(turn),
                   zenith = std::acos(cosine);
      const double azimuth = std::asin(std::clamp(std::sin(away) * std::sin(turn) / std::sin(zenith), -1.0, 1.0));
      sum += sky_radiance(table, 0, zenith * 180 / kPi, azimuth * 180 / kPi)[0] * std::sin(away) * step * kPi / 180 *
             2 * kPi / turns;
    }
  return sum / (solar_irradiance(table)[0] * sun_transmission(table, 0)[0]);
}

}  // namespace

TEST_CASE("A-20 ASTM G173: integrals of its columns") {
  const auto rows = testing::anchor_rows(kFile, "ASTM G173 was not integrated");
  if (rows.empty()) return;
  CHECK(integral(rows, "extraterrestrial_W_m2_nm", 280, 4000) == doctest::Approx(1347.93).epsilon(1e-4));
  CHECK(integral(rows, "direct_circumsolar_W_m2_nm", 280, 4000) == doctest::Approx(900.14).epsilon(1e-4));
  CHECK(integral(rows, "global_tilt_W_m2_nm", 280, 4000) == doctest::Approx(1000.37).epsilon(1e-4));
}

TEST_CASE("A-20 ASTM G173: direct normal from its stated inputs and its own sun") {
  const auto rows = testing::anchor_rows(kFile, "the direct light of ASTM G173 was not compared");
  if (rows.empty()) return;
  auto spec = stated_air();
  for (int i = 0; i < 3; ++i) spec.layered->aod_550 *= 0.084 / aerosol_depth(*spec.layered, 0.5);
  CHECK(aerosol_depth(*spec.layered, 0.5) == doctest::Approx(0.084).epsilon(1e-6));

  // The circumsolar part, 0.4 % at 0.4 um and less beyond, is smooth: eight wavelengths, linear in ln wavelength
  // between.
  const double nodes[] = {0.40, 0.47, 0.55, 0.67, 0.87, 1.24, 1.65, 2.40};
  std::vector<double> share;
  for (double um : nodes)
    share.push_back(circumsolar_share(build_layered(spec, testing::sun_at(kSun_deg), 1000, {um}, {0})));
  const auto circumsolar = [&](double um) {
    std::size_t i = 1;
    while (i + 1 < std::size(nodes) && nodes[i] < um) ++i;
    const double w = std::log(um / nodes[i - 1]) / std::log(nodes[i] / nodes[i - 1]);
    return share[i - 1] + w * (share[i] - share[i - 1]);
  };

  std::vector<double> um;
  for (int i = 0; i <= 201; ++i) um.push_back(0.395 + 0.01 * i);
  spec.layered->k_terms = 1, spec.layered->streams = 4;  // the beam is the band model's
  const RenderTable table = build_layered(spec, testing::sun_at(kSun_deg), 1000, um, {0});
  const auto t = sun_transmission(table, 0);
  testing::ChartRows chart("g173", "um,found,reference,extraterrestrial");
  testing::Errors outside, inside, direct_only;
  double all_found = 0, all_reference = 0;
  for (std::size_t k = 1; k + 1 < um.size(); ++k) {
    const double from = 1000 * um[k] - 5, to = from + 10;
    const double sun = integral(rows, "extraterrestrial_W_m2_nm", from, to) / 10;
    const double reference = integral(rows, "direct_circumsolar_W_m2_nm", from, to) / 10;
    const double found = sun * t[k] * (1 + circumsolar(um[k]));
    // Band cores: where less than 0.3 of the light comes through.
    const double error = found / reference - 1;
    if (reference / sun > 0.3)
      outside.add(std::abs(error)), direct_only.add(std::abs(sun * t[k] / reference - 1));
    else
      inside.add((found - reference) / sun);
    all_found += 10 * found, all_reference += 10 * reference;
    chart.add({um[k], found, reference, sun});
  }
  outside.close(), inside.close(), direct_only.close();
  std::printf("circumsolar share %.4f (0.4 um) to %.4f (2.4 um)\n", share.front(), share.back());
  std::printf(
      "mean absolute deviation %.4f of %d bins (without circumsolar %.4f), worst %.3f; in band cores %+.4f of the sun; "
      "total %.2f / %.2f W m-2\n",
      outside.mean, outside.count, direct_only.mean, outside.worst, inside.mean, all_found, all_reference);
  CHECK(outside.count > 140);
  CHECK(outside.mean < 0.03);
  // Found: +0.96 %. The model has no NO2 and none of oxygen's collision bands (1.06, 1.27 um: +10 % in a bin).
  CHECK(all_found == doctest::Approx(all_reference).epsilon(0.012));
}
