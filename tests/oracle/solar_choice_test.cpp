// The sun's spectrum by choice: published integrals, linearity of everything that is lit, exact means over nodes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/interpolate.h"
#include "atmos_tables/solar_spectrum.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::testing::refusal;

namespace {

scene::Sun sun_at(double zenith_deg) {
  scene::Sun sun;
  sun.zenith_deg = zenith_deg;
  return sun;
}

scene::AtmosphereSpec layered() {
  scene::AtmosphereSpec spec;
  spec.layered.emplace();
  return spec;
}

/// The default spectrum as a file would hold it: the same nodes, times a factor.
scene::SolarSpectrumSpec copied(double factor) {
  const SolarSpectrum standing;
  scene::SolarSpectrumSpec out;
  out.name = "copy.csv";
  for (int nm = 300; nm <= 1000; nm += 2) out.wavelength_um.push_back(nm / 1000.0);
  for (int nm = 1005; nm <= 2500; nm += 5) out.wavelength_um.push_back(nm / 1000.0);
  for (double um : out.wavelength_um) out.irradiance.push_back(factor * standing.irradiance_1au(um));
  return out;
}

}  // namespace

TEST_CASE("S18 sun by choice: ASTM E-490 holds the solar constant it is published with") {
  // 1366.1 W m-2 in all, of which 1.1 % lie below 0.3 um and next to nothing beyond 31 um: between, the
  // figures' own trapezoid gives 1351.3. Nodes of 2 nm and more keep it to 5e-4.
  const SolarSpectrum e490({"e490", {}, {}});
  const double found = e490.mean_1au(0.3, 31) * 30.7;
  CHECK(found == doctest::Approx(1351.3).epsilon(5e-4));
  // Both spectra are the one sun, seen twenty years apart: over 100 nm within 4.5 % (found: 2.4 % at 0.45 um, 3.8 % at
  // 1.25 um, where TSIS-1 is lower than all before it); another unit or column is a factor.
  for (double um = 0.4; um < 2.35; um += 0.1)
    CHECK(e490.mean_1au(um, um + 0.1) == doctest::Approx(SolarSpectrum().mean_1au(um, um + 0.1)).epsilon(0.045));
}

TEST_CASE("S18 sun by choice: light in a table goes linearly with a file's irradiance, thermal light not at all") {
  const std::vector<double> um = {0.45, 0.55, 0.865, 1.65, 2.2, 3.7};
  auto once = layered(), twice = layered();
  once.solar = copied(1), twice.solar = copied(2);
  const RenderTable a = build_layered(once, sun_at(40), 2000, um, {0}),
                    b = build_layered(twice, sun_at(40), 2000, um, {0}),
                    shipped = build_layered(layered(), sun_at(40), 2000, um, {0});
  for (const char* row :
       {"solar_irradiance", "path_radiance_solar", "sky_radiance_solar", "direct_irradiance", "diffuse_irradiance"}) {
    CAPTURE(row);
    const auto &one = a.rows.at(row).values, &two = b.rows.at(row).values, &same = shipped.rows.at(row).values;
    for (std::size_t i = 0; i < one.size(); ++i) {
      CHECK(two[i] == doctest::Approx(2 * one[i]).epsilon(3e-6));
      CHECK(one[i] == doctest::Approx(same[i]).epsilon(3e-6));  // beyond 2.5 um the shipped one goes on, times 1
    }
  }
  for (const char* row : {"sun_transmission", "view_transmission", "path_radiance_thermal", "spherical_albedo"})
    CHECK(a.rows.at(row).values == b.rows.at(row).values);
  CHECK(b.solar_source.find("copy.csv, 300 to 2500 nm, steps of 2 to 5 nm") != std::string::npos);
  const auto notices = nlohmann::json::parse(b.provenance_json)["notices"].dump();
  CHECK(notices.find("the shipped tsis1 goes on beyond 2.5 um times 2,") != std::string::npos);
}

TEST_CASE("S18 sun by choice: nodes of a table share out a fine file's energy, in every model") {
  // A comb of lines 0.1 nm apart: 1 at even, 3 at odd places, whose mean over any whole number of nanometres is 2 (the
  // ends of straight lines count half). Nodes every nanometre, which all stand at a 1: sampled, they would say 1.
  scene::SolarSpectrumSpec comb;
  comb.name = "comb.csv";
  for (int i = 0; i <= 4000; ++i)
    comb.wavelength_um.push_back(0.4 + 1e-4 * i), comb.irradiance.push_back(i % 2 ? 3000.0 : 1000.0);
  std::vector<double> um;
  for (int i = 0; i <= 20; ++i) um.push_back(0.5 + 0.001 * i);
  auto air = layered(), quick = scene::AtmosphereSpec(), none = scene::AtmosphereSpec();
  air.layered->k_terms = 1, air.layered->streams = 4;
  none.none = true;
  for (scene::AtmosphereSpec* spec : {&air, &quick, &none}) {
    spec->solar = comb;
    const RenderTable table =
        spec->layered ? build_layered(*spec, sun_at(40), 500, um, {0}) : make_table(*spec, sun_at(40), 500, um, {0});
    for (double e0 : solar_irradiance(table)) CHECK(e0 == doctest::Approx(2000).epsilon(1e-6));
    CHECK(table.solar_source.find("steps of 0.1 nm") != std::string::npos);
  }
}

TEST_CASE("S18 sun by choice: outside its range a file is met, and what is no spectrum of the sun is refused") {
  scene::SolarSpectrumSpec part;
  part.name = "part.csv";
  for (int nm = 500; nm <= 700; nm += 2)
    part.wavelength_um.push_back(nm / 1000.0),
        part.irradiance.push_back(1.1 * SolarSpectrum().irradiance_1au(nm / 1000.0));
  const SolarSpectrum sun(part), standing;
  for (double um : {0.35, 0.45, 0.9, 2.2, 10.0, 100.0})
    CHECK(sun.irradiance_1au(um) == doctest::Approx(1.1 * standing.irradiance_1au(um)).epsilon(1e-9));
  CHECK(sun.step_um(0.6) == doctest::Approx(0.002));
  CHECK(!sun.notice(0.5, 0.7));
  REQUIRE(sun.notice(0.4, 0.8));
  CHECK(sun.notice(0.4, 0.8)->find("below 0.5 um times 1.1 and beyond 0.7 um times 1.1") != std::string::npos);
  scene::SolarSpectrumSpec wrong;
  wrong.name = "wrong.csv", wrong.wavelength_um = {100, 200}, wrong.irradiance = {1, 1};
  CHECK(refusal([&] { SolarSpectrum{wrong}; }).find("check its unit") != std::string::npos);
  CHECK(refusal([] { SolarSpectrum({"thuillier", {}, {}}); }).find("use tsis1 or e490") != std::string::npos);
}
