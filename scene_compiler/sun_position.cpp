#include "scene_compiler/sun_position.h"

#include <libnova/dynamical_time.h>
#include <libnova/julian_day.h>
#include <libnova/lunar.h>
#include <libnova/precession.h>
#include <libnova/sidereal_time.h>
#include <libnova/solar.h>
#include <libnova/transform.h>

#include <cmath>
#include <cstdio>

#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::scene {
namespace {

bool is_leap(int year) { return (year % 4 == 0 && year % 100 != 0) || year % 400 == 0; }

int days_in_month(int year, int month) {
  constexpr int kDays[] = {31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
  return month == 2 && is_leap(year) ? 29 : kDays[month - 1];
}

ln_date parse_utc(const std::string& utc) {
  ln_date date{};
  char zone = 0;
  int used = 0;
  const int fields = std::sscanf(utc.c_str(), "%4d-%2d-%2dT%2d:%2d:%lf%c%n", &date.years, &date.months, &date.days,
                                 &date.hours, &date.minutes, &date.seconds, &zone, &used);
  const bool shape = fields == 7 && zone == 'Z' && static_cast<std::size_t>(used) == utc.size();
  const bool range = shape && date.years >= 1900 && date.years <= 2100 && date.months >= 1 && date.months <= 12 &&
                     date.days >= 1 && date.days <= days_in_month(date.years, date.months) && date.hours >= 0 &&
                     date.hours <= 23 && date.minutes >= 0 && date.minutes <= 59 && date.seconds >= 0 &&
                     date.seconds < 61;
  if (!range)
    throw base::Error(base::Fault::input,
                      "time utc = \"" + utc +
                          "\" is no date and time; write it as \"2012-09-20T15:30:00Z\" (UTC, years "
                          "1900 to 2100)");
  return date;
}

int day_of_year(const ln_date& date) {
  int day = date.days;
  for (int month = 1; month < date.months; ++month) day += days_in_month(date.years, month);
  return day;
}

void check_place(double latitude_deg, double longitude_deg) {
  if (!(latitude_deg >= -90 && latitude_deg <= 90) || !(longitude_deg >= -180 && longitude_deg <= 360))
    throw base::Error(base::Fault::input,
                      "place " + std::to_string(latitude_deg) + ", " + std::to_string(longitude_deg) +
                          " is not on earth; latitude is -90 to 90 (north positive), longitude -180 to "
                          "360 (east positive), degrees");
}

}  // namespace

double azimuth_from_libnova_deg(double libnova_azimuth_deg) {
  const double azimuth = std::fmod(libnova_azimuth_deg + 180.0, 360.0);
  return azimuth < 0 ? azimuth + 360.0 : azimuth;
}

Sun sun_from_time(const std::string& utc, double latitude_deg, double longitude_deg) {
  ln_date date = parse_utc(utc);
  check_place(latitude_deg, longitude_deg);
  const double julian_day = ln_get_julian_day(&date);  // universal time, for the earth's turn
  ln_equ_posn sun{};
  const double ephemeris_day = ln_get_jde(julian_day);  // ephemeris time, for the sun's place
  // libnova 0.16 takes VSOP87 longitudes of the equinox J2000 for those of date (0.014 degrees a year) and scales
  // aberration by 1 / 360. Hence precession here, and the sun as it stood one light time ago, which is what aberration
  // does to it.
  constexpr double kLightTime_day = 0.0057755183;  // 1 AU / c
  ln_equ_posn sun_j2000{};
  ln_get_solar_equ_coords(ephemeris_day - kLightTime_day, &sun_j2000);
  ln_get_equ_prec(&sun_j2000, ephemeris_day, &sun);
  ln_lnlat_posn observer{longitude_deg, latitude_deg};
  ln_hrz_posn horizontal{};
  ln_get_hrz_from_equ_sidereal_time(&sun, &observer, ln_get_apparent_sidereal_time(julian_day), &horizontal);
  Sun result;
  result.zenith_deg = 90.0 - horizontal.alt;
  result.azimuth_deg = azimuth_from_libnova_deg(horizontal.az);
  result.day_of_year = day_of_year(date);
  result.utc = utc;
  return result;
}

Sun moon_from_time(const std::string& utc, double latitude_deg, double longitude_deg) {
  ln_date date = parse_utc(utc);
  check_place(latitude_deg, longitude_deg);
  const double julian_day = ln_get_julian_day(&date), ephemeris_day = ln_get_jde(julian_day);
  ln_equ_posn moon_j2000{}, moon{};  // ELP 2000 as libnova has it counts from the equinox J2000
  ln_get_lunar_equ_coords(ephemeris_day, &moon_j2000);
  ln_get_equ_prec(&moon_j2000, ephemeris_day, &moon);
  ln_lnlat_posn observer{longitude_deg, latitude_deg};
  ln_hrz_posn horizontal{};
  ln_get_hrz_from_equ_sidereal_time(&moon, &observer, ln_get_apparent_sidereal_time(julian_day), &horizontal);
  // Seen from the ground instead of the earth's centre: tan z' = sin z / (cos z - radius / distance).
  constexpr double kEarthRadius_km = 6371.0;
  const double zenith = base::rad_from_deg(90.0 - horizontal.alt),
               near = kEarthRadius_km / ln_get_lunar_earth_dist(ephemeris_day);
  Sun result;
  result.zenith_deg = std::atan2(std::sin(zenith), std::cos(zenith) - near) / base::rad_from_deg(1);
  result.azimuth_deg = azimuth_from_libnova_deg(horizontal.az);
  result.moon_phase_deg = std::abs(ln_get_lunar_phase(ephemeris_day));
  result.day_of_year = day_of_year(date);
  result.utc = utc;
  return result;
}

}  // namespace raycube::scene
