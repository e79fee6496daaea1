#include "scene_compiler/volume_spectrum.h"

#include <algorithm>
#include <cmath>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::scene {
namespace {

using base::Problems;

/// Nodes on one side of a line's centre. Between nodes ds apart in asinh(distance / half width) a chord lies above the
/// line by up to 0.75 ds^2 of it: 3e-8 for wings of 400 half widths.
constexpr int kNodesPerSide = 32768;

double cross_section_cm2(const std::vector<LorentzLine>& lines, double wavenumber) {
  double sum = 0;
  for (const auto& line : lines) {
    const double d = wavenumber - line.center_per_cm, g = line.half_width_per_cm;
    if (std::abs(d) <= line.wing_per_cm * (1 + 1e-12)) sum += line.strength_cm * g / (M_PI * (d * d + g * g));
  }
  return sum;
}

void read_file(const Record& volume, Volume& out, Problems& problems) {
  const auto csv = read_csv(volume.text("cross_section"), volume.place("cross_section"), problems);
  if (!csv) return;
  const auto value = csv->column("cross_section_cm2");
  std::optional<std::size_t> axis;
  for (const char* name : {"wavelength_nm", "wavelength_um", "wavenumber_per_cm"})
    if (const auto found = csv->column(name)) axis = found;
  if (!axis || !value || csv->columns.size() != 2) {
    problems.add(
        {csv->file, csv->header_line, 0, ""},
        "cross sections have the columns wavelength_nm, wavelength_um or wavenumber_per_cm, and cross_section_cm2",
        csv->columns_text(), "name them so");
    return;
  }
  const bool wavenumber = csv->columns[*axis] == "wavenumber_per_cm";
  const double unit_um = wavelength_unit_um(csv->columns[*axis]).value_or(1.0);
  const std::size_t before = problems.count();
  double previous = 0;
  for (std::size_t row = 0; row < csv->rows.size() && problems.count() < before + 20; ++row) {
    const auto x = csv->number(row, *axis, problems), y = csv->number(row, *value, problems);
    if (!x || !y) continue;
    const double um = wavenumber ? 1e4 / *x : *x * unit_um;
    if (!(um >= 0.05 && um <= 1000))
      problems.add(csv->at(row, *axis), "wavelength outside 0.05 to 1000 um", number_text(*x),
                   "check the column's unit");
    if (*y < 0 || *y > 1e-10)
      problems.add(csv->at(row, *value), "no cross section in cm2 per molecule", number_text(*y),
                   "give values from 0 to 1e-10");
    if (row > 0 && *x <= previous)
      problems.add(csv->at(row, *axis), "rows must ascend", number_text(*x) + " after " + number_text(previous),
                   "sort them");
    previous = *x;
    out.wavelength_um.push_back(um), out.cross_section_cm2.push_back(*y);
  }
  if (out.wavelength_um.size() < 2 && problems.count() == before)
    problems.add({csv->file, 0, 0, ""}, "cross sections need two rows", std::to_string(out.wavelength_um.size()),
                 "give a range of wavelengths");
  if (!wavenumber) return;
  std::reverse(out.wavelength_um.begin(), out.wavelength_um.end());
  std::reverse(out.cross_section_cm2.begin(), out.cross_section_cm2.end());
}

}  // namespace

void tabulate_lines(const std::vector<LorentzLine>& lines, Volume& out) {
  std::vector<double> wavenumbers;
  for (const auto& line : lines) {
    const double end = std::asinh(line.wing_per_cm / line.half_width_per_cm);
    for (int i = -kNodesPerSide; i <= kNodesPerSide; ++i)
      wavenumbers.push_back(line.center_per_cm + line.half_width_per_cm * std::sinh(end * i / kNodesPerSide));
    // A wing's end is a step of the sum: a node just beyond it.
    for (const int side : {-1, 1}) wavenumbers.push_back(line.center_per_cm + side * line.wing_per_cm * (1 + 1e-9));
  }
  std::sort(wavenumbers.begin(), wavenumbers.end(), std::greater<>());
  for (const double wavenumber : wavenumbers) {
    if (!(wavenumber > 0)) continue;
    const double um = 1e4 / wavenumber;
    if (!out.wavelength_um.empty() && um <= out.wavelength_um.back()) continue;
    out.wavelength_um.push_back(um);
    out.cross_section_cm2.push_back(cross_section_cm2(lines, wavenumber));
  }
}

void read_cross_section(const Record& volume, Volume& out, Problems& problems) {
  const auto& records = volume.records("line");
  const bool file = volume.given("cross_section");
  if (file == !records.empty()) {
    problems.add(volume.where, "a gas needs exactly one of cross_section and [[volume.line]]",
                 file ? "both" : "neither", "remove or add one");
    return;
  }
  if (file) return read_file(volume, out, problems);
  std::vector<LorentzLine> lines;
  for (const Record& record : records) {
    lines.push_back({record.number("strength_cm"), record.number("half_width_per_cm"), record.number("center_per_cm"),
                     record.number("wing_per_cm")});
    if (lines.back().wing_per_cm >= lines.back().center_per_cm)
      problems.add(record.place("wing_per_cm"), "the line's wing reaches below wavenumber 0",
                   number_text(lines.back().wing_per_cm), "lower it");
  }
  tabulate_lines(lines, out);
}

}  // namespace raycube::scene
