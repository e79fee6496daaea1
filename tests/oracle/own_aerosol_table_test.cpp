// Tables of the layered model with aerosols of the user's own: Beer's law, a shipped aerosol stated anew, energy, and
// the solver's own answer where the phase function is stated in two ways.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "atmos_tables/compiler/air_stack.h"
#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/optics/standard_air.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::testing::refusal;

namespace {

scene::AtmosphereSpec air_of(const std::string& aerosol) {
  scene::AtmosphereSpec spec;
  spec.layered.emplace();
  spec.layered->profile = "midlatitude_summer";
  spec.layered->aerosol = aerosol;
  return spec;
}

scene::Sun sun_at(double zenith_deg) {
  scene::Sun sun;
  sun.zenith_deg = zenith_deg;
  return sun;
}

scene::OwnAerosolSpec particles(double depth, double albedo) {
  scene::OwnAerosolSpec own;
  own.optical_depth = depth;
  own.angstrom = 1.3, own.single_scattering_albedo = {albedo}, own.asymmetry = {0.68};
  return own;
}

/// The largest difference of two tables in a row, over the largest value of that row.
double largest_change(const RenderTable& a, const RenderTable& b, const std::string& row) {
  const auto &one = a.rows.at(row).values, &other = b.rows.at(row).values;
  REQUIRE(one.size() == other.size());
  double worst = 0, most = 0;
  for (std::size_t i = 0; i < one.size(); ++i)
    worst = std::max(worst, std::abs(double(one[i]) - double(other[i]))),
    most = std::max(most, std::abs(double(one[i])));
  return worst / most;
}

}  // namespace

TEST_CASE("S4.5 own aerosol in a table: it takes exp(-depth) of the light straight up, by Angstrom's law (Beer)") {
  const std::vector<double> um = {0.45, 0.55, 0.865, 1.65};
  const double height_m = 1500;
  auto with = air_of("none");
  with.layered->own_aerosols = {particles(0.4, 0.9)};
  const RenderTable clean = build_layered(air_of("none"), sun_at(0), height_m, um, {0}),
                    hazy = build_layered(with, sun_at(0), height_m, um, {0});
  const auto before = view_transmission(clean, 0, 0), after = view_transmission(hazy, 0, 0);
  const auto sun_before = sun_transmission(clean, 0), sun_after = sun_transmission(hazy, 0);
  for (std::size_t i = 0; i < um.size(); ++i) {
    const double depth = 0.4 * std::pow(um[i] / 0.55, -1.3);
    // Floats of the table: 6e-8 of T. Layers of both airs differ; gas bands follow those to 3e-5 here.
    CHECK(std::log(sun_before[i] / sun_after[i]) == doctest::Approx(depth).epsilon(3e-4));
    CHECK(std::log(before[i] / after[i]) == doctest::Approx(depth * -std::expm1(-height_m / 2000)).epsilon(3e-4));
  }
}

TEST_CASE("S4.5 own aerosol in a table: the shipped rural aerosol, stated region by region, makes the shipped table") {
  auto shipped = air_of("rural");
  shipped.layered->henyey_greenstein = true;
  const AirStack stack(*shipped.layered, 0, {0, 3});
  auto own = air_of("none");
  // The very wavelengths of the table, so that no rule between wavelengths comes in.
  const std::vector<double> um = {0.45, 0.55, 0.865, 2.2};
  for (std::size_t c = 0; c < stack.aerosols().components(); ++c) {
    scene::OwnAerosolSpec& region = own.layered->own_aerosols.emplace_back();
    region.name = stack.aerosols().name(c);
    region.optical_depth = stack.aerosols().depth_550(c, 0, 100);
    for (double height_km : stack.aerosols().level_km())
      region.height_km.push_back(height_km),
          region.height_extinction.push_back(stack.aerosols().extinction_550_per_km(c, height_km));
    for (double wave : um) {
      const auto optics = stack.aerosols().optics(c, wave);
      region.wavelength_um.push_back(wave), region.extinction.push_back(optics.extinction_ratio);
      region.single_scattering_albedo.push_back(optics.scattering_albedo), region.asymmetry.push_back(optics.asymmetry);
    }
  }
  const RenderTable a = build_layered(shipped, sun_at(40), 3000, um, {0}),
                    b = build_layered(own, sun_at(40), 3000, um, {0});
  for (const char* row : {"sun_transmission", "view_transmission", "path_radiance_solar", "sky_radiance_solar",
                          "diffuse_irradiance", "spherical_albedo", "sky_phase_mean", "sky_scattering_depth"}) {
    CAPTURE(row);
    CHECK(largest_change(a, b, row) < 2e-6);  // floats, and the sums of depths in another order
  }
}

TEST_CASE("S4.5 own aerosol in a table: light is scattered, not lost, where its albedo is 1 (no gas absorbs)") {
  // 0.4 um, without ozone and water: what goes in at the top comes out at the top or reaches the ground. Over black
  // ground: mu0 E0 = up at the top + direct and diffuse down at the ground.
  auto spec = air_of("none");
  spec.layered->ozone_atm_cm = 0, spec.layered->water_g_cm2 = 0;
  const auto balance = [&](double albedo) {
    spec.layered->own_aerosols = {particles(0.5, albedo)};
    const RenderTable table = build_layered(spec, sun_at(30), 100000, {0.4}, {0});
    // Up: path radiance seen from the top, integrated over the hemisphere; view zeniths end at 80 degrees.
    double up = 0;
    constexpr int kZenith = 200, kAzimuth = 90;
    const double least = std::cos(80 * std::acos(-1.0) / 180), pi = std::acos(-1.0);
    for (int i = 0; i < kZenith; ++i) {
      const double mu2 = least * least + (1 - least * least) * (i + 0.5) / kZenith,
                   zenith = std::acos(std::sqrt(mu2)) * 180 / pi;
      for (int a = 0; a < kAzimuth; ++a)
        up += path_radiance(table, 0, zenith, 180 * (a + 0.5) / kAzimuth)[0] * pi * (1 - least * least) /
              (kZenith * kAzimuth);
    }
    // The rest of the hemisphere, 80 to 90 degrees, has 3 % of mu dmu; its radiance is that at 80 degrees within half.
    const double rim = pi * least * least * path_radiance(table, 0, 80, 90)[0];
    const double in = std::cos(30 * pi / 180) * solar_irradiance(table)[0];
    const double down = diffuse_irradiance(table, 0)[0] + direct_irradiance(table, 0)[0];
    return std::pair((up + rim + down) / in, 0.5 * rim / in);
  };
  const auto [kept, unsure] = balance(1);
  CHECK(unsure < 0.01);
  CHECK(kept == doctest::Approx(1).epsilon(unsure + 0.003));  // 0.3 %: interpolation between the table's nodes
  CHECK(balance(0.8).first < 0.95);                           // and this one absorbs
}

TEST_CASE("S4.5 own aerosol in a table: 96 moments of Henyey-Greenstein and its g make one table") {
  auto by_g = air_of("none"), by_moments = by_g;
  by_g.layered->own_aerosols = {particles(0.3, 0.95)};
  by_moments.layered->own_aerosols = by_g.layered->own_aerosols;
  scene::OwnAerosolSpec& own = by_moments.layered->own_aerosols[0];
  own.asymmetry.clear();
  own.phase_moments.emplace_back();
  for (int k = 0; k < 96; ++k) own.phase_moments[0].push_back(std::pow(0.68, k));
  const RenderTable a = build_layered(by_g, sun_at(50), 2000, {0.55}, {0}),
                    b = build_layered(by_moments, sun_at(50), 2000, {0.55}, {0});
  for (const char* row : {"path_radiance_solar", "sky_radiance_solar", "diffuse_irradiance", "sky_phase_mean"})
    CHECK(largest_change(a, b, row) < 1e-6);  // 0.68^96 (2 96 + 1) = 2e-14: floats
}

TEST_CASE("S4.5 own aerosol in a table: provenance says whose it is; wavelengths it does not cover are refused") {
  auto spec = air_of("none");
  spec.layered->own_aerosols = {particles(0.3, 0.95)};
  const RenderTable table = build_layered(spec, sun_at(50), 2000, {0.55}, {0});
  const auto provenance = nlohmann::json::parse(table.provenance_json);
  CHECK(provenance["parameters"]["aod_550"].get<double>() == doctest::Approx(0.3).epsilon(1e-12));
  CHECK(provenance["parameters"]["aod_550_from"] == "own aerosols");
  CHECK(provenance["parameters"]["own_aerosols"][0]["asymmetry"][0] == 0.68);
  CHECK(provenance["sources"].dump().find("own: the user's") != std::string::npos);
  scene::OwnAerosolSpec& own = spec.layered->own_aerosols[0];
  own.wavelength_um = {0.5, 0.6}, own.asymmetry = {0.6, 0.7};
  CHECK(refusal([&] {
          check_layered(spec, sun_at(50), 2000, {0.45, 0.55}, {0});
        }).find("cover 0.5 to 0.6 um") != std::string::npos);
}
