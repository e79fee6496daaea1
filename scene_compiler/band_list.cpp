#include "scene_compiler/band_list.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "host/base/text.h"
#include "scene_compiler/air_wavelength.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::scene {
namespace {

using base::Problems;
using base::Where;

double um_of(double value, bool air) { return air ? vacuum_from_air_um(value) : value; }

/// Index and unit of the column `stem`_nm or `stem`_um.
struct UnitColumn {
  std::size_t index = 0;
  double unit_um = 0;  ///< 0: absent
};
UnitColumn unit_column(const CsvFile& csv, const std::string& stem) {
  if (const auto found = csv.column(stem + "_nm")) return {*found, 1e-3};
  if (const auto found = csv.column(stem + "_um")) return {*found, 1.0};
  return {};
}

bool plausible(double um, const Where& where, Problems& problems) {
  if (um >= 0.05 && um <= 1000.0) return true;
  problems.add(where, "wavelength outside 0.05 .. 1000 um", number_text(um) + " um",
               "check the unit in the column's name");
  return false;
}

std::vector<Band> gaussian_bands(const CsvFile& csv, const UnitColumn& center, bool air, Problems& problems) {
  const UnitColumn fwhm = unit_column(csv, "fwhm");
  if (fwhm.unit_um == 0) {
    problems.add({csv.file, csv.header_line, 0, ""}, "no column fwhm_nm or fwhm_um", csv.columns_text(),
                 "give each band's full width at half maximum");
    return {};
  }
  const auto name = csv.column("name");
  std::set<std::string> names;
  std::vector<Band> bands;
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    const auto c = csv.number(row, center.index, problems), w = csv.number(row, fwhm.index, problems);
    if (!c || !w) continue;
    const bool center_ok = plausible(*c * center.unit_um, csv.at(row, center.index), problems);
    if (!(*w > 0))
      problems.add(csv.at(row, fwhm.index), "band width must be above 0", csv.rows[row][fwhm.index],
                   "give the band's FWHM, or remove the line");
    if (!center_ok || !(*w > 0)) continue;
    Band band;
    band.center_um = um_of(*c * center.unit_um, air);
    band.fwhm_um = *w * fwhm.unit_um;
    if (name) band.name = csv.rows[row][*name];
    if (!band.name.empty() && !names.emplace(band.name).second)
      problems.add(csv.at(row, *name), "two bands have one name", "'" + band.name + "'", "name each once");
    bands.push_back(std::move(band));
  }
  return bands;
}

/// Appends one sample; reports what is wrong with it.
void add_sample(Band& band, double um, double response, bool air, const Where& where, Problems& problems) {
  if (!plausible(um, where, problems)) return;
  um = um_of(um, air);
  if (!band.wavelength_um.empty() && um <= band.wavelength_um.back()) {
    problems.add(where, "wavelengths of band '" + band.name + "' are not ascending",
                 number_text(um) + " um after " + number_text(band.wavelength_um.back()) + " um",
                 "sort the file by wavelength");
    return;
  }
  if (!(response >= 0)) {
    problems.add(where, "response of band '" + band.name + "' is negative", number_text(response),
                 "give a response >= 0");
    return;
  }
  band.wavelength_um.push_back(um);
  band.response.push_back(response);
}

/// Centre = response-weighted mean by the trapezoidal rule; drops nothing. False when the response has no
/// area.
bool finish_tabulated(Band& band, const Where& where, Problems& problems) {
  double area = 0, moment = 0;
  for (std::size_t i = 1; i < band.wavelength_um.size(); ++i) {
    const double a = band.wavelength_um[i - 1], b = band.wavelength_um[i];
    const double ra = band.response[i - 1], rb = band.response[i];
    area += 0.5 * (b - a) * (ra + rb);
    moment += (b - a) * (ra * (2 * a + b) + rb * (a + 2 * b)) / 6.0;  // exact for a linear response
  }
  if (!(area > 0)) {
    problems.add(where, "band '" + band.name + "' has no response",
                 base::counted(band.wavelength_um.size(), "sample") + ", area " + number_text(area),
                 "give at least two wavelengths and a response above 0");
    return false;
  }
  band.center_um = moment / area;
  return true;
}

/// Cuts runs of zeros at both ends, keeping one zero as the foot of the response.
void trim_zeros(Band& band) {
  std::size_t first = 0, last = band.response.size();
  while (first + 2 < last && band.response[first] == 0 && band.response[first + 1] == 0) ++first;
  while (last > first + 2 && band.response[last - 1] == 0 && band.response[last - 2] == 0) --last;
  const auto cut = [&](std::vector<double>& v) {
    v = std::vector<double>(v.begin() + static_cast<long>(first), v.begin() + static_cast<long>(last));
  };
  cut(band.wavelength_um);
  cut(band.response);
}

std::vector<Band> wide_table(const CsvFile& csv, const UnitColumn& wavelength, bool air, Problems& problems) {
  std::vector<Band> bands;
  for (std::size_t column = 0; column < csv.columns.size(); ++column) {
    if (column == wavelength.index) continue;
    Band band;
    band.name = csv.columns[column];
    for (std::size_t row = 0; row < csv.rows.size(); ++row) {
      const auto w = csv.number(row, wavelength.index, problems), r = csv.number(row, column, problems);
      if (w && r) add_sample(band, *w * wavelength.unit_um, *r, air, csv.at(row, column), problems);
    }
    if (!finish_tabulated(band, {csv.file, csv.header_line, 0, ""}, problems)) continue;
    trim_zeros(band);
    bands.push_back(std::move(band));
  }
  return bands;
}

std::vector<Band> long_table(const CsvFile& csv, const UnitColumn& wavelength, std::size_t name, std::size_t response,
                             bool air, Problems& problems) {
  std::vector<Band> bands;
  for (std::size_t row = 0; row < csv.rows.size(); ++row) {
    const std::string& band_name = csv.rows[row][name];
    auto band = std::find_if(bands.begin(), bands.end(), [&](const Band& b) { return b.name == band_name; });
    if (band == bands.end()) {
      bands.emplace_back().name = band_name;
      band = bands.end() - 1;
    }
    const auto w = csv.number(row, wavelength.index, problems), r = csv.number(row, response, problems);
    if (w && r) add_sample(*band, *w * wavelength.unit_um, *r, air, csv.at(row, wavelength.index), problems);
  }
  std::erase_if(bands, [&](Band& band) { return !finish_tabulated(band, {csv.file, 0, 0, ""}, problems); });
  for (Band& band : bands) trim_zeros(band);
  return bands;
}

}  // namespace

std::vector<Band> read_band_file(const std::string& file, const std::string& medium, const Where& asked_by,
                                 Problems& problems) {
  const auto csv = read_csv(file, asked_by, problems);
  if (!csv) return {};
  std::string says = medium;
  if (const auto found = csv->comments.find("medium"); says.empty() && found != csv->comments.end())
    says = lower_case(found->second);
  if (!says.empty() && says != "air" && says != "vacuum")
    problems.add({file, 0, 0, ""}, "unknown medium", says, "write # medium: air or # medium: vacuum");
  const bool air = says == "air";
  if (const auto center = unit_column(*csv, "center"); center.unit_um != 0)
    return gaussian_bands(*csv, center, air, problems);
  const auto wavelength = unit_column(*csv, "wavelength");
  if (wavelength.unit_um == 0 || csv->columns.size() < 2) {
    problems.add({file, csv->header_line, 0, ""}, "neither a center_nm nor a wavelength_nm column (or _um)",
                 csv->columns_text(), "see [instrument.bands] in docs/scene_format.md");
    return {};
  }
  const auto name = csv->column("band"), response = csv->column("response");
  if (name && response) return long_table(*csv, wavelength, *name, *response, air, problems);
  return wide_table(*csv, wavelength, air, problems);
}

std::vector<Band> regular_bands(double first_nm, double step_nm, int count, double fwhm_nm, const std::string& medium) {
  std::vector<Band> bands(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    bands[static_cast<std::size_t>(i)].center_um = um_of((first_nm + i * step_nm) * 1e-3, medium == "air");
    bands[static_cast<std::size_t>(i)].fwhm_um = fwhm_nm * 1e-3;
  }
  return bands;
}

bool sort_bands(std::vector<Band>& bands) {
  const auto before = [](const Band& a, const Band& b) { return a.center_um < b.center_um; };
  if (std::is_sorted(bands.begin(), bands.end(), before)) return false;
  std::stable_sort(bands.begin(), bands.end(), before);
  return true;
}

}  // namespace raycube::scene
