// Numbers as Fortran writes them, and the named conversions. Oracle: the formats' own rules and arithmetic by hand.
#include "tests/unit/import_kit.h"

#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/text_lines.h"

using namespace raycube;
using namespace raycube::atmos::imported;

TEST_CASE("S20 import: numbers of Fortran are read as the format means them") {
  const auto good = [](const char* text, double value, double rounding) {
    CAPTURE(text);
    const Number number = read_number(text);
    REQUIRE(number.good());
    CHECK(number.value == doctest::Approx(value).epsilon(1e-15));
    CHECK(number.rounding == doctest::Approx(rounding).epsilon(1e-12));
  };
  good(" 2050.00", 2050, 0.005);
  good("1.234-105", 1.234e-105, 0.5e-108);
  good("1.234+05", 1.234e5, 50);
  good("-2.5E-03", -2.5e-3, 0.5e-4);
  good("1.5D+02", 150, 5);
  good(".5", 0.5, 0.05);
  good("7.", 7, 0.5);
  good("+3", 3, 0.5);
  good("0.0000E+00", 0, 0);
  good("0.000", 0, 0.0005);
  CHECK(read_number("1.0-400").value == 0);
  using State = Number::State;
  for (const char* text : {"", "   "}) CHECK(read_number(text).state == State::blank);
  for (const char* text : {"********", "**"}) CHECK(read_number(text).state == State::overflow);
  for (const char* text : {"NaN", "-nan", "Infinity", "+Inf", "1.0+400"})
    CHECK(read_number(text).state == State::not_finite);
  for (const char* text : {"1.2.3", "E5", "1.0E", "1.0E+", "abc", "-", "1 2", "0x10", "1.0-1x"}) {
    CAPTURE(text);
    CHECK(read_number(text).state == State::malformed);
  }
}

TEST_CASE("S20 import: units and angles are converted by the stated factors") {
  // 9.0e-6 W cm-2 sr-1 (cm-1)-1 at 1000 cm-1 (10 um) is 9.0 W m-2 sr-1 um-1: dnu = 1e4/lambda^2 dlambda.
  CHECK(W_per_m2_um_from_W_per_cm2_axis(9.0e-6, AxisUnit::per_cm, 10) == doctest::Approx(9.0).epsilon(1e-14));
  CHECK(W_per_m2_um_from_W_per_cm2_axis(2.0, AxisUnit::um, 5) == doctest::Approx(2e4).epsilon(1e-14));
  CHECK(W_per_m2_um_from_W_per_cm2_axis(2.0, AxisUnit::nm, 5) == doctest::Approx(2e7).epsilon(1e-14));
  CHECK(W_per_m2_um_from_W_per_m2_per_cm(0.09, 10) == doctest::Approx(9.0).epsilon(1e-14));
  CHECK(wavelength_um_from_axis(2000, AxisUnit::per_cm) == doctest::Approx(5).epsilon(1e-15));
  CHECK(wavelength_um_from_axis(550, AxisUnit::nm) == doctest::Approx(0.55).epsilon(1e-15));
  CHECK(folded_azimuth_deg(270) == doctest::Approx(90));
  CHECK(folded_azimuth_deg(-180) == doctest::Approx(180));
  // MODTRAN: the sun straight ahead along the line of sight (PARM1 = 0) is behind the target seen from the target: 180.
  CHECK(relative_azimuth_deg_from_modtran(0) == doctest::Approx(180));
  CHECK(relative_azimuth_deg_from_modtran(-150) == doctest::Approx(30));
  CHECK(sky_relative_azimuth_deg_from_modtran(-150) == doctest::Approx(150));
  CHECK(view_zenith_deg_from_modtran(150, 0.02) == doctest::Approx(30.02));
  // uvspec: light coming down with phi = phi0 comes from the sun's side (0); light going up with phi = phi0 goes on
  // (180).
  CHECK(relative_azimuth_deg_from_uvspec(-0.5, 30, 30) == doctest::Approx(0));
  CHECK(relative_azimuth_deg_from_uvspec(0.5, 30, 30) == doctest::Approx(180));
  CHECK(relative_azimuth_deg_from_uvspec(0.5, 210, 30) == doctest::Approx(0).epsilon(1e-12));
  CHECK(zenith_deg_from_umu(-0.5) == doctest::Approx(60));
}
