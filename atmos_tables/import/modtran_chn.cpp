#include "atmos_tables/import/modtran_chn.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/base/text.h"
#include "atmos_tables/import/modtran_names.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

enum class ChannelKind { axis, ratio, kelvin, length_nm, radiance, irradiance, density_nm, unused };

struct ChannelColumn {
  const char *label, *name;
  ChannelKind kind;
};

/// The 26 numeric columns in order.
constexpr ChannelColumn kColumns[] = {
    {"1ST SPECTRAL MOMENT", "", ChannelKind::axis},
    {"LOS NO.", "", ChannelKind::unused},
    {"CHANNEL NO.", "", ChannelKind::unused},
    {"SPECTRAL RADIANCE (PER CM-1)", "", ChannelKind::unused},
    {"SPECTRAL RADIANCE (PER NM)", "channel_radiance", ChannelKind::density_nm},
    {"BRIGHTNESS TEMP", "brightness_temperature", ChannelKind::kelvin},
    {"CHANNEL RADIANCE", "radiance", ChannelKind::radiance},
    {"EQUIVALENT WIDTH (CM-1)", "", ChannelKind::unused},
    {"EQUIVALENT WIDTH (NM)", "channel_width", ChannelKind::length_nm},
    {"SPECTRAL MINIMUM", "channel_first", ChannelKind::length_nm},
    {"SPECTRAL MAXIMUM", "channel_last", ChannelKind::length_nm},
    {"THERMAL EMISSION", "path_radiance_thermal_emitted", ChannelKind::radiance},
    {"THERMAL SCATTER", "path_radiance_thermal_scattered", ChannelKind::radiance},
    {"SURFACE EMISSION", "surface_emission", ChannelKind::radiance},
    {"PATH MULTIPLE SCAT SOLAR", "path_radiance_solar_multiple", ChannelKind::radiance},
    {"PATH SINGLE SCAT SOLAR", "path_radiance_solar_single", ChannelKind::radiance},
    {"TOTAL TRANSM GRND REFLECT", "ground_reflected", ChannelKind::radiance},
    {"DIRECT TRANSM GRND REFLECT", "ground_reflected_direct", ChannelKind::radiance},
    {"COSSUN TIMES TOA_SUN / PI", "solar_irradiance_cos_over_pi", ChannelKind::irradiance},
    {"TRANSM SOLAR LOS+SUN PATH", "solar_irradiance_sun_ground_sensor", ChannelKind::irradiance},
    {"TRANSM SOLAR TO SENSOR", "solar_irradiance_at_sensor", ChannelKind::irradiance},
    {"A, DIRECT REFLECTANCE COEFFICIENT", "coefficient_a", ChannelKind::ratio},
    {"B, DIFFUSE REFLECTANCE COEFFICIENT", "coefficient_b", ChannelKind::ratio},
    {"SPHERICAL ALBEDO AT GROUND", "spherical_albedo", ChannelKind::ratio},
    {"SENSOR PATH TRANSM", "transmittance", ChannelKind::ratio},
    {"SURFACE DIRECTIONAL EMISSIVITY", "surface_emissivity", ChannelKind::ratio},
};
constexpr std::size_t kCount = std::size(kColumns);
constexpr std::size_t kWidth = 8;  // EQUIVALENT WIDTH (NM)
/// Ratios of channel integrals are ratios of single-precision sums over hundreds of terms: 1.0000046 is seen where 1 is
/// meant.
constexpr double kSinglePrecision = 1e-5;

std::string unit_of(ChannelKind kind) {
  switch (kind) {
    case ChannelKind::ratio:
      return "1";
    case ChannelKind::kelvin:
      return "K";
    case ChannelKind::length_nm:
      return "um";
    case ChannelKind::irradiance:
      return "W m-2 um-1";
    default:
      return "W m-2 sr-1 um-1";
  }
}

/// Where each group of dashes ends.
std::vector<std::size_t> dash_ends(const std::string& line) {
  std::vector<std::size_t> ends;
  for (std::size_t i = 0; i < line.size(); ++i)
    if (line[i] == '-' && (i + 1 == line.size() || line[i + 1] != '-')) ends.push_back(i + 1);
  return ends;
}

/// A number between two words of the description.
Number described(const std::string& text, const std::string& word) {
  const std::size_t at = text.find(word);
  if (at == std::string::npos) return {};
  const auto tokens = split_blanks(std::string_view(text).substr(at + word.size()));
  return tokens.size() > 1 && tokens[1] == "NM" ? read_number(tokens[0]) : Number{Number::State::malformed, 0, 0};
}

struct Channels {
  Run run;
  std::vector<int> lines;
  int last_channel = 0;
  std::vector<double> center_um, fwhm_um;
};

void start(Run& run) {
  run.mode = "channels";
  for (const auto& c : kColumns) {
    Column column;
    column.name = c.name, column.source = c.label, column.unit = unit_of(c.kind);
    if (*c.name) run.columns.push_back(std::move(column));
  }
}

void add_row(Channels& channels, const std::vector<Number>& row) {
  const Number& width = row[kWidth];
  channels.run.wavelength_um.push_back(base::um_from_nm(row[0].value));
  std::size_t next = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (!*kColumns[i].name) continue;
    Column& column = channels.run.columns[next++];
    double value = row[i].value, rounding = row[i].rounding;
    switch (kColumns[i].kind) {
      case ChannelKind::length_nm:
        value = base::um_from_nm(value), rounding = base::um_from_nm(rounding);
        break;
      case ChannelKind::density_nm:
        value *= 1e7, rounding *= 1e7;
        break;
      case ChannelKind::radiance:
      case ChannelKind::irradiance:
        // The width's own digits blur every integral alike, so they are left out of the rounding of sums.
        value = W_per_m2_um_from_W_per_cm2_axis(value / width.value, AxisUnit::nm, 0);
        rounding = W_per_m2_um_from_W_per_cm2_axis(rounding / width.value, AxisUnit::nm, 0);
        break;
      default:
        break;
    }
    column.values.push_back(value);
    column.rounding.push_back(rounding);
  }
}

}  // namespace

Imported read_chn(const std::string& path) {
  const auto lines = read_lines(path);
  base::Problems problems;
  const auto here = [&](std::size_t index) { return base::Where{path, static_cast<int>(index) + 1, 0, ""}; };
  std::size_t at = 0;
  while (at < lines.size() && (trimmed(lines[at]).empty() || lines[at].find_first_not_of("- ") != std::string::npos))
    ++at;
  const auto ends = at < lines.size() ? dash_ends(lines[at]) : std::vector<std::size_t>();
  if (ends.size() < kCount || at < 2) {
    problems.add({path, 0, 0, ""}, "no header of channel output",
                 base::counted(ends.size(), "column") + " of dashes, 26 needed", "is it a .chn file of MODTRAN 6?");
    problems.throw_if_any();
  }
  std::string header;
  for (std::size_t i = 0; i < at; ++i) header += lines[i] + "\n";
  if (header.find("1ST SPECTRAL") == std::string::npos || header.find("(NANOMETERS)") == std::string::npos)
    problems.add(here(at), "the header does not name 1ST SPECTRAL MOMENT in NANOMETERS",
                 std::string(trimmed(lines[at - 1])).substr(0, 40), "only channels in nm are known");
  problems.throw_if_any();

  std::map<int, Channels> by_sight;
  for (++at; at < lines.size() && problems.count() < kEnoughProblems; ++at) {
    const std::string& line = lines[at];
    if (trimmed(line).empty()) continue;
    std::vector<Number> row;
    std::size_t from = 0, before = problems.count();
    for (std::size_t i = 0; i < kCount; ++i) {
      const std::string_view text = card_field(line, from, ends[i] - from);
      if (!trimmed(text).empty() && (text.size() < ends[i] - from || text.back() == ' ')) {
        problems.add(here(at),
                     std::string("the number under ") + kColumns[i].label + " does not end where its column ends",
                     std::string(trimmed(text)), "the columns have moved or the row is cut short");
        break;
      }
      row.push_back(need_number(text, here(at), kColumns[i].label, problems));
      from = ends[i];
    }
    if (problems.count() != before) continue;
    if (!(row[kWidth].value > 0) || !(row[0].value > 0)) {
      problems.add(here(at), "moment and equivalent width must be above 0",
                   std::to_string(row[0].value) + ", " + std::to_string(row[kWidth].value), "");
      continue;
    }
    const auto sight = whole_number(row[1].value, 0, kMostNumbered),
               channel = whole_number(row[2].value, 0, kMostNumbered);
    if (!sight || !channel) {
      problems.add(here(at), "line of sight and channel must be whole numbers",
                   std::to_string(row[1].value) + ", " + std::to_string(row[2].value), "the columns have moved");
      continue;
    }
    Channels& channels = by_sight[*sight];
    if (channels.lines.empty()) start(channels.run);
    if (*channel != channels.last_channel + 1)
      problems.add(here(at), "channels do not follow each other",
                   std::to_string(*channel) + " after " + std::to_string(channels.last_channel),
                   "rows are missing or out of order");
    channels.last_channel = *channel;
    const std::string description = from < line.size() ? line.substr(from) : "";
    if (description.find("CENTER:") != std::string::npos) {
      const Number center = described(description, "CENTER:"), fwhm = described(description, "FWHM:");
      if (!center.good() || !fwhm.good())
        problems.add(here(at), "the description is cut short", std::string(trimmed(description)),
                     "the file is cut short");
      channels.center_um.push_back(base::um_from_nm(center.value));
      channels.fwhm_um.push_back(base::um_from_nm(fwhm.value));
    }
    channels.lines.push_back(static_cast<int>(at) + 1);
    add_row(channels, row);
  }
  if (by_sight.empty() && problems.empty())
    problems.add({path, 0, 0, ""}, "no channels below the header", "", "the file is cut short");
  Imported out{path, "MODTRAN", "chn", {}};
  for (auto& [sight, channels] : by_sight) {
    if (!problems.empty()) break;
    const std::size_t rows = channels.run.wavelength_um.size();
    if (sight != by_sight.begin()->first && rows != out.runs.front().wavelength_um.size())
      problems.add({path, channels.lines.back(), 0, ""}, "lines of sight have different numbers of channels",
                   std::to_string(rows), "the file is cut short");
    const auto described_column = [&run = channels.run, rows](const char* name, const char* source,
                                                              const std::vector<double>& values) {
      if (values.size() == rows)
        run.columns.push_back({name, "um", source, {}, values, std::vector<double>(rows, 5e-6)});
    };
    described_column("channel_center", "CENTER", channels.center_um);
    described_column("channel_fwhm", "FWHM", channels.fwhm_um);
    settle_radiance(channels.run, {path, 0, 0, ""}, channels.lines, problems);
    check_run(channels.run, {path, channels.lines.front(), 0, ""}, problems, kSinglePrecision);
    if (by_sight.size() > 1) channels.run.notes.push_back("line of sight " + std::to_string(sight));
    out.runs.push_back(std::move(channels.run));
  }
  problems.throw_if_any();
  return out;
}

std::vector<double> sun_ground_sensor_transmittance(const Run& channels, double sun_zenith_deg) {
  const double cosine = std::cos(base::rad_from_deg(sun_zenith_deg));
  if (!(cosine > 0))
    throw base::Error(base::Fault::input,
                      "sun zenith " + std::to_string(sun_zenith_deg) + " deg: the sun must stand above the horizon");
  const Column &transmitted = channels.at("solar_irradiance_sun_ground_sensor"),
               &above = channels.at("solar_irradiance_cos_over_pi");
  std::vector<double> out;
  for (std::size_t i = 0; i < transmitted.values.size(); ++i) {
    if (!(above.values[i] > 0))
      throw base::Error(base::Fault::input, "channel " + std::to_string(i + 1) +
                                                " has no sun above the air; its transmittance is not defined");
    out.push_back(transmitted.values[i] / (above.values[i] * std::numbers::pi / cosine));
  }
  return out;
}

}  // namespace raycube::atmos::imported
