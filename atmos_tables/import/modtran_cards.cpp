#include "atmos_tables/import/modtran_cards.h"

#include <cmath>
#include <iterator>

#include "atmos_tables/import/modtran_sun.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

constexpr int kNoIparm = 9;                  // none of MODTRAN's
constexpr double kEarthRadius_km = 6371.23;  // MODTRAN's, of middle latitudes

/// Card 4: V1, V2, DV, FWHM in F10.0, YFLAG, XFLAG, DLIMIT (8), FLAGS (7).
std::optional<BandRequest> band_of_card_4(std::string_view card) {
  double value[4];
  for (int i = 0; i < 4; ++i) {
    const Number number = read_number(card_field(card, 10 * static_cast<std::size_t>(i), 10));
    if (!number.good()) return std::nullopt;
    value[i] = number.value;
  }
  if (!(value[0] >= 0 && value[1] >= value[0] && value[2] > 0 && value[3] > 0)) return std::nullopt;
  const std::string_view flag = card_field(card, 50, 1);
  const auto unit = axis_unit_from_flag(flag.empty() ? ' ' : flag[0]);
  if (!unit) return std::nullopt;
  return BandRequest{value[0], value[1], *unit, value[2] + value[3]};
}

double number_or_nan(std::string_view field) {
  const Number number = read_number(field);
  return number.good() && number.value != -99 ? number.value : std::nan("");
}

/// BETA where it is given, else that of the straight line from H1 down to H2 (to the ground where no H2 is given).
std::optional<double> earth_centre_angle_deg(const ModtranPath& path) {
  if (!std::isnan(path.beta_deg)) return path.beta_deg;
  if (path.observer_zenith_deg == 180) return 0;
  const double end_km = std::isnan(path.h2_km) ? path.ground_km : path.h2_km;
  if (!(path.observer_zenith_deg > 90) || !(path.h1_km >= end_km)) return std::nullopt;
  const double sine = (kEarthRadius_km + path.h1_km) / (kEarthRadius_km + end_km) *
                      std::sin(base::rad_from_deg(path.observer_zenith_deg));
  if (!(sine <= 1)) return std::nullopt;  // past the horizon
  return base::deg_from_rad(std::asin(sine)) - (180 - path.observer_zenith_deg);
}

/// IPARM 2 and 12: relative to the path, whose azimuth MODTRAN does not ask for then.
void told_sun(const ModtranPath& path, Geometry& out) {
  if (std::isnan(path.parm[0]) || std::isnan(path.parm[1])) return;
  out.sun_zenith_deg = path.parm[1];
  const bool down = path.observer_zenith_deg > 90, at_target = path.iparm == 12;
  if (at_target)
    out.relative_azimuth_deg = folded_azimuth_deg(down ? path.parm[0] : path.parm[0] + 180);
  else
    out.relative_azimuth_deg =
        down ? relative_azimuth_deg_from_modtran(path.parm[0]) : sky_relative_azimuth_deg_from_modtran(path.parm[0]);
}

/// IPARM 0, 1, 10 and 11.
void sun_over_place(const ModtranPath& path, const std::optional<double>& ahead_deg, Geometry& out) {
  const bool by_time = path.iparm % 10 == 1, at_target = path.iparm >= 10, down = path.observer_zenith_deg > 90;
  if ((path.iparm % 10 > 1) || std::isnan(path.parm[0]) || std::isnan(path.parm[1])) return;
  const bool time = path.day_of_year >= 1 && path.day_of_year <= 366 && path.time_h >= 0 && path.time_h <= 24;
  if (by_time ? !time : std::isnan(path.parm[2]) || std::isnan(path.parm[3])) return;
  const EarthPoint subsolar =
      by_time ? modtran_subsolar_point(path.day_of_year, path.time_h) : EarthPoint{path.parm[2], path.parm[3]};
  EarthPoint place{path.parm[0], path.parm[1]};
  const double azimuth = std::isnan(path.path_azimuth_deg) ? 0 : path.path_azimuth_deg;
  double towards_sensor = azimuth;
  if (down && !at_target) {
    if (!ahead_deg) return;
    const ArcEnd end = along_great_circle(place, azimuth, *ahead_deg);
    place = end.point, towards_sensor = end.azimuth_back_deg;
  }
  if (!down && at_target) return;  // where a path up ends does not matter, and where it begins is not said
  const SunAngles sun = sun_seen_from(place, subsolar);
  out.sun_zenith_deg = sun.zenith_deg, out.sun_azimuth_deg = sun.azimuth_deg;
  if (!std::isnan(path.path_azimuth_deg))
    out.relative_azimuth_deg = folded_azimuth_deg(towards_sensor - sun.azimuth_deg);
}

}  // namespace

Geometry geometry_from_modtran(const ModtranPath& path) {
  Geometry out;
  const auto km = [](double x) { return std::isnan(x) ? std::nullopt : std::optional<double>(m_from_km(x)); };
  out.sensor_height_m = km(path.h1_km);
  out.path_end_height_m = km(path.h2_km);
  out.path_length_m = km(path.range_km);
  out.ground_height_m = km(path.ground_km);
  if (path.day_of_year > 0) out.day_of_year = path.day_of_year;
  if (std::isnan(path.observer_zenith_deg)) return out;
  out.sight_zenith_deg = path.observer_zenith_deg;
  const auto ahead = earth_centre_angle_deg(path);
  if (path.observer_zenith_deg > 90 && ahead)
    out.view_zenith_deg = view_zenith_deg_from_modtran(path.observer_zenith_deg, *ahead);
  if (path.iparm % 10 == 2)
    told_sun(path, out);
  else
    sun_over_place(path, ahead, out);
  return out;
}

ModtranCards read_modtran_cards(const std::vector<std::string>& echo) {
  ModtranCards out;
  if (echo.empty()) return out;
  // Card 1: MODEL in columns 3 to 5 or 5, ITYPE 7 to 10, IEMSCT 11 to 15 in every version.
  const Number mode = read_number(card_field(echo.front(), 10, 5));
  if (mode.good()) out.iemsct = whole_number(mode.value, 0, 4);
  // Card 4 is the last but one, before the surface card; card 3, 3A1 and 3A2 stand above it.
  for (std::size_t back = 1; back <= 4 && back <= echo.size() && !out.band; ++back) {
    const std::size_t i = echo.size() - back;
    out.band = band_of_card_4(echo[i]);
    if (!out.band || i < 3) continue;
    const auto card_3 = [&](std::size_t field) { return number_or_nan(card_field(echo[i - 3], 10 * field, 10)); };
    const auto parm = [&](std::size_t field) { return number_or_nan(card_field(echo[i - 1], 10 * field, 10)); };
    const Number iparm = read_number(card_field(echo[i - 2], 0, 5));
    const Number day = read_number(card_field(echo[i - 2], 10, 5));
    ModtranPath path{card_3(0), card_3(1), card_3(2), card_3(3), card_3(4)};
    // Cards 3A1 and 3A2 are of runs with sunlight alone.
    const bool sunlit = !out.iemsct || *out.iemsct == 2 || *out.iemsct == 4;
    path.iparm = sunlit && iparm.good() ? whole_number(iparm.value, 0, 99).value_or(kNoIparm) : kNoIparm;
    for (std::size_t field = 0; field < std::size(path.parm); ++field) path.parm[field] = parm(field);
    path.day_of_year = day.good() ? whole_number(day.value, 1, 366).value_or(0) : 0;
    path.time_h = parm(4), path.path_azimuth_deg = parm(5);
    out.geometry = geometry_from_modtran(path);
  }
  return out;
}

}  // namespace raycube::atmos::imported
