// scattering in whole tables against libRadtran's uvspec with DISORT of 16 streams
// (anchors/libradtran_disort_solar.csv). Scene: midlatitude summer, rural aerosol of 23 km, sun at 40 degrees, LOWTRAN7
// bands, Henyey-Greenstein phase functions. Everything is over each code's own solar irradiance (Kurucz 1992 there).
// Bars outside gas bands: radiance 3 %, fluxes 2 %.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/interpolate.h"
#include "tests/support/layered_anchor.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

constexpr double kPi = 3.14159265358979;

/// Relative errors at one wavelength.
struct Compared {
  testing::Errors flux, sky, up, flux_610, sky_610;
  double coupled = 0;
};

class Reference {
 public:
  explicit Reference(const std::vector<testing::AnchorRow>& rows) {
    for (const auto& row : rows) at_[{row.at("wavelength_nm"), row.at("albedo"), row.at("z_km")}] = row;
  }
  /// Over the irradiance above the air.
  double value(double nm, double albedo, double km, const std::string& column) const {
    return at_.at({nm, albedo, km}).at(column) * std::cos(40 * kPi / 180) / at_.at({nm, 0, 120}).at("direct");
  }

 private:
  std::map<std::tuple<double, double, double>, testing::AnchorRow> at_;
};

Compared compare(const Reference& reference, double nm, testing::ChartRows& chart) {
  auto spec = testing::summer_rural_air();
  spec.layered->gas_bands = "lowtran", spec.layered->henyey_greenstein = true;
  const RenderTable table = build_layered(spec, testing::sun_at(40), 3000, {nm / 1000}, {0, 610});
  const double e0 = solar_irradiance(table)[0];
  const auto error = [&](double found, double km, const std::string& column, double albedo = 0) {
    return found / e0 / reference.value(nm, albedo, km, column) - 1;
  };
  Compared out;
  for (double km : {0.0, 0.61}) {
    const double height = 1000 * km, direct = direct_irradiance(table, height)[0],
                 diffuse = diffuse_irradiance(table, height)[0];
    if (km == 0) out.flux.add(error(direct, km, "direct")), out.flux.add(error(diffuse, km, "diffuse_down"));
    const double global = reference.value(nm, 0, km, "direct") + reference.value(nm, 0, km, "diffuse_down");
    (km == 0 ? out.flux : out.flux_610).add((direct + diffuse) / e0 / global - 1);
    testing::Errors& sky = km == 0 ? out.sky : out.sky_610;
    const double zenith_light = sky_radiance(table, height, 0, 0)[0];
    sky.add(error(zenith_light, km, "L_dn_0"));
    if (km == 0) chart.add({nm / 1000, 0, zenith_light / e0, reference.value(nm, 0, km, "L_dn_0")});
    for (int zenith : {30, 45, 60, 75, 85})
      for (int azimuth : {0, 90, 180}) {
        const double found = sky_radiance(table, height, zenith, azimuth)[0];
        const std::string column = "L_dn_" + std::to_string(zenith) + "_az" + std::to_string(azimuth);
        sky.add(error(found, km, column));
        if (km == 0 && azimuth != 90)
          chart.add({nm / 1000, static_cast<double>(azimuth == 0 ? zenith : -zenith), found / e0,
                     reference.value(nm, 0, km, column)});
      }
  }
  // Azimuth there is the light's, forward along the beam; here the line of sight's, from the sun's side.
  out.up.add(error(path_radiance(table, 0, 0, 0)[0], 3, "L_up_0"));
  for (int zenith : {30, 45})
    for (int azimuth : {0, 90, 180})
      out.up.add(error(path_radiance(table, 0, zenith, 180 - azimuth)[0], 3,
                       "L_up_" + std::to_string(zenith) + "_az" + std::to_string(azimuth)));
  // S4.9: the same air over ground of albedo 0.3.
  const double irradiance = direct_irradiance(table, 0)[0] + diffuse_irradiance(table, 0)[0];
  const double through = view_transmission(table, 0, 0)[0] + diffuse_view_transmission(table, 0, 0)[0];
  const double above =
      path_radiance(table, 0, 0, 0)[0] + 0.3 * through * irradiance / kPi / (1 - 0.3 * spherical_albedo(table, 0)[0]);
  out.coupled = error(above, 3, "L_up_0", 0.3);
  for (testing::Errors* errors : {&out.flux, &out.sky, &out.up, &out.flux_610, &out.sky_610}) errors->close();
  std::printf(
      "%5.3f um: fluxes %+.3f  sky %+.3f (rms %.3f)  path %+.3f  albedo 0.3 %+.4f  at 0.61 km: global %+.3f sky "
      "%+.3f\n",
      nm / 1000, out.flux.worst, out.sky.worst, out.sky.rms, out.up.worst, out.coupled, out.flux_610.worst,
      out.sky_610.worst);
  return out;
}

}  // namespace

TEST_CASE("A-16 fluxes, sky and path radiance against uvspec-DISORT, Henyey-Greenstein") {
  const auto rows =
      testing::anchor_rows("anchors/libradtran_disort_solar.csv", "scattering was not compared with uvspec");
  if (rows.empty()) return;
  const Reference reference(rows);
  testing::ChartRows chart("uvspec_sky", "um,zenith,found,reference");
  for (double nm : {340., 400., 420., 450., 500., 550., 675., 750., 780., 865., 1040.}) {
    const Compared found = compare(reference, nm, chart);
    CAPTURE(nm);
    CHECK(std::abs(found.flux.worst) <= 0.02);
    CHECK(std::abs(found.sky.worst) <= 0.03);
    CHECK(std::abs(found.up.worst) <= 0.03);
    CHECK(std::abs(found.coupled) <= 0.01);
    // uvspec spreads the aerosol of 0 to 1 km evenly, here it falls exponentially from knot to knot: 0.007 less depth
    // above 0.61 km out of 0.3. Sky there is up to 4.3 % darker, the direct light 0.7 % brighter than at the ground.
    CHECK(std::abs(found.flux_610.worst) <= 0.02);
    CHECK(std::abs(found.sky_610.worst) <= 0.045);
  }
  // In the SWIR aerosol alone scatters, and its tables are read differently: uvspec's direct light has 0.003 more depth
  // out of an aerosol's 0.03 to 0.05 at 1.6 to 2.25 um (humidity: raising it from LOWTRAN7's mean over the layer, 67 %,
  // to 76 % brightens the sky by 3 % at 1.65 um and by 5 % at 2.2 um, nadir by 1 and 5 %). What is reached: 4 % and 9 %
  // (fluxes 3 %).
  for (double nm : {1550., 1600., 1650., 1700., 2200., 2250.}) {
    const Compared found = compare(reference, nm, chart);
    CAPTURE(nm);
    CHECK(std::abs(found.flux.worst) <= 0.03);
    CHECK(std::abs(found.sky.worst) <= (nm < 2000 ? 0.04 : 0.09));
    CHECK(std::abs(found.up.worst) <= (nm < 2000 ? 0.045 : 0.095));
  }
}
