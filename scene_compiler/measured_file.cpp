#include "scene_compiler/measured_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <utility>

#include "host/base/text.h"
#include "kernels/shared/product_key.h"
#include "scene_compiler/csv_file.h"
#include "scene_compiler/document_values.h"
#include "scene_compiler/linear_nodes.h"

namespace raycube::scene {

namespace {

constexpr double kLargestFactor = 1000, kShortestNamed_um = 0.05, kLongestNamed_um = 1000;
constexpr std::size_t kMostLinesReported = 20, kMostValues = 1'000'000;
/// Of what lies between the wavelengths that are kept, rms over that of all factors: what is sought, what is taken.
constexpr double kSought = 0.002, kTaken = 0.02;
constexpr double kRadians = std::numbers::pi / 180;
constexpr const char* kAngles[3] = {"light_zenith_deg", "view_zenith_deg", "relative_azimuth_deg"};

/// An angle in ten-thousandths of a degree, which floats of radians tell apart: what a file writes twice is the same.
using Angle = long long;
Angle angle_of(double degrees) { return std::llround(degrees * 1e4); }
double degrees_of(Angle angle) { return static_cast<double>(angle) * 1e-4; }

struct ValueColumn {
  std::size_t column;
  double wavelength_um;  ///< 0: factors of all wavelengths
};

struct FactorColumns {
  std::array<std::size_t, 3> angle;
  std::vector<ValueColumn> values;
};

/// Wavelength in a column's name, um; 0: it names none.
double wavelength_named(const std::string& column) {
  for (const auto& [unit, um] : {std::pair<std::string, double>{"nm", 1e-3}, {"um", 1.0}}) {
    if (!column.ends_with(unit)) continue;
    const auto number = parse_number(column.substr(0, column.size() - unit.size()));
    if (number && *number * um >= kShortestNamed_um && *number * um <= kLongestNamed_um) return *number * um;
  }
  return 0;
}

std::optional<FactorColumns> factor_columns(const CsvFile& csv, base::Problems& problems) {
  const base::Where header{csv.file, csv.header_line, 0, ""};
  const std::size_t before = problems.count();
  FactorColumns out{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto found = csv.column(kAngles[i]);
    if (!found)
      problems.add(header, std::string("no column '") + kAngles[i] + "'", csv.columns_text(),
                   "name the zenith angles of light and viewer, and the azimuth between them (0: on one side)");
    out.angle[i] = found.value_or(0);
  }
  for (std::size_t i = 0; i < csv.columns.size(); ++i) {
    if (std::find(std::begin(kAngles), std::end(kAngles), csv.columns[i]) != std::end(kAngles)) continue;
    const double um = wavelength_named(csv.columns[i]);
    if (um > 0 || csv.columns[i] == "factor")
      out.values.push_back({i, um});
    else if (csv.columns[i].ends_with("nm") || csv.columns[i].ends_with("um"))
      problems.add(header, "'" + csv.columns[i] + "' names no wavelength from 0.05 to 1000 um", "",
                   "name factors by their wavelengths alone: 550nm, 1.6um");
  }
  std::sort(out.values.begin(), out.values.end(),
            [](const auto& a, const auto& b) { return a.wavelength_um < b.wavelength_um; });
  const auto same = [](const auto& a, const auto& b) { return !(a.wavelength_um < b.wavelength_um); };
  if (out.values.empty())
    problems.add(header, "no column of factors", csv.columns_text(),
                 "name one 'factor', or several by their wavelengths: 550nm, 1.6um");
  else if (std::adjacent_find(out.values.begin(), out.values.end(), same) != out.values.end())
    problems.add(header, "a wavelength stands in two columns", csv.columns_text(), "remove one");
  else if (out.values.size() > 1 && out.values.front().wavelength_um == 0)
    problems.add(header, "'factor' and factors by wavelength", csv.columns_text(), "remove one kind");
  if (problems.count() > before) return std::nullopt;
  return out;
}

/// One line: angles, the azimuth from 0 to 180 degrees, and factors.
struct FactorLine {
  std::array<Angle, 3> angle;
  std::vector<double> value;
};

/// The azimuth to the left or to the right, 0 to 360 degrees.
Angle turned(double degrees) { return angle_of(degrees - 360 * std::floor(degrees / 360)); }
Angle folded(Angle turn) { return std::min(turn, angle_of(360) - turn); }

std::vector<FactorLine> factor_lines(const CsvFile& csv, const FactorColumns& columns, base::Problems& problems) {
  std::vector<FactorLine> out;
  std::set<std::array<Angle, 3>> known;
  const std::size_t before = problems.count();
  for (std::size_t row = 0; row < csv.rows.size() && problems.count() < before + kMostLinesReported; ++row) {
    const base::Where where{csv.file, csv.row_lines[row], 0, ""};
    std::array<double, 3> degrees{};
    FactorLine line;
    bool sound = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto value = csv.number(row, columns.angle[i], problems);
      sound &= value.has_value();
      degrees[i] = value.value_or(0);
      if (!value || i == 2 || (*value >= 0 && *value < 90)) continue;
      problems.add(where, std::string(kAngles[i]) + " outside 0 .. below 90", number_text(*value),
                   "angles count from the surface's normal");
      sound = false;
    }
    for (const ValueColumn& column : columns.values) {
      const auto value = csv.number(row, column.column, problems);
      sound &= value.has_value();
      line.value.push_back(value.value_or(0));
      if (!value || (*value >= 0 && *value <= kLargestFactor)) continue;
      problems.add(where, "factor outside 0 .. 1000", number_text(*value),
                   "give pi times the BRDF, over the material's curve");
      sound = false;
    }
    if (!sound) continue;
    const std::array<Angle, 3> at = {angle_of(degrees[0]), angle_of(degrees[1]), angle_of(degrees[2])};
    if (!known.insert(at).second) {
      problems.add(where, "these angles stand twice",
                   fmt::format("{:g}, {:g}, {:g}", degrees[0], degrees[1], degrees[2]), "remove one");
      continue;
    }
    line.angle = {at[0], at[1], folded(turned(degrees[2]))};
    out.push_back(std::move(line));
  }
  return out;
}

bool upright(const FactorLine& line) { return line.angle[0] == 0 || line.angle[1] == 0; }

/// Sums of factors and their counts on the grid of all angles that occur.
class FactorGrid {
 public:
  explicit FactorGrid(const std::vector<FactorLine>& lines) {
    std::array<std::set<Angle>, 3> angles;
    for (const FactorLine& line : lines)
      for (std::size_t i = 0; i < 3; ++i)
        if (i < 2 || !upright(line)) angles[i].insert(line.angle[i]);
    if (angles[2].empty()) angles[2].insert(0);
    for (std::size_t i = 0; i < 3; ++i) angle_[i].assign(angles[i].begin(), angles[i].end());
  }
  std::size_t size() const { return angle_[0].size() * angle_[1].size() * angle_[2].size(); }

  void add(const FactorLine& line) {
    const std::size_t first = cell({line.angle[0], line.angle[1], angle_[2].front()});
    for (std::size_t k = 0; k < angle_[2].size(); ++k)
      if (upright(line) || angle_[2][k] == line.angle[2]) add_to(first + k, line.value);
  }

  /// Combinations without a factor; the first in words.
  std::pair<std::size_t, std::string> missing() const {
    std::pair<std::size_t, std::string> out{0, ""};
    for (std::size_t at = 0; at < size(); ++at)
      if (!cells_.contains(at) && ++out.first == 1)
        out.second =
            fmt::format("light {:g}, viewer {:g}, azimuth {:g}", degrees_of(angle_[0][at / (turns() * views())]),
                        degrees_of(angle_[1][at / turns() % views()]), degrees_of(angle_[2][at % turns()]));
    return out;
  }

  /// Factors of a column, in the order of the cells.
  std::vector<double> values(std::size_t column) const {
    std::vector<double> out;
    for (const auto& [at, cell] : cells_) out.push_back(cell.sum[column] / cell.count);
    return out;
  }

  ShapeTable table(std::size_t column) const {
    auto out = std::make_shared<std::vector<float>>();
    for (const auto& angle : angle_) out->push_back(static_cast<float>(angle.size()));
    for (const auto& angle : angle_)
      for (const Angle a : angle) out->push_back(static_cast<float>(degrees_of(a) * kRadians));
    for (const double value : values(column)) out->push_back(static_cast<float>(value));
    return out;
  }

 private:
  struct Cell {
    std::vector<double> sum;
    double count = 0;
  };
  std::size_t views() const { return angle_[1].size(); }
  std::size_t turns() const { return angle_[2].size(); }
  std::size_t cell(const std::array<Angle, 3>& at) const {
    std::array<std::size_t, 3> place{};
    for (std::size_t i = 0; i < 3; ++i)
      place[i] =
          static_cast<std::size_t>(std::lower_bound(angle_[i].begin(), angle_[i].end(), at[i]) - angle_[i].begin());
    return (place[0] * views() + place[1]) * turns() + place[2];
  }
  void add_to(std::size_t at, const std::vector<double>& value) {
    Cell& cell = cells_[at];
    cell.sum.resize(value.size(), 0.0);
    for (std::size_t i = 0; i < value.size(); ++i) cell.sum[i] += value[i];
    ++cell.count;
  }

  std::array<std::vector<Angle>, 3> angle_;
  std::map<std::size_t, Cell> cells_;
};

/// Columns between which the others lie about linearly; none after reporting.
std::vector<std::size_t> kept_columns(const CsvFile& csv, const FactorColumns& columns, const FactorGrid& grid,
                                      base::Problems& problems) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < columns.values.size(); ++i) all.push_back(i);
  if (all.size() <= RC_MOST_NODES) return all;
  std::vector<double> um;
  std::vector<std::vector<double>> factors;
  for (const std::size_t i : all) um.push_back(columns.values[i].wavelength_um), factors.push_back(grid.values(i));
  const LinearNodes nodes = linear_nodes(um, factors, RC_MOST_NODES, kSought);
  if (nodes.error <= kTaken) return nodes.row;
  problems.add(
      {csv.file, csv.header_line, 0, ""}, "eight wavelengths do not hold the factors of the others",
      fmt::format("{} wavelengths; linear between the best eight they are {:.2g} % off (rms), {:g} % are taken",
                  all.size(), 100 * nodes.error, 100 * kTaken),
      "keep the wavelengths that your bands see, or divide the factors by the material's curve, so that it "
      "holds what changes fast");
  return {};
}

}  // namespace

std::optional<MeasuredTables> read_measured(const std::string& file, const base::Where& asked_by,
                                            base::Problems& problems) {
  const auto csv = read_csv(file, asked_by, problems);
  const auto columns = csv ? factor_columns(*csv, problems) : std::nullopt;
  if (!columns) return std::nullopt;
  const std::size_t before = problems.count();
  const std::vector<FactorLine> lines = factor_lines(*csv, *columns, problems);
  if (problems.count() > before) return std::nullopt;
  FactorGrid grid(lines);
  if (grid.size() > kMostValues) {
    problems.add({csv->file, 0, 0, ""}, "more than 1e6 combinations of angles", std::to_string(grid.size()),
                 "measure at the same angles throughout, or bring the values to a grid");
    return std::nullopt;
  }
  for (const FactorLine& line : lines) grid.add(line);
  if (const auto [count, first] = grid.missing(); count > 0) {
    problems.add(
        {csv->file, 0, 0, ""},
        base::counted(count, "combination of its angles has", "combinations of its angles have") + " no factor",
        "first: " + first, "add them: by interpolation where they were not measured");
    return std::nullopt;
  }
  MeasuredTables out;
  for (const std::size_t i : kept_columns(*csv, *columns, grid, problems)) {
    out.table.push_back(grid.table(i));
    if (columns->values[i].wavelength_um > 0) out.wavelength_um.push_back(columns->values[i].wavelength_um);
  }
  if (out.table.empty()) return std::nullopt;
  return out;
}

bool is_measured_table(const std::vector<float>& numbers) {
  if (numbers.size() < 3) return false;
  std::size_t angles = 0, values = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    if (!(numbers[i] >= 1 && numbers[i] <= static_cast<float>(kMostValues))) return false;
    angles += static_cast<std::size_t>(numbers[i]), values *= static_cast<std::size_t>(numbers[i]);
    if (values > kMostValues) return false;
  }
  if (numbers.size() != 3 + angles + values) return false;
  std::size_t at = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto count = static_cast<std::size_t>(numbers[i]);
    for (std::size_t k = 0; k < count; ++k, ++at) {
      const double angle = static_cast<double>(numbers[at]);
      if (!(angle >= 0 && angle <= 1.000001 * std::numbers::pi)) return false;
      if (k > 0 && !(numbers[at] > numbers[at - 1])) return false;
    }
  }
  return std::all_of(numbers.begin() + static_cast<std::ptrdiff_t>(at), numbers.end(),
                     [](float value) { return value >= 0 && std::isfinite(value); });
}

}  // namespace raycube::scene
