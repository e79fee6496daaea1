// What a scene asks of the air beyond what the air knows. Oracle: the light of a setting sun never grows.
#include "host/run/air_limits.h"

#include <doctest/doctest.h>

#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/rct_file.h"
#include "tests/unit/test_folder.h"

using namespace raycube;

namespace {

const double kZeniths_deg[] = {89.9, 89.98,  89.99, 89.991, 89.999, 89.99999, 89.9999999,
                               90.0, 90.001, 90.5,  90.8,   90.84,  91.0};

scene::Simulation under(double zenith_deg, bool layered) {
  scene::Simulation out;
  out.sun.zenith_deg = zenith_deg;
  if (layered) out.atmosphere.layered.emplace();
  return out;
}

}  // namespace

TEST_CASE("the sun is held from where the light of the models falls to nothing, and nowhere does light grow") {
  for (const bool layered : {false, true}) {
    double before = 1e9;
    for (const double zenith_deg : kZeniths_deg) {
      CAPTURE(zenith_deg);
      scene::Simulation simulation = under(zenith_deg, layered);
      run::keep_within_air(simulation);
      const bool held = zenith_deg > run::kHeldZenith_deg && zenith_deg <= run::kSunsetZenith_deg;
      CHECK(simulation.sun.zenith_deg == (held ? run::kHeldZenith_deg : zenith_deg));
      CHECK(simulation.notices.size() == (held ? 1 : 0));
      if (layered) continue;  // the same angle, and long to compute
      const auto table = atmos::make_table(simulation.atmosphere, simulation.sun, 1000, {0.45, 0.55, 0.8}, {0});
      double light = 0;
      for (const float value : table.rows.at("diffuse_irradiance").values) light += value;
      for (const float value : table.rows.at("direct_irradiance").values) light += value;
      CHECK(light <= before);
      CHECK((light > 0) == (zenith_deg <= run::kSunsetZenith_deg));
      before = light;
    }
  }
  scene::Simulation moon = under(90.3, false), vacuum = under(90.3, false);
  moon.sun.moon_phase_deg = 0, vacuum.atmosphere.none = true;
  for (scene::Simulation* simulation : {&moon, &vacuum}) {
    run::keep_within_air(*simulation);
    CHECK(simulation->sun.zenith_deg == 90.3);
  }
}

TEST_CASE("the sun is held for a table that was made where it is held, and for no other") {
  const testing::TestFolder folder;
  const std::string file = folder / "a.rct";
  for (const double made_deg : {89.99, 89.9, 90.3}) {
    scene::Simulation maker = under(made_deg, false);
    if (made_deg < 90) run::keep_within_air(maker);
    atmos::write_rct(atmos::make_table(maker.atmosphere, maker.sun, 1000, {0.45, 0.55}, {0}), file,
                     base::IfExists::replace);
    for (const double zenith_deg : {89.9, 90.3, 91.0}) {
      CAPTURE(made_deg);
      CAPTURE(zenith_deg);
      scene::Simulation simulation = under(zenith_deg, false);
      simulation.atmosphere.table_file = file;
      run::keep_within_air(simulation);
      CHECK(simulation.sun.zenith_deg == (made_deg == 89.99 && zenith_deg == 90.3 ? 89.99 : zenith_deg));
    }
  }
  scene::Simulation none = under(90.3, false);
  none.atmosphere.table_file = folder / "none.rct";
  run::keep_within_air(none);  // whoever needs it says so
  CHECK(none.sun.zenith_deg == 90.3);
}

TEST_CASE("bands are cut to the model by which the air is, of a scene that is not compiled") {
  const auto cut = [](double center_um, double fwhm_um, bool layered) {
    scene::Simulation simulation = under(40, layered);
    scene::Instrument& instrument = simulation.instruments.emplace_back();
    instrument.poses.emplace_back();
    scene::Band& band = instrument.bands.emplace_back();
    band.center_um = center_um, band.fwhm_um = fwhm_um;
    run::keep_within_air(simulation);
    return std::pair(instrument.bands[0], simulation.notices);
  };
  const auto [pan, told] = cut(0.65, 0.2, true);
  CHECK(pan.from_um == doctest::Approx(0.3));
  REQUIRE(told.size() == 1);
  CHECK(told[0].find("is cut to what the atmosphere covers") != std::string::npos);
  CHECK(cut(3.75, 0.15, false).first.to_um == doctest::Approx(4.0));  // the clear sky's end; 3.75 + 2.5 x 0.15 = 4.125
  CHECK(cut(3.75, 0.15, true).second.empty());                        // the layered air goes on
  const auto [left, why] = cut(0.65, 0.3, true);                      // erfc(1.943) / 2 = 3.0e-3 of it lie beyond
  CHECK(left.from_um < 0.3);
  REQUIRE(why.size() == 1);
  CHECK(why[0].find("too much beyond") != std::string::npos);
}
