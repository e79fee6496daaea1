#include "scene_compiler/index_file.h"

#include <utility>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::scene {

namespace {

constexpr double kShortest_um = 0.05, kLongest_um = 1000, kLargest = 1000;
constexpr std::size_t kMostReports = 20;

struct IndexColumns {
  std::size_t wavelength, n;
  std::optional<std::size_t> k;
  double unit_um;
};

std::optional<IndexColumns> columns_of(const CsvFile& csv, base::Problems& problems) {
  std::optional<std::pair<std::size_t, double>> wavelength;
  for (std::size_t i = 0; i < csv.columns.size() && !wavelength; ++i)
    if (const auto unit = wavelength_unit_um(csv.columns[i])) wavelength = {i, *unit};
  const auto n = csv.column("n");
  const base::Where header{csv.file, csv.header_line, 0, ""};
  if (!wavelength)
    problems.add(header, "no wavelength column", csv.columns_text(), "name one wavelength_nm or wavelength_um");
  if (!n)
    problems.add(header, "no column 'n'", csv.columns_text(), "name the refractive index n, its absorbing part k");
  if (!wavelength || !n) return std::nullopt;
  return IndexColumns{wavelength->first, *n, csv.column("k"), wavelength->second};
}

/// Whether a line's numbers are an index, its wavelength behind the last one's; reports what is not.
bool is_index(const base::Where& where, double um, double last_um, double n, double k, base::Problems& problems) {
  if (!(um >= kShortest_um && um <= kLongest_um))
    problems.add(where, "wavelength outside 0.05 .. 1000 um", number_text(um) + " um",
                 "check the unit in the column's name");
  else if (!(um > last_um))
    problems.add(where, "wavelengths are not ascending", number_text(um) + " um after " + number_text(last_um) + " um",
                 "sort the file by wavelength, each once");
  else if (!(n > 0 && n <= kLargest))
    problems.add(where, "n is not above 0 and at most 1000", number_text(n), "check the column");
  else if (!(k >= 0 && k <= kLargest))
    problems.add(where, "k is not within 0 .. 1000", number_text(k), "check the column; absorption is positive");
  else
    return true;
  return false;
}

}  // namespace

std::optional<RefractiveIndex> read_index(const std::string& file, const base::Where& asked_by,
                                          base::Problems& problems) {
  const auto csv = read_csv(file, asked_by, problems);
  const auto columns = csv ? columns_of(*csv, problems) : std::nullopt;
  if (!columns) return std::nullopt;
  const std::size_t before = problems.count();
  RefractiveIndex out;
  double last_um = 0;
  for (std::size_t row = 0; row < csv->rows.size() && problems.count() < before + kMostReports; ++row) {
    const auto wavelength = csv->number(row, columns->wavelength, problems), n = csv->number(row, columns->n, problems);
    const auto k = columns->k ? csv->number(row, *columns->k, problems) : std::optional(0.0);
    if (!wavelength || !n || !k) continue;
    const double um = *wavelength * columns->unit_um;
    if (!is_index({csv->file, csv->row_lines[row], 0, ""}, um, last_um, *n, *k, problems)) continue;
    last_um = um;
    for (auto* curve : {&out.n, &out.k}) curve->wavelength_um.push_back(um);
    out.n.value.push_back(*n), out.k.value.push_back(*k);
  }
  if (problems.count() > before) return std::nullopt;
  if (out.n.wavelength_um.size() >= 2) return out;
  problems.add({csv->file, 0, 0, ""}, "a refractive index needs two wavelengths at least",
               std::to_string(out.n.wavelength_um.size()), "add lines");
  return std::nullopt;
}

}  // namespace raycube::scene
