#include "scene_compiler/solar_file.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"

namespace raycube::scene {
namespace {

using base::Problems;

struct Unit {
  const char *ending, *words;  ///< of a column's name, and in a comment
  double factor;               ///< to um, or to W m-2 um-1
};
constexpr Unit kLengths[] = {{"_nm", "wavelength in nm", 1e-3}, {"_um", "wavelength in um", 1}};
// mW first: its words hold W's.
constexpr Unit kIrradiances[] = {
    {"_mW_m2_nm", "mW m-2 nm-1", 1}, {"_W_m2_nm", "W m-2 nm-1", 1e3}, {"_W_m2_um", "W m-2 um-1", 1}};

struct FoundColumn {
  std::size_t column;
  double factor;
};

/// The column that is called `name` with a unit's ending, or `name` alone with a unit in the comments.
template <std::size_t N>
std::optional<FoundColumn> unit_column(const CsvFile& csv, const std::string& name, const Unit (&units)[N]) {
  for (const Unit& unit : units)
    if (const auto found = csv.column(name + unit.ending)) return FoundColumn{*found, unit.factor};
  const auto bare = csv.column(name);
  if (!bare) return std::nullopt;
  for (const Unit& unit : units)
    for (const auto& [key, text] : csv.comments) {
      const std::string whole = key + ": " + text;
      const std::size_t at = whole.find(unit.words);  // kW holds W
      if (at != std::string::npos && (at == 0 || std::isalpha(static_cast<unsigned char>(whole[at - 1])) == 0))
        return FoundColumn{*bare, unit.factor};
    }
  return std::nullopt;
}

constexpr std::size_t kReportedRows = 20;

}  // namespace

std::optional<SolarSpectrumSpec> read_solar_spectrum(const std::string& file, const base::Where& asked_by,
                                                     Problems& problems) {
  const auto csv = read_csv(file, asked_by, problems);
  if (!csv) return std::nullopt;
  const auto wavelength = unit_column(*csv, "wavelength", kLengths);
  auto irradiance = unit_column(*csv, "irradiance", kIrradiances);
  if (!irradiance) irradiance = unit_column(*csv, "extraterrestrial", kIrradiances);
  if (!wavelength || !irradiance) {
    problems.add({csv->file, csv->header_line, 0, ""},
                 "a solar spectrum needs a wavelength and an irradiance whose names hold their units: wavelength_nm or "
                 "wavelength_um; irradiance_W_m2_um, irradiance_W_m2_nm or irradiance_mW_m2_nm",
                 csv->columns_text(), "name the columns so");
    return std::nullopt;
  }
  SolarSpectrumSpec out;
  out.name = csv->file;
  const std::size_t before = problems.count();
  for (std::size_t row = 0; row < csv->rows.size() && problems.count() < before + kReportedRows; ++row) {
    const auto x = csv->number(row, wavelength->column, problems), y = csv->number(row, irradiance->column, problems);
    if (!x || !y) continue;
    const double um = *x * wavelength->factor;
    if (!(um >= 0.01 && um <= 1e4))
      problems.add(csv->at(row, wavelength->column), "wavelength outside 0.01 to 10000 um", number_text(*x),
                   "check the column's unit");
    if (!out.wavelength_um.empty() && !(um > out.wavelength_um.back()))
      problems.add(csv->at(row, wavelength->column), "wavelengths must ascend",
                   number_text(um) + " after " + number_text(out.wavelength_um.back()) + " um", "sort the rows");
    if (!(*y >= 0 && *y * irradiance->factor <= 1e4))
      problems.add(csv->at(row, irradiance->column), "irradiance must lie in 0 to 10000 W m-2 um-1",
                   number_text(*y * irradiance->factor), "check the value and the column's unit");
    out.wavelength_um.push_back(um), out.irradiance.push_back(*y * irradiance->factor);
  }
  if (out.wavelength_um.size() < 2 && problems.count() == before)
    problems.add({csv->file, 0, 0, ""}, "a solar spectrum needs two rows", std::to_string(out.wavelength_um.size()),
                 "give a range of wavelengths");
  if (problems.count() > before) return std::nullopt;
  if (std::all_of(out.irradiance.begin(), out.irradiance.end(), [](double value) { return value == 0; })) {
    problems.add({csv->file, 0, 0, ""}, "a solar spectrum needs light", "0 in every row", "check the column");
    return std::nullopt;
  }
  return out;
}

}  // namespace raycube::scene
