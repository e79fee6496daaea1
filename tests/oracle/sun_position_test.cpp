// Sun position against published examples; tolerance 0.004 degrees: the published values are topocentric (parallax 0.0024
// degrees) and rounded to a minute (almanac).
#include <doctest/doctest.h>

#include <cmath>

#include "atmos_tables/bird_riordan.h"
#include "host/base/error.h"
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
  // Astronomical Almanac: solstices 2012-06-20 23:09 and 2012-12-21 11:12 UTC; obliquity 23.4380 degrees. At the pole the
  // zenith angle is 90 minus the declination, whatever the hour.
  CHECK(std::abs(scene::sun_from_time("2012-06-20T23:09:00Z", 90, 0).zenith_deg - (90 - 23.438)) < 0.004);
  CHECK(std::abs(scene::sun_from_time("2012-12-21T11:12:00Z", -90, 0).zenith_deg - (90 - 23.438)) < 0.004);
  // Morning sun in the east, evening sun in the west, noon sun in the south (northern mid-latitudes).
  CHECK(std::abs(scene::sun_from_time("2012-03-20T06:00:00Z", 0, 0).azimuth_deg - 90) < 1);
  CHECK(std::abs(scene::sun_from_time("2012-03-20T18:00:00Z", 0, 0).azimuth_deg - 270) < 1);
  CHECK(std::abs(scene::sun_from_time("2012-03-20T12:07:30Z", 45, 0).azimuth_deg - 180) < 1);
}

TEST_CASE("S6 sun position: longitude is east positive and turns 15 degrees an hour") {
  // 15 degrees east sees at 11 UTC what Greenwich sees at 12, but for the sun's own motion in an hour (0.017 deg at most).
  const auto here = scene::sun_from_time("2012-09-20T12:00:00Z", 40, 0), east = scene::sun_from_time("2012-09-20T11:00:00Z", 40, 15);
  CHECK(std::abs(here.zenith_deg - east.zenith_deg) < 0.03);
  CHECK(std::abs(here.azimuth_deg - east.azimuth_deg) < 0.03);
}

TEST_CASE("S18 earth-sun factor: Spencer's series against the almanac's extreme distances") {
  // Perihelion 2012-01-05: 0.98328 AU; aphelion 2012-07-05: 1.01668 AU. Series good to 1e-4 in the factor by its author,
  // plus 4e-4: his constant 1.00011 and fitted phase belong to a mean year.
  CHECK(std::abs(atmos::earth_sun_factor(5) - 1 / (0.98328 * 0.98328)) < 1e-3);
  CHECK(std::abs(atmos::earth_sun_factor(187) - 1 / (1.01668 * 1.01668)) < 1e-3);
  CHECK(atmos::earth_sun_factor(0) == 1.0);
  CHECK(std::abs(atmos::earth_sun_factor(1) - (1.00011 + 0.034221 + 0.000719)) < 1e-12);
}

TEST_CASE("S6 sun position: no date and no place on earth are refused with the value found") {
  for (const char* bad : {"", "2012-09-20", "2012-09-20T15:30:00", "2012-09-20T15:30:00+02", "2012-02-30T00:00:00Z",
                          "2012-13-01T00:00:00Z", "1800-01-01T00:00:00Z", "2012-09-20T24:00:00Z", "2012-09-20T15:30:nanZ"})
    CHECK_THROWS_WITH_AS(scene::sun_from_time(bad, 0, 0), doctest::Contains(bad), base::Error);
  CHECK_THROWS_WITH_AS(scene::sun_from_time("2012-09-20T15:30:00Z", 91, 0), doctest::Contains("91"), base::Error);
  CHECK_THROWS_AS(scene::sun_from_time("2012-09-20T15:30:00Z", 0, NAN), base::Error);
}
