#include "scene_compiler/own_aerosol_builder.h"

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>

#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/spectrum_file.h"

namespace raycube::scene {
namespace {

using base::Problems;

constexpr const char* kStatedKeys[] = {"angstrom", "single_scattering_albedo", "asymmetry", "phase_moments", "optics"};
constexpr const char* kSphereKeys[] = {"median_radius_um", "geometric_sigma", "number_share", "modified_gamma"};

/// A column of a CSV and where it goes.
struct TableColumn {
  std::size_t column;
  double low, high;  ///< of its values; low itself is left out where `above`
  bool above;
  std::vector<double>* values;
};

/// Reads wavelengths, ascending, and the columns; false after a report.
bool read_columns(const CsvFile& csv, const std::vector<TableColumn>& columns, std::vector<double>& wavelength_um,
                  Problems& problems) {
  std::optional<std::size_t> axis;
  for (const char* name : {"wavelength_nm", "wavelength_um"})
    if (const auto found = csv.column(name)) axis = found;
  if (!axis) {
    problems.add({csv.file, csv.header_line, 0, ""}, "needs a column wavelength_nm or wavelength_um",
                 csv.columns_text(), "name it so");
    return false;
  }
  const double unit_um = wavelength_unit_um(csv.columns[*axis]).value_or(1.0);
  const std::size_t before = problems.count();
  for (std::size_t row = 0; row < csv.rows.size() && problems.count() < before + 20; ++row) {
    const auto x = csv.number(row, *axis, problems);
    if (!x) continue;
    const double um = *x * unit_um;
    if (!(um >= 0.05 && um <= 1000))
      problems.add(csv.at(row, *axis), "wavelength outside 0.05 to 1000 um", number_text(*x),
                   "check the column's unit");
    if (!wavelength_um.empty() && !(um > wavelength_um.back()))
      problems.add(csv.at(row, *axis), "wavelengths must ascend",
                   number_text(um) + " after " + number_text(wavelength_um.back()) + " um", "sort the rows");
    wavelength_um.push_back(um);
    for (const TableColumn& one : columns) {
      const auto value = csv.number(row, one.column, problems);
      if (value && !(*value >= one.low && *value <= one.high && !(one.above && *value == one.low)))
        problems.add(csv.at(row, one.column),
                     csv.columns[one.column] + " must lie in " + number_text(one.low) + " to " + number_text(one.high) +
                         (one.above ? ", its lower end left out" : ""),
                     number_text(*value), "correct it");
      one.values->push_back(value.value_or(0));
    }
  }
  return problems.count() == before;
}

/// The first whose name begins so; its unit may follow: extinction_per_km.
std::optional<std::size_t> extinction_column(const CsvFile& csv) {
  const auto found = std::find_if(csv.columns.begin(), csv.columns.end(),
                                  [](const std::string& name) { return name.starts_with("extinction"); });
  if (found == csv.columns.end()) return std::nullopt;
  return static_cast<std::size_t>(found - csv.columns.begin());
}

/// moment_0, moment_1, ... as far as they go without a gap.
std::vector<std::size_t> moment_columns(const CsvFile& csv) {
  std::vector<std::size_t> out;
  while (const auto found = csv.column("moment_" + std::to_string(out.size()))) out.push_back(*found);
  return out;
}

/// The CSV of optics against wavelength. Says what a key and a column both state.
void read_optics(const Record& record, OwnAerosolSpec& out, Problems& problems) {
  const auto csv = read_csv(record.text("optics"), record.place("optics"), problems);
  if (!csv) return;
  std::vector<TableColumn> columns;
  const auto take = [&](const std::string& column, const char* key, double low, double high, bool above,
                        std::vector<double>& values) {
    const auto found = csv->column(column);
    if (!found) return;
    if (record.given(key))
      problems.add(record.place(key),
                   std::string("'") + key + "' and the column " + column + " of " + csv->file + " exclude each other",
                   "both", "remove one");
    columns.push_back({*found, low, high, above, &values});
  };
  const auto extinction = extinction_column(*csv);
  take(extinction ? csv->columns[*extinction] : "extinction", "angstrom", 0, 1e9, true, out.extinction);
  take("single_scattering_albedo", "single_scattering_albedo", 0, 1, false, out.single_scattering_albedo);
  take("asymmetry", "asymmetry", -0.999999, 0.999999, false, out.asymmetry);
  const std::vector<std::size_t> moments = moment_columns(*csv);
  std::vector<std::vector<double>> by_order(moments.size());
  for (std::size_t k = 0; k < moments.size(); ++k) columns.push_back({moments[k], -1, 1, false, &by_order[k]});
  if (!moments.empty() && record.given("phase_moments"))
    problems.add(record.place("phase_moments"),
                 "'phase_moments' and the columns moment_0 ... of " + csv->file + " exclude each other", "both",
                 "remove one");
  if (columns.empty())
    problems.add({csv->file, csv->header_line, 0, ""},
                 "has none of the columns extinction, single_scattering_albedo, asymmetry, moment_0",
                 csv->columns_text(), "name what it holds so");
  if (columns.size() + 1 < csv->columns.size())
    problems.add({csv->file, csv->header_line, 0, ""},
                 "holds columns beside wavelength, extinction, single_scattering_albedo, asymmetry, moment_0, moment_1 "
                 "...",
                 csv->columns_text(), "name or number them so, or remove them");
  if (!read_columns(*csv, columns, out.wavelength_um, problems)) return;
  for (std::size_t i = 0; i < out.wavelength_um.size() && !moments.empty(); ++i) {
    std::vector<double>& at = out.phase_moments.emplace_back();
    for (const std::vector<double>& order : by_order) at.push_back(order[i]);
  }
}

/// A height of an extinction profile, kept if it is sound.
void add_height(double height_km, double extinction, const base::Where& where, OwnAerosolSpec& out,
                Problems& problems) {
  if (!out.height_km.empty() && !(height_km > out.height_km.back()))
    problems.add(where, "heights must ascend",
                 number_text(height_km) + " after " + number_text(out.height_km.back()) + " km", "sort them");
  if (extinction < 0)
    problems.add(where, "relative extinctions must not be negative", number_text(extinction), "correct it");
  out.height_km.push_back(height_km), out.height_extinction.push_back(extinction);
}

void read_height_file(const Record& record, OwnAerosolSpec& out, Problems& problems) {
  const auto csv = read_csv(record.text("extinction_profile_file"), record.place("extinction_profile_file"), problems);
  if (!csv) return;
  const auto km = csv->column("height_km"), m = csv->column("height_m");
  const auto extinction = extinction_column(*csv);
  if ((!km && !m) || !extinction) {
    problems.add({csv->file, csv->header_line, 0, ""},
                 "an extinction profile has the columns height_km or height_m, and extinction", csv->columns_text(),
                 "name them so");
    return;
  }
  const std::size_t before = problems.count();
  for (std::size_t row = 0; row < csv->rows.size() && problems.count() < before + 20; ++row) {
    const auto height = csv->number(row, km ? *km : *m, problems), value = csv->number(row, *extinction, problems);
    if (height && value) add_height(km ? *height : *height / 1000, *value, csv->at(row, *extinction), out, problems);
  }
}

void read_height(const Record& record, OwnAerosolSpec& out, Problems& problems) {
  out.scale_height_km = record.number("scale_height_km");
  const char* given = nullptr;
  for (const char* key : {"scale_height_km", "extinction_profile", "extinction_profile_file"}) {
    if (!record.given(key)) continue;
    if (given)
      problems.add(record.place(key), std::string("'") + key + "' and '" + given + "' exclude each other", "both",
                   "remove one");
    given = key;
  }
  if (!given || std::string(given) == "scale_height_km") return;
  const std::size_t before = problems.count();
  for (const auto& [height_km, extinction] : record.value("extinction_profile").points)
    add_height(height_km, extinction, record.place("extinction_profile"), out, problems);
  if (record.given("extinction_profile_file")) read_height_file(record, out, problems);
  if (out.height_km.size() < 2 && problems.count() == before)
    problems.add(record.place(given), "an extinction profile needs two heights", std::to_string(out.height_km.size()),
                 "give its lower and its upper end");
}

/// Optics as they are: what is stated, once, and all of it.
void read_stated(const Record& record, OwnAerosolSpec& out, Problems& problems) {
  const std::string name = "aerosol '" + out.name + "'";
  for (const char* key : kSphereKeys)
    if (record.given(key))
      problems.add(record.place(key), std::string("'") + key + "' is of spheres, and no refractive index is given", "",
                   "add refractive_index or refractive_index_file, or remove it");
  out.angstrom = record.number("angstrom");
  if (record.given("single_scattering_albedo"))
    out.single_scattering_albedo = {record.number("single_scattering_albedo")};
  if (record.given("asymmetry")) out.asymmetry = {record.number("asymmetry")};
  if (record.given("phase_moments")) out.phase_moments = {record.numbers("phase_moments")};
  if (record.given("optics")) {
    OwnAerosolSpec table;
    read_optics(record, table, problems);
    out.wavelength_um = table.wavelength_um, out.extinction = table.extinction;
    if (!table.single_scattering_albedo.empty()) out.single_scattering_albedo = table.single_scattering_albedo;
    if (!table.asymmetry.empty()) out.asymmetry = table.asymmetry;
    if (!table.phase_moments.empty()) out.phase_moments = table.phase_moments;
  }
  const auto lacks = [&](const std::string& what, const std::string& way_out) {
    problems.add(record.where, name + " says nothing of " + what, "", way_out);
  };
  if (out.extinction.empty() && !record.given("angstrom"))
    lacks("how its extinction goes with wavelength",
          "give angstrom, a column extinction in the file of 'optics', or a refractive index and sizes");
  if (out.single_scattering_albedo.empty())
    lacks("its single-scattering albedo",
          "give single_scattering_albedo as a key or as a column of the file of 'optics', or a refractive index");
  if (out.asymmetry.empty() && out.phase_moments.empty())
    lacks("the direction it scatters to",
          "give asymmetry or phase_moments as a key or as columns of the file of 'optics', or a refractive index");
  if (!out.asymmetry.empty() && !out.phase_moments.empty())
    problems.add(record.where, name + " has both an asymmetry and moments of its phase function", "both",
                 "remove the asymmetry: it is the moment chi_1");
}

void read_spheres(const Record& record, OwnAerosolSpec& out, Problems& problems) {
  for (const char* key : kStatedKeys)
    if (record.given(key))
      problems.add(record.place(key),
                   std::string("'") + key + "' states what Mie's series makes of the refractive index",
                   value_text(record, key), "remove one of them");
  if (record.given("refractive_index") && record.given("refractive_index_file"))
    problems.add(record.place("refractive_index"), "'refractive_index' and 'refractive_index_file' exclude each other",
                 "both", "remove one");
  if (record.given("refractive_index_file")) {
    const auto csv = read_csv(record.text("refractive_index_file"), record.place("refractive_index_file"), problems);
    const auto n = csv ? csv->column("n") : std::nullopt, k = csv ? csv->column("k") : std::nullopt;
    if (csv && (!n || !k || csv->columns.size() != 3))
      problems.add({csv->file, csv->header_line, 0, ""},
                   "refractive indices have the columns wavelength_nm or wavelength_um, n, k", csv->columns_text(),
                   "name them so");
    else if (csv)
      read_columns(*csv, {{*n, 0, 100, true, &out.refractive_n}, {*k, 0, 100, false, &out.refractive_k}},
                   out.wavelength_um, problems);
  } else {
    out.refractive_n = {record.numbers("refractive_index")[0]},
    out.refractive_k = {record.numbers("refractive_index")[1]};
    if (out.refractive_n[0] == 0)
      problems.add(record.place("refractive_index"), "the real part n must be positive", "0", "give n, k");
  }
  out.median_radius_um = record.numbers("median_radius_um"), out.geometric_sigma = record.numbers("geometric_sigma");
  out.number_share = record.numbers("number_share"), out.modified_gamma = record.numbers("modified_gamma");
  const std::size_t modes = out.median_radius_um.size();
  if (modes > 0 && record.given("modified_gamma"))
    problems.add(record.place("modified_gamma"), "'modified_gamma' and lognormal modes exclude each other", "both",
                 "remove one");
  if (modes == 0 && !record.given("modified_gamma"))
    problems.add(record.where, "aerosol '" + out.name + "' has a refractive index and no sizes", "",
                 "give median_radius_um and geometric_sigma, or modified_gamma");
  if (out.geometric_sigma.size() != modes)
    problems.add(record.place("geometric_sigma"), "needs one value for each of median_radius_um",
                 std::to_string(out.geometric_sigma.size()) + " for " + std::to_string(modes), "complete them");
  if (out.number_share.size() != modes && !(modes < 2 && out.number_share.empty()))
    problems.add(record.place("number_share"), "needs one value for each of median_radius_um",
                 std::to_string(out.number_share.size()) + " for " + std::to_string(modes), "complete them");
}

}  // namespace

std::vector<OwnAerosolSpec> read_own_aerosols(const Record& atmosphere, Problems& problems) {
  std::vector<OwnAerosolSpec> all;
  for (const Record& record : atmosphere.records("own_aerosol")) {
    OwnAerosolSpec& out = all.emplace_back();
    if (!record.sound) continue;
    out.name = record.text("name");
    out.optical_depth = record.number("optical_depth");
    out.at_um = record.number("wavelength_nm") / 1000;
    read_height(record, out, problems);
    if (record.given("refractive_index") || record.given("refractive_index_file"))
      read_spheres(record, out, problems);
    else
      read_stated(record, out, problems);
  }
  return all;
}

}  // namespace raycube::scene
