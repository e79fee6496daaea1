#include "atmos_tables/import/modtran_cards.h"

#include <cmath>

#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

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

}  // namespace

Geometry geometry_from_modtran(const ModtranPath& path) {
  Geometry out;
  const auto km = [](double x) { return std::isnan(x) ? std::nullopt : std::optional<double>(m_from_km(x)); };
  out.sensor_height_m = km(path.h1_km);
  out.path_end_height_m = km(path.h2_km);
  out.path_length_m = km(path.range_km);
  if (std::isnan(path.observer_zenith_deg)) return out;
  out.sight_zenith_deg = path.observer_zenith_deg;
  const bool down = path.observer_zenith_deg > 90;
  if (down && !std::isnan(path.beta_deg))
    out.view_zenith_deg = view_zenith_deg_from_modtran(path.observer_zenith_deg, path.beta_deg);
  if (path.iparm == 2 && !std::isnan(path.parm1) && !std::isnan(path.parm2)) {
    out.sun_zenith_deg = path.parm2;
    out.relative_azimuth_deg =
        down ? relative_azimuth_deg_from_modtran(path.parm1) : sky_relative_azimuth_deg_from_modtran(path.parm1);
  }
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
    out.geometry =
        geometry_from_modtran({card_3(0), card_3(1), card_3(2), card_3(3), card_3(4),
                               iparm.good() ? whole_number(iparm.value, 0, 99).value_or(0) : 0, parm(0), parm(1)});
  }
  return out;
}

}  // namespace raycube::atmos::imported
