// Sun position against published examples; tolerance 0.004 degrees: the published values are topocentric (parallax
// 0.0024 degrees) and rounded to a minute (almanac).
#include <doctest/doctest.h>

#include <cmath>

#include <vector>

#include "atmos_tables/bird_riordan.h"
#include "atmos_tables/clear_sky.h"
#include "atmos_tables/moon.h"
#include "host/base/error.h"
#include "host/base/units.h"
#include "scene_compiler/sun_position.h"

using namespace raycube;

TEST_CASE("S6 sun position: the worked example of NREL's Solar Position Algorithm") {
  // Reda & Andreas, NREL/TP-560-34302 (2008), table A5.1: 2003-10-17 12:30:30 at UTC - 7 h, 39.742476 N, 105.1786 W.
  // Topocentric zenith 50.11162 with refraction 0.01633 (e0 = 39.872046): 50.127954 without. Azimuth 194.34024.
  const auto sun = scene::sun_from_time("2003-10-17T19:30:30Z", 39.742476, -105.1786);
  CHECK(std::abs(sun.zenith_deg - 50.127954) < 0.004);
  MESSAGE("zenith " << sun.zenith_deg << ", azimuth " << sun.azimuth_deg);
  CHECK(std::abs(sun.azimuth_deg - 194.34024) < 0.004);
  CHECK(sun.day_of_year == 290);
  CHECK(sun.utc == "2003-10-17T19:30:30Z");
}

TEST_CASE("S6 sun position: declination at the solstices and the place of the subsolar point") {
  // Astronomical Almanac: solstices 2012-06-20 23:09 and 2012-12-21 11:12 UTC; obliquity 23.4380 degrees. At the pole
  // the zenith angle is 90 minus the declination, whatever the hour.
  CHECK(std::abs(scene::sun_from_time("2012-06-20T23:09:00Z", 90, 0).zenith_deg - (90 - 23.438)) < 0.004);
  CHECK(std::abs(scene::sun_from_time("2012-12-21T11:12:00Z", -90, 0).zenith_deg - (90 - 23.438)) < 0.004);
  // Morning sun in the east, evening sun in the west, noon sun in the south (northern mid-latitudes).
  CHECK(std::abs(scene::sun_from_time("2012-03-20T06:00:00Z", 0, 0).azimuth_deg - 90) < 1);
  CHECK(std::abs(scene::sun_from_time("2012-03-20T18:00:00Z", 0, 0).azimuth_deg - 270) < 1);
  CHECK(std::abs(scene::sun_from_time("2012-03-20T12:07:30Z", 45, 0).azimuth_deg - 180) < 1);
}

TEST_CASE("S6 sun position: longitude is east positive and turns 15 degrees an hour") {
  // 15 degrees east sees at 11 UTC what Greenwich sees at 12, but for the sun's own motion in an hour (0.017 deg at
  // most).
  const auto here = scene::sun_from_time("2012-09-20T12:00:00Z", 40, 0),
             east = scene::sun_from_time("2012-09-20T11:00:00Z", 40, 15);
  CHECK(std::abs(here.zenith_deg - east.zenith_deg) < 0.03);
  CHECK(std::abs(here.azimuth_deg - east.azimuth_deg) < 0.03);
}

TEST_CASE("S18 earth-sun factor: Spencer's series against the almanac's extreme distances") {
  // Perihelion 2012-01-05: 0.98328 AU; aphelion 2012-07-05: 1.01668 AU. Series good to 1e-4 in the factor by its
  // author, plus 4e-4: his constant 1.00011 and fitted phase belong to a mean year.
  CHECK(std::abs(atmos::earth_sun_factor(5) - 1 / (0.98328 * 0.98328)) < 1e-3);
  CHECK(std::abs(atmos::earth_sun_factor(187) - 1 / (1.01668 * 1.01668)) < 1e-3);
  CHECK(atmos::earth_sun_factor(0) == 1.0);
  CHECK(std::abs(atmos::earth_sun_factor(1) - (1.00011 + 0.034221 + 0.000719)) < 1e-12);
}

TEST_CASE("S6 sun position: no date and no place on earth are refused with the value found") {
  for (const char* bad :
       {"", "2012-09-20", "2012-09-20T15:30:00", "2012-09-20T15:30:00+02", "2012-02-30T00:00:00Z",
        "2012-13-01T00:00:00Z", "1800-01-01T00:00:00Z", "2012-09-20T24:00:00Z", "2012-09-20T15:30:nanZ"})
    CHECK_THROWS_WITH_AS(scene::sun_from_time(bad, 0, 0), doctest::Contains(bad), base::Error);
  CHECK_THROWS_WITH_AS(scene::sun_from_time("2012-09-20T15:30:00Z", 91, 0), doctest::Contains("91"), base::Error);
  CHECK_THROWS_AS(scene::sun_from_time("2012-09-20T15:30:00Z", 0, NAN), base::Error);
}

TEST_CASE("S4.11 moon: apparent place and phase of Meeus, Astronomical Algorithms, examples 47.a and 48.a") {
  // 1992 April 12, 0h TD (Delta T 58.7 s): right ascension 134.688470, declination 13.768368 deg, distance 368409.7 km,
  // phase angle 69.0756 deg. Horizon coordinates and parallax by hand, with the mean sidereal time of Meeus (12.4).
  const double julian_day = 2448724.5 - 58.7 / 86400, latitude = base::rad_from_deg(40);
  for (double longitude_deg : {-75.0, -40.0, 10.0}) {
    const double sidereal_deg = 280.46061837 + 360.98564736629 * (julian_day - 2451545.0) + longitude_deg;
    const double hour = base::rad_from_deg(sidereal_deg) - base::rad_from_deg(134.688470),
                 declination = base::rad_from_deg(13.768368);
    const double height = std::asin(std::sin(latitude) * std::sin(declination) +
                                    std::cos(latitude) * std::cos(declination) * std::cos(hour));
    const double south_over_west =
        std::atan2(std::sin(hour), std::cos(hour) * std::sin(latitude) - std::tan(declination) * std::cos(latitude));
    const double zenith = base::rad_from_deg(90) - height;
    const double seen = base::deg_from_rad(std::atan2(std::sin(zenith), std::cos(zenith) - 6371.0 / 368409.7));
    const auto moon = scene::moon_from_time("1992-04-11T23:59:01.3Z", 40, longitude_deg);
    CHECK(std::abs(moon.zenith_deg - seen) < 0.02);
    CHECK(std::abs(std::remainder(moon.azimuth_deg - (base::deg_from_rad(south_over_west) + 180), 360)) < 0.02);
    CHECK(std::abs(moon.moon_phase_deg - 69.0756) < 0.02);
    CHECK(moon.day_of_year == 102);
  }
}

TEST_CASE("S4.11 moonlight is sunlight by phase and albedo; a moon that is down leaves the scene dark") {
  scene::Sun moon;
  moon.zenith_deg = 30;
  moon.moon_phase_deg = 30;
  const std::vector<double> grid = {0.5, 0.6, 0.9};
  scene::Sun sun = moon;
  sun.moon_phase_deg = -1;
  const auto lit = atmos::vacuum_table(moon, 1000, grid, {0}), day = atmos::vacuum_table(sun, 1000, grid, {0});
  for (std::size_t i = 0; i < grid.size(); ++i)
    CHECK(lit.rows.at("solar_irradiance").values[i] / day.rows.at("solar_irradiance").values[i] ==
          doctest::Approx(atmos::moon_over_sun(30, grid[i])).epsilon(1e-6));
  moon.zenith_deg = 95;  // no twilight by moonlight: no error, no light
  scene::AtmosphereSpec air;
  const auto down = atmos::build_clear_sky(air, moon, 1000, grid, {0});
  for (float value : down.rows.at("direct_irradiance").values) CHECK(value == 0);
  moon.moon_phase_deg = 190;
  CHECK_THROWS_AS(atmos::vacuum_table(moon, 1000, grid, {0}), base::Error);
}
