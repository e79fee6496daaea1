// The built-in clear sky against programs nobody here wrote: LOWTRAN7, libRadtran's DISORT, MODTRAN 6. The limits are
// the errors docs/table_format.md states for the model; they are its accuracy, not rounding.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <iostream>
#include <map>
#include <string>
#include <vector>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/interpolate.h"
#include "tests/support/anchor_rows.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

using Line = testing::AnchorRow;

/// Rows of an anchor file; empty, with a loud note, when the reference data are not there.
std::vector<Line> anchor(const std::string& name) {
  const auto rows = testing::anchor_rows("anchors/" + name, "the clear sky was not compared with " + name);
  REQUIRE((rows.empty() || rows.size() > 100));
  return rows;
}

scene::AtmosphereSpec midlatitude_summer_rural() {
  scene::AtmosphereSpec air;
  air.water_g_cm2 = 2.92;
  air.ozone_atm_cm = 0.332;
  air.aod_550 = 0.34;  // column of the 23 km rural aerosol, from LOWTRAN7's T sun-ground at 0.55 um
  air.angstrom = 1.2;
  return air;
}

scene::Sun sun_at(double zenith) {
  scene::Sun sun;
  sun.zenith_deg = zenith;
  return sun;
}

double mean(const std::vector<double>& l, const std::vector<double>& v, double from, double to) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < l.size(); ++i)
    if (l[i] >= from && l[i] < to) sum += v[i], ++count;
  REQUIRE(count > 0);
  return sum / count;
}

/// Gaussian response of a channel, peak 1.
double gaussian_line_weight(double l, double center, double fwhm) {
  const double x = (l - center) / fwhm;
  return std::exp(-4 * std::log(2.0) * x * x);
}

const double kWindows[][2] = {{0.45, 0.48}, {0.53, 0.57}, {0.64, 0.68}, {0.74, 0.755}, {0.86, 0.88}};

}  // namespace

TEST_CASE("S18 transmissions and the two-way factor against LOWTRAN7") {
  const auto paths = anchor("lowtran7_paths_vnir_swir.csv"), direct = anchor("lowtran7_direct_vnir_swir.csv");
  if (paths.empty()) return;
  const auto grid = clear_sky_wavelengths(0.4, 2.5, 0.001);
  const RenderTable low = build_clear_sky(midlatitude_summer_rural(), sun_at(40), 610, grid, {0, 300});
  const RenderTable high = build_clear_sky(midlatitude_summer_rural(), sun_at(40), 3000, grid, {0, 500});
  const auto column = [&](const std::vector<Line>& rows, const char* name) {
    std::vector<double> l, v;
    for (auto row = rows.rbegin(); row != rows.rend(); ++row)
      l.push_back(row->at("wavelength_um")), v.push_back(row->at(name));
    if (l.front() > l.back()) std::reverse(l.begin(), l.end()), std::reverse(v.begin(), v.end());
    std::vector<double> to = grid;
    to.back() = std::min(to.back(), l.back());
    return resample_linear(l, v, to);
  };
  const auto t_low = view_transmission(low, 0, 0), t_high = view_transmission(high, 0, 0),
             t_sun = sun_transmission(low, 0);
  const auto ref_low = column(paths, "T_0p61_180"), ref_high = column(paths, "T_3p0_180"),
             ref_sun = column(direct, "T_0.0_s40");
  const auto factor = two_way_factor(high, 0, 0);
  std::vector<double> lost(grid.size());
  for (std::size_t i = 0; i < grid.size(); ++i) lost[i] = t_high[i] * t_sun[i] * (1 - factor[i]);
  // Band edges, um, and the mean of T_sun T_view - T_two-way of S5.3 of the atmosphere specification (3 km).
  const double bands[][3] = {{0.4, 0.7, -0.001}, {0.7, 0.9, -0.016},  {0.9, 1.0, -0.048}, {1.1, 1.17, -0.047},
                             {1.2, 1.3, -0.024}, {1.5, 1.75, -0.023}, {2.0, 2.4, -0.049}};
  for (const auto& band : bands) {
    CAPTURE(band[0]);
    CHECK(std::abs(mean(grid, t_low, band[0], band[1]) - mean(grid, ref_low, band[0], band[1])) < 0.025);
    CHECK(std::abs(mean(grid, t_high, band[0], band[1]) - mean(grid, ref_high, band[0], band[1])) < 0.025);
    CHECK(std::abs(mean(grid, t_sun, band[0], band[1]) - mean(grid, ref_sun, band[0], band[1])) < 0.04);
    CHECK(std::abs(mean(grid, lost, band[0], band[1]) - band[2]) < 0.02);
  }
}

TEST_CASE("S17 S18 diffuse irradiance, sky and path radiance against DISORT") {
  const auto rows = anchor("libradtran_disort_solar.csv");
  if (rows.empty()) return;
  std::vector<double> grid;
  std::map<int, std::vector<Line>> at;  // height in m
  for (const Line& row : rows) {
    if (row.at("albedo") != 0 || row.at("wavelength_nm") < 445 || row.at("wavelength_nm") > 900) continue;
    const int height = static_cast<int>(std::lround(1000 * row.at("z_km")));
    if (height == 0) grid.push_back(row.at("wavelength_nm") / 1000);
    at[height].push_back(row);
  }
  const double mu0 = std::cos(40 * 3.14159265358979 / 180);
  /// Largest error of band means, each program divided by its own sun.
  const auto compare = [&](const RenderTable& t, const std::vector<double>& ours, int height,
                           const std::string& label) {
    const auto e0 = solar_irradiance(t);
    std::vector<double> a(grid.size()), b(grid.size());
    for (std::size_t i = 0; i < grid.size(); ++i) {
      a[i] = ours[i] / e0[i];
      b[i] = at[height][i].at(label) * mu0 / at[120000][i].at("direct");
    }
    double largest = 0;
    for (const auto& w : kWindows) {
      const double error = mean(grid, a, w[0], w[1]) / mean(grid, b, w[0], w[1]) - 1;
      if (std::abs(error) > std::abs(largest)) largest = error;
    }
    std::cout << "  " << label << " at " << height << " m: " << largest << "\n";
    return std::abs(largest);
  };
  const RenderTable low = build_clear_sky(midlatitude_summer_rural(), sun_at(40), 610, grid, {0, 610});
  const RenderTable high = build_clear_sky(midlatitude_summer_rural(), sun_at(40), 3000, grid, {0, 610});
  CHECK(compare(low, direct_irradiance(low, 0), 0, "direct") < 0.02);
  CHECK(compare(low, diffuse_irradiance(low, 0), 0, "diffuse_down") < 0.06);
  CHECK(compare(low, diffuse_irradiance(low, 610), 610, "diffuse_down") < 0.10);
  CHECK(compare(low, path_radiance(low, 0, 0, 0), 610, "L_up_0") < 0.06);
  CHECK(compare(high, path_radiance(high, 0, 0, 0), 3000, "L_up_0") < 0.18);
  CHECK(compare(low, sky_radiance(low, 0, 0, 0), 0, "L_dn_0") < 0.04);
  for (int zenith : {30, 45, 60, 75, 85})
    for (int azimuth : {0, 90, 180}) {
      const std::string angles = std::to_string(zenith) + "_az" + std::to_string(azimuth);
      CAPTURE(angles);
      CHECK(compare(low, sky_radiance(low, 0, zenith, azimuth), 0, "L_dn_" + angles) < 0.18);
    }
  for (int zenith : {30, 45})
    for (int azimuth : {0, 90, 180}) {
      // libRadtran names the propagation: 0 is the forward side, our 180.
      const std::string label = "L_up_" + std::to_string(zenith) + "_az" + std::to_string(180 - azimuth);
      CAPTURE(label);
      CHECK(compare(low, path_radiance(low, 0, zenith, azimuth), 610, label) < 0.14);
    }
}

TEST_CASE("S18 transmission and path radiance against MODTRAN 6") {
  const auto rows = anchor("modtran6_isofit_pasadena_vswir.csv");
  if (rows.empty()) return;
  scene::AtmosphereSpec air;
  air.water_g_cm2 = 1.5;
  air.ozone_atm_cm = 0.3;
  air.aod_550 = 0.1;
  air.ground_height_m = 350;
  air.pressure_hPa = 972;  // midlatitude summer at 0.35 km
  scene::Sun sun = sun_at(51.993);
  sun.day_of_year = 312;
  const auto grid = clear_sky_wavelengths(0.37, 2.5, 0.001);
  const RenderTable t = build_clear_sky(air, sun, 1950, grid, {0, 500});
  const auto two = two_way_transmission(t, 0, 0), path = path_radiance(t, 0, 0, 0), e0 = solar_irradiance(t);
  std::vector<double> l, error, ratio;
  for (const Line& row : rows) {
    const double center = row.at("center_nm") / 1000, fwhm = row.at("fwhm_nm") / 1000;
    if (center > 2.48) continue;
    double weight = 0, two_sum = 0, path_sum = 0;
    for (std::size_t i = 0; i < grid.size(); ++i) {
      if (std::abs(grid[i] - center) > 3 * fwhm) continue;
      const double w = gaussian_line_weight(grid[i], center, fwhm);
      weight += w, two_sum += w * two[i], path_sum += w * path[i] / e0[i];
    }
    l.push_back(center);
    error.push_back(two_sum / weight - row.at("Tsun_los_a0.10_w1.5"));
    ratio.push_back(path_sum / weight * row.at("E0") / (row.at("Lms_a0.10_w1.5") + row.at("Lss_a0.10_w1.5")));
  }
  for (const auto& band : {std::pair{0.38, 0.7}, {0.7, 1.0}, {1.0, 1.3}, {1.45, 1.75}, {1.98, 2.4}}) {
    CAPTURE(band.first);
    CHECK(std::abs(mean(l, error, band.first, band.second)) < 0.025);
  }
  CHECK(mean(l, ratio, 0.40, 0.56) == doctest::Approx(1).epsilon(0.06));
  CHECK(mean(l, ratio, 0.56, 0.70) == doctest::Approx(1).epsilon(0.12));
}
