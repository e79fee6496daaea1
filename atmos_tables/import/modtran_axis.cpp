#include "atmos_tables/import/modtran_axis.h"

#include <algorithm>
#include <sstream>
#include <vector>

#include "atmos_tables/import/modtran_names.h"

namespace raycube::atmos::imported {

namespace {

/// The units a label allows, the likeliest first.
std::vector<AxisUnit> allowed_units(const std::string& label, const std::optional<BandRequest>& band) {
  const std::string key = label_key(label);
  const auto holds = [&](const char* word) { return key.find(word) != std::string::npos; };
  if (holds("CM_1") || holds("WAVENUM")) return {AxisUnit::per_cm};
  if (holds("NANOM") || holds("NM")) return {AxisUnit::nm};
  if (holds("MICRO") || holds("MCRN") || holds("UM")) return {AxisUnit::um};
  if (holds("WAVLEN") || holds("WAVELEN")) return {AxisUnit::um, AxisUnit::nm};
  if (!band) return {AxisUnit::per_cm};
  // FREQ heads the column whatever it counts in.
  std::vector<AxisUnit> units{band->unit};
  for (const AxisUnit unit : {AxisUnit::per_cm, AxisUnit::um, AxisUnit::nm})
    if (unit != band->unit) units.push_back(unit);
  return units;
}

bool lies_in(double first, double last, AxisUnit unit, const BandRequest& band) {
  const auto wave = [](double value, AxisUnit from) { return wavelength_um_from_axis(std::max(value, 1e-30), from); };
  const double low = band.first - band.slack, high = band.last + band.slack;
  const double from = std::min(wave(low, band.unit), wave(high, band.unit)),
               to = std::max(wave(low, band.unit), wave(high, band.unit));
  const double a = wave(first, unit), b = wave(last, unit);
  constexpr double kDigits = 1e-4;  // axis values are printed to 0.01 cm-1 or to 6 digits
  return std::min(a, b) >= from * (1 - kDigits) && std::max(a, b) <= to * (1 + kDigits);
}

}  // namespace

std::optional<AxisUnit> axis_unit_from_flag(char flag) {
  switch (flag) {
    case ' ':
    case 'W':
    case 'w':
      return AxisUnit::per_cm;
    case 'M':
    case 'm':
      return AxisUnit::um;
    case 'N':
    case 'n':
      return AxisUnit::nm;
    default:
      return std::nullopt;
  }
}

std::optional<AxisUnit> settle_axis(const std::string& label, double first, double last,
                                    const std::optional<BandRequest>& band, const base::Where& where,
                                    base::Problems& problems) {
  const auto units = allowed_units(label, band);
  if (!band) {
    if (units.size() == 1) return units.front();
    problems.add(where, "the axis \"" + label + "\" may count in um or nm and no card says which", "",
                 "keep the header of the run in the file");
    return std::nullopt;
  }
  for (const AxisUnit unit : units)
    if (lies_in(first, last, unit, *band)) return unit;
  std::ostringstream found, asked;
  found << first << " to " << last << " under \"" << label << "\"";
  asked << band->first << " to " << band->last << " " << axis_unit_name(band->unit);
  problems.add(where, "the axis does not lie in the band that was asked for, " + asked.str(), found.str(),
               "the columns have moved, or header and data are of two runs");
  return std::nullopt;
}

}  // namespace raycube::atmos::imported
