#include "atmos_tables/optics/profile_csv.h"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <fstream>
#include <functional>
#include <string_view>
#include <vector>

#include "atmos_tables/optics/profile_scaling.h"
#include "host/base/error.h"
#include "host/base/input_file.h"

namespace raycube::atmos {

namespace {

/// Water over saturation that a level may hold, %: more is no air. Humidity of real sondes errs by up to 5 %.
constexpr double kMostHumid = 105;
/// Below this pressure the formula of saturation is out of its range and humidity means nothing.
constexpr double kHumidFrom_hPa = 100;

/// What a column sets. Gases come after height, pressure, temperature and air: their units may need those.
struct Column {
  std::string quantity;  ///< two columns may not give the same one
  int turn;              ///< 0 state, 1 air, 2 gases
  double lowest, highest;
  std::function<void(AirLevel&, double)> set;
};

bool find_column(const std::string& name, Column& out) {
  const auto state = [&](const char* quantity, double low, double high, std::function<void(AirLevel&, double)> set) {
    out = {quantity, 0, low, high, std::move(set)};
    return true;
  };
  if (name == "height_km") return state("height", -1, 150, [](AirLevel& l, double v) { l.height_km = v; });
  if (name == "height_m") return state("height", -1000, 150000, [](AirLevel& l, double v) { l.height_km = v * 1e-3; });
  if (name == "pressure_hPa") return state("pressure", 1e-12, 1200, [](AirLevel& l, double v) { l.pressure_hPa = v; });
  if (name == "pressure_Pa")
    return state("pressure", 1e-10, 120000, [](AirLevel& l, double v) { l.pressure_hPa = v * 1e-2; });
  if (name == "temperature_K")
    return state("temperature", 100, 1000, [](AirLevel& l, double v) { l.temperature_K = v; });
  if (name == "temperature_C")
    return state("temperature", -173.15, 726.85, [](AirLevel& l, double v) { l.temperature_K = v + 273.15; });
  if (name == "air_per_cm3") {
    out = {"air", 1, 1, 1e21, [](AirLevel& l, double v) { l.air_per_cm3 = v; }};
    return true;
  }
  for (std::size_t g = 0; g < kGases; ++g) {
    const std::string gas = kGasNames[g];
    if (name.rfind(gas + "_", 0) != 0) continue;
    const std::string unit = name.substr(gas.size() + 1);
    if (unit == "ppmv")
      out = {gas, 2, 0, 1e6, [g](AirLevel& l, double v) { l.gas_per_cm3[g] = 1e-6 * v * l.air_per_cm3; }};
    else if (unit == "per_cm3")
      out = {gas, 2, 0, 1e21, [g](AirLevel& l, double v) { l.gas_per_cm3[g] = v; }};
    else if (name == "h2o_g_per_m3")
      out = {gas, 2, 0, 1000,
             [g](AirLevel& l, double v) { l.gas_per_cm3[g] = v * 1e-6 / kMolarMass_g[g] * kAvogadro; }};
    else if (name == "h2o_relative_humidity_percent")
      out = {gas, 2, 0, 1000,
             [g](AirLevel& l, double v) { l.gas_per_cm3[g] = 0.01 * v * saturation_per_cm3(l.temperature_K); }};
    else
      continue;
    return true;
  }
  return false;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> out;
  for (std::size_t begin = 0;;) {
    const std::size_t comma = std::min(line.find(',', begin), line.size());
    std::string_view cell(line.data() + begin, comma - begin);
    while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
    while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t')) cell.remove_suffix(1);
    out.emplace_back(cell);
    if (comma == line.size()) return out;
    begin = comma + 1;
  }
}

const char* kKnown =
    "columns are height_km|_m, pressure_hPa|_Pa, temperature_K|_C, air_per_cm3, GAS_ppmv, GAS_per_cm3, h2o_g_per_m3, "
    "h2o_relative_humidity_percent; GAS is h2o, co2, o3, n2o, co, ch4 or o2";

std::vector<Column> read_header(const std::vector<std::string>& names, const base::Where& where,
                                base::Problems& problems) {
  std::vector<Column> columns;
  for (const std::string& name : names) {
    Column column;
    if (!find_column(name, column)) {
      problems.add(where, "unknown column", "'" + name + "'", kKnown);
      continue;
    }
    if (std::any_of(columns.begin(), columns.end(), [&](const Column& c) { return c.quantity == column.quantity; }))
      problems.add(where, "two columns give " + column.quantity, "'" + name + "'", "keep one of them");
    columns.push_back(std::move(column));
  }
  for (const char* needed : {"height", "pressure", "temperature"})
    if (std::none_of(columns.begin(), columns.end(), [&](const Column& c) { return c.quantity == needed; }))
      problems.add(where, std::string("no column for ") + needed, "none", kKnown);
  return columns;
}

}  // namespace

namespace {

/// Refuses what is wetter than air can be; holds a relative humidity at saturation, and says whether it did.
bool hold_at_saturation(AirLevel& level, bool relative, const base::Where& where, base::Problems& problems) {
  const double saturated = saturation_per_cm3(level.temperature_K), humid = 100 * level.gas(Gas::h2o) / saturated;
  const double rounding = 1 + 1e-9;
  if (level.pressure_hPa <= kHumidFrom_hPa && !relative) return false;
  if (humid > kMostHumid * rounding) {
    char found[96];
    std::snprintf(found, sizeof found, "%.6g %% at %.2f K", humid, level.temperature_K);
    problems.add(where, "air holds no more water than 100 % relative humidity", found,
                 "correct water or temperature; a relative humidity of up to 105 % is taken as a sonde's "
                 "error and held at 100 %");
  }
  if (!relative || !(humid > 100 * rounding)) return false;
  level.gas(Gas::h2o) = saturated;
  return true;
}

}  // namespace

ProfileFile read_profile_csv(const std::string& file) {
  base::refuse_other_than_plain(file);
  std::ifstream in(file);
  if (!in) throw base::Error(base::Fault::environment, file + ": cannot be read; check the name and its permissions");
  return read_profile_csv(in, file);
}

ProfileFile read_profile_csv(std::istream& in, const std::string& name) {
  base::Problems problems;
  std::vector<Column> columns;
  std::vector<AirLevel> levels;
  std::vector<int> line_of;
  int number = 0, held = 0;
  bool has_header = false, relative = false;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (number == 1 && line.rfind("\xef\xbb\xbf", 0) == 0) line.erase(0, 3);  // byte order mark
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.find_first_not_of(" \t") == std::string::npos || line[0] == '#') continue;
    const base::Where where{name, number, 0, ""};
    const std::vector<std::string> cells = cells_of(line);
    if (!has_header) {
      has_header = true;
      columns = read_header(cells, where, problems);
      relative = std::find(cells.begin(), cells.end(), "h2o_relative_humidity_percent") != cells.end();
      problems.throw_if_any();  // rows cannot be judged without their columns
      continue;
    }
    if (cells.size() != columns.size()) {
      problems.add(where, "needs " + std::to_string(columns.size()) + " values as the header says",
                   std::to_string(cells.size()), "complete the line");
      continue;
    }
    std::vector<double> values(cells.size());
    bool sound = true;
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const char* end = cells[i].data() + cells[i].size();
      const auto [rest, code] = std::from_chars(cells[i].data(), end, values[i]);
      if (code == std::errc{} && rest == end && values[i] >= columns[i].lowest && values[i] <= columns[i].highest)
        continue;
      char limits[64];
      std::snprintf(limits, sizeof limits, "%g to %g", columns[i].lowest, columns[i].highest);
      problems.add(where, columns[i].quantity + " must be a number in " + limits, "'" + cells[i] + "'",
                   "check value and unit");
      sound = false;
    }
    if (!sound) continue;
    AirLevel level;
    for (int turn = 0; turn < 3; ++turn) {
      if (turn == 1) level.air_per_cm3 = 1e-4 * level.pressure_hPa / (kBoltzmann_J_per_K * level.temperature_K);
      for (std::size_t i = 0; i < columns.size(); ++i)
        if (columns[i].turn == turn) columns[i].set(level, values[i]);
    }
    for (std::size_t g = 0; g < kGases; ++g)
      if (level.gas_per_cm3[g] > level.air_per_cm3)
        problems.add(where, std::string(kGasNames[g]) + " is more than all the air",
                     std::to_string(level.ppmv(Gas(g))) + " ppmv", "check its unit");
    held += hold_at_saturation(level, relative, where, problems);
    levels.push_back(level);
    line_of.push_back(number);
  }
  if (!has_header)
    problems.add({name, 0, 0, ""}, "no header line", "an empty file", kKnown);
  else if (levels.size() < 2 && problems.empty())
    problems.add({name, 0, 0, ""}, "a profile needs at least 2 levels", std::to_string(levels.size()), "add lines");
  if (levels.size() >= 2 && levels.front().height_km > levels.back().height_km)
    std::reverse(levels.begin(), levels.end()), std::reverse(line_of.begin(), line_of.end());
  for (std::size_t i = 1; i < levels.size(); ++i) {
    const base::Where where{name, line_of[i], 0, ""};
    if (!(levels[i].height_km > levels[i - 1].height_km))
      problems.add(where, "heights must run in one direction without repeats",
                   std::to_string(levels[i].height_km) + " km", "sort the lines");
    else if (!(levels[i].pressure_hPa < levels[i - 1].pressure_hPa))
      problems.add(where, "pressure must fall with height", std::to_string(levels[i].pressure_hPa) + " hPa",
                   "correct the line");
  }
  problems.throw_if_any();
  ProfileFile out{AirProfile(std::move(levels), name), {}, {}};
  for (std::size_t g = 0; g < kGases; ++g)
    out.given[g] =
        std::any_of(columns.begin(), columns.end(), [&](const Column& c) { return c.quantity == kGasNames[g]; });
  if (held > 0)
    out.notices.push_back("profile " + name + ": water above saturation was held at 100 % relative humidity at " +
                          std::to_string(held) + " levels");
  return out;
}

}  // namespace raycube::atmos
