#include "atmos_tables/import/modtran_sun.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "atmos_tables/import/conversions.h"
#include "host/base/units.h"

namespace raycube::atmos::imported {

namespace {

struct AlmanacDay {
  int day;
  double declination_deg, equation_of_time_min;
};

constexpr AlmanacDay kAlmanac[] = {
    {1, -23.07, -3.23},  {9, -22.22, -6.83},   {21, -20.08, -11.17}, {32, -17.32, -13.57}, {44, -13.62, -14.33},
    {60, -7.88, -12.63}, {91, 4.23, -4.2},     {121, 14.83, 2.83},   {141, 20.03, 3.57},   {152, 21.95, 2.45},
    {160, 22.87, 1.10},  {172, 23.45, -1.42},  {182, 23.17, -3.52},  {190, 22.47, -4.93},  {202, 20.63, -6.25},
    {213, 18.23, -6.28}, {244, 8.58, -0.25},   {274, -2.88, 10.02},  {305, -14.18, 16.35}, {309, -15.45, 16.38},
    {325, -19.75, 14.3}, {335, -21.68, 11.27}, {343, -22.75, 8.02},  {355, -23.43, 2.32},  {366, -23.07, -3.23}};

/// Azimuth from `from` towards `to`; 0 where both are one point.
double azimuth_towards(const EarthPoint& from, const EarthPoint& to) {
  const double p = base::rad_from_deg(from.latitude_deg), s = base::rad_from_deg(to.latitude_deg),
               east = base::rad_from_deg(from.longitude_west_deg - to.longitude_west_deg);
  const double y = std::sin(east) * std::cos(s),
               x = std::cos(p) * std::sin(s) - std::sin(p) * std::cos(s) * std::cos(east);
  return std::hypot(x, y) < 1e-9 ? 0 : azimuth_deg_0_to_360(base::deg_from_rad(std::atan2(y, x)));
}

}  // namespace

EarthPoint modtran_subsolar_point(int day_of_year, double time_h) {
  const auto* after = std::upper_bound(std::begin(kAlmanac), std::end(kAlmanac) - 1, day_of_year,
                                       [](int day, const AlmanacDay& known) { return day < known.day; });
  const AlmanacDay &a = *(after - 1), &b = *after;
  const double share = static_cast<double>(day_of_year - a.day) / (b.day - a.day);
  const double minutes = a.equation_of_time_min + share * (b.equation_of_time_min - a.equation_of_time_min);
  return {a.declination_deg + share * (b.declination_deg - a.declination_deg),
          azimuth_deg_0_to_360(15 * (time_h + minutes / 60) - 180)};
}

SunAngles sun_seen_from(const EarthPoint& place, const EarthPoint& subsolar) {
  const double p = base::rad_from_deg(place.latitude_deg), s = base::rad_from_deg(subsolar.latitude_deg),
               dl = base::rad_from_deg(place.longitude_west_deg - subsolar.longitude_west_deg);
  const double cosine = std::sin(p) * std::sin(s) + std::cos(p) * std::cos(s) * std::cos(dl);
  return {base::deg_from_rad(std::acos(std::clamp(cosine, -1.0, 1.0))), azimuth_towards(place, subsolar)};
}

ArcEnd along_great_circle(const EarthPoint& from, double azimuth_deg, double arc_deg) {
  const double p = base::rad_from_deg(from.latitude_deg), a = base::rad_from_deg(azimuth_deg),
               d = base::rad_from_deg(arc_deg);
  const double sine = std::sin(p) * std::cos(d) + std::cos(p) * std::sin(d) * std::cos(a);
  const double latitude = std::asin(std::clamp(sine, -1.0, 1.0));
  const double east = std::atan2(std::sin(a) * std::sin(d) * std::cos(p), std::cos(d) - std::sin(p) * sine);
  const EarthPoint end{base::deg_from_rad(latitude),
                       azimuth_deg_0_to_360(from.longitude_west_deg - base::deg_from_rad(east))};
  return {end, arc_deg > 0 ? azimuth_towards(end, from) : azimuth_deg_0_to_360(azimuth_deg + 180)};
}

}  // namespace raycube::atmos::imported
