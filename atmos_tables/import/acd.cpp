#include "atmos_tables/import/acd.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>

#include "host/base/text.h"
#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

namespace {

constexpr std::size_t kFields = 9, kFunctions = 5;
constexpr const char* kLabels[kFields] = {"FREQ",
                                          "LOS",
                                          "K_INT",
                                          "K_WEIGHT",
                                          "SUN_GND_DIFFUSE_TRANSM",
                                          "SUN_GND_OBS_DIRECT_TRANSM",
                                          "OBS_GND_EMBEDDED_DIF_TRANSM",
                                          "OBS_GND_DIRECT_TRANSM",
                                          "SPHERICAL_ALBEDO"};
constexpr const char* kNames[kFunctions] = {
    "sun_ground_transmittance_diffuse", "sun_ground_sensor_transmittance_direct", "ground_sensor_transmittance_diffuse",
    "ground_sensor_transmittance_direct", "spherical_albedo"};

/// Whether field `f` counts lines of sight or k terms.
constexpr bool counted(std::size_t f) { return f == 1 || f == 2; }

struct AcdRow {
  base::Where where;
  std::array<Number, kFields> field;
};

/// Rows in the file's order into runs.
Imported runs_of(const std::string& path, const char* format, const std::vector<AcdRow>& rows,
                 base::Problems& problems) {
  if (rows.empty()) problems.add({path, 0, 0, ""}, "no data rows", "", "the file is cut short");
  std::map<int, std::vector<const AcdRow*>> by_sight;
  for (const AcdRow& row : rows) by_sight[static_cast<int>(row.field[1].value)].push_back(&row);
  Imported out{path, "MODTRAN 6", format, {}};
  problems.throw_if_any();
  for (const auto& [sight, mine] : by_sight) {
    std::size_t terms = 0;
    while (terms < mine.size() && mine[terms]->field[0].value == mine[0]->field[0].value) ++terms;
    Run run;
    run.mode = "atmospheric correction data";
    if (by_sight.size() > 1) run.notes.push_back("line of sight " + std::to_string(sight));
    std::vector<Column> per_k(terms * (kFunctions + 1)), sums(kFunctions);
    for (std::size_t k = 0; k < terms; ++k)
      for (std::size_t f = 0; f <= kFunctions; ++f) {
        Column& column = per_k[k * (kFunctions + 1) + f];
        column.name = f == 0 ? "k_weight" : kNames[f - 1], column.source = kLabels[3 + f], column.unit = "1";
        column.place.k = static_cast<int>(k) + 1;
      }
    for (std::size_t f = 0; f < kFunctions; ++f)
      sums[f].name = kNames[f], sums[f].source = kLabels[4 + f], sums[f].unit = "1";
    for (std::size_t i = 0; i < mine.size() && problems.count() < kEnoughProblems; i += terms) {
      const double freq = mine[i]->field[0].value;
      if (!(freq > 0)) problems.add(mine[i]->where, "FREQ is not above 0", std::to_string(freq), "");
      if (i > 0 && !(freq > mine[i - terms]->field[0].value))
        problems.add(mine[i]->where, "FREQ does not ascend",
                     std::to_string(freq) + " after " + std::to_string(mine[i - terms]->field[0].value),
                     "rows are out of order or doubled");
      run.wavelength_um.push_back(wavelength_um_from_axis(freq, AxisUnit::per_cm));
      double weights = 0, weight_rounding = 0;
      std::array<double, kFunctions> sum{}, rounding{};
      for (std::size_t k = 0; k < terms; ++k) {
        if (i + k >= mine.size() || mine[i + k]->field[0].value != freq ||
            mine[i + k]->field[2].value != static_cast<double>(k) + 1) {
          problems.add(mine[std::min(i + k, mine.size() - 1)]->where,
                       "the k-terms of a frequency are not whole: k " + std::to_string(k + 1) + " of " +
                           std::to_string(terms) + " is missing",
                       "", "rows are missing or out of order");
          break;
        }
        const auto& field = mine[i + k]->field;
        weights += field[3].value, weight_rounding += field[3].rounding;
        for (std::size_t f = 0; f <= kFunctions; ++f) {
          Column& column = per_k[k * (kFunctions + 1) + f];
          column.values.push_back(field[3 + f].value), column.rounding.push_back(field[3 + f].rounding);
          if (f > 0)
            sum[f - 1] += field[3].value * field[3 + f].value,
                rounding[f - 1] += field[3].value * field[3 + f].rounding + field[3].rounding * field[3 + f].value;
        }
      }
      if (!problems.empty()) continue;
      // 1e-5: weights are single precision and printed to a few digits.
      if (std::abs(weights - 1) > weight_rounding + 1e-5)
        problems.add(mine[i]->where, "the weights of the k-terms do not sum to 1", std::to_string(weights),
                     "rows are missing or damaged");
      for (std::size_t f = 0; f < kFunctions; ++f)
        sums[f].values.push_back(sum[f]), sums[f].rounding.push_back(rounding[f]);
    }
    if (!problems.empty()) continue;
    for (auto& column : sums) run.columns.push_back(std::move(column));
    for (auto& column : per_k) run.columns.push_back(std::move(column));
    sort_ascending(run);
    check_run(run, {path, 0, 0, ""}, problems, 1e-5);
    out.runs.push_back(std::move(run));
  }
  problems.throw_if_any();
  return out;
}

}  // namespace

Imported read_acd_text(const std::string& path) {
  const auto lines = read_lines(path);
  base::Problems problems;
  std::vector<AcdRow> rows;
  for (std::size_t i = 0; i < lines.size() && problems.count() < kEnoughProblems; ++i) {
    const auto tokens = split_blanks(lines[i]);
    if (tokens.empty() || tokens[0].rfind("-9999", 0) == 0) continue;
    const base::Where where{path, static_cast<int>(i) + 1, 0, ""};
    if (rows.empty() && read_number(tokens[0]).state == Number::State::malformed) continue;  // the header
    if (tokens.size() != kFields) {
      if (rows.empty() && i < 5) continue;  // a header line that starts with a number
      problems.add(where, "the row has another number of fields than 9", std::to_string(tokens.size()),
                   "the row is damaged or cut short");
      continue;
    }
    AcdRow row{where, {}};
    for (std::size_t f = 0; f < kFields; ++f)
      row.field[f] =
          counted(f)
              ? Number{Number::State::good,
                       static_cast<double>(need_whole(tokens[f], where, kLabels[f], 0, kMostNumbered, problems)), 0}
              : need_number(tokens[f], where, kLabels[f], problems);
    rows.push_back(row);
  }
  return runs_of(path, "acd", rows, problems);
}

Imported read_acd_binary(const std::string& path) {
  const std::string bytes = read_bytes(path);
  constexpr std::size_t kRecord = 4 * (kFields + 2);
  constexpr std::int32_t kMarker = 4 * kFields;
  const auto word = [&](std::size_t record, std::size_t index) {
    const auto* at = reinterpret_cast<const unsigned char*>(bytes.data()) + record * kRecord + 4 * index;
    return static_cast<std::uint32_t>(at[0]) | static_cast<std::uint32_t>(at[1]) << 8 |
           static_cast<std::uint32_t>(at[2]) << 16 | static_cast<std::uint32_t>(at[3]) << 24;
  };
  const auto real = [&](std::size_t record, std::size_t index) {
    const std::uint32_t bits = word(record, index);
    float value;
    std::memcpy(&value, &bits, 4);
    return value;
  };
  base::Problems problems;
  if (bytes.size() % kRecord != 0 || bytes.size() < 2 * kRecord)
    problems.add({path, 0, 0, ""}, "the file is not made of records of 44 bytes", base::counted(bytes.size(), "byte"),
                 "it is cut short or no binary .acd");
  problems.throw_if_any();
  if (real(0, 1) != -9999.0f)
    problems.add({path, 0, 0, "record 1"}, "the first record does not start with -9999", std::to_string(real(0, 1)),
                 "is it a binary .acd?");
  std::vector<AcdRow> rows;
  for (std::size_t r = 0; r < bytes.size() / kRecord && problems.count() < kEnoughProblems; ++r) {
    const base::Where where{path, 0, 0, "record " + std::to_string(r + 1)};
    if (word(r, 0) != kMarker || word(r, kFields + 1) != kMarker) {
      problems.add(where, "the record's markers are not 36",
                   std::to_string(word(r, 0)) + " and " + std::to_string(word(r, kFields + 1)), "the file is damaged");
      continue;
    }
    if (r == 0) continue;
    AcdRow row{where, {}};
    for (std::size_t f = 0; f < kFields; ++f) {
      const double value = counted(f) ? static_cast<double>(static_cast<std::int32_t>(word(r, f + 1)))
                                      : static_cast<double>(real(r, f + 1));
      if (!std::isfinite(value) || value < 0)
        problems.add(where, std::string(kLabels[f]) + (std::isfinite(value) ? " is negative" : " is not finite"),
                     std::to_string(value), "run the code anew");
      row.field[f] = {Number::State::good, value, 0};
    }
    rows.push_back(row);
  }
  return runs_of(path, "binary acd", rows, problems);
}

}  // namespace raycube::atmos::imported
