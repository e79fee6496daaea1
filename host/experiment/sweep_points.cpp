#include "host/experiment/sweep_points.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/output_file.h"
#include "host/experiment/result_files.h"
#include "host/experiment/sobol.h"

namespace raycube::experiment {
namespace {

Names names_of(const Sweep& sweep, const std::vector<double>& point) {
  Names out;
  for (std::size_t i = 0; i < point.size(); ++i) out[sweep.parameters[i].name] = fmt::format("{}", point[i]);
  return out;
}

std::string point_text(const Sweep& sweep, const std::vector<double>& point) {
  std::string out;
  for (const auto& [name, value] : names_of(sweep, point)) out += (out.empty() ? "" : ", ") + name + " = " + value;
  return out;
}

double metric_of(const Metric& metric, const Names& folders, ResultFiles& files) {
  const std::string path = with_names(metric.file, folders, metric.where);
  const nlohmann::json& found = files.at(path, metric.at, metric.where);
  if (found.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (!found.is_number())
    throw base::Error(base::Fault::input, metric.where + ": " + path + " has no number at " + metric.at);
  return found.get<double>() * metric.times;
}

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> out;
  std::istringstream cells(line);
  for (std::string cell; std::getline(cells, cell, ',');)
    out.push_back(cell.substr(0, cell.find_last_not_of("\r ") + 1));
  return out;
}

/// Refuses a row that says itself that it is another point's.
void check_point(const Sweep& sweep, const std::vector<std::string>& header, const std::vector<std::string>& row,
                 const std::vector<double>& point, const std::string& where) {
  for (std::size_t i = 0; i < point.size(); ++i) {
    const auto found = std::find(header.begin(), header.end(), sweep.parameters[i].name);
    const auto at = static_cast<std::size_t>(found - header.begin());
    if (found == header.end() || at >= row.size() || row[at].empty()) continue;
    const double said = std::strtod(row[at].c_str(), nullptr);
    if (std::abs(said - point[i]) > 1e-6 * std::abs(point[i]))  // they may write fewer digits
      throw base::Error(base::Fault::input,
                        fmt::format("{}: {} is {} where the point has {}; rows are due in the order of the points",
                                    where, sweep.parameters[i].name, row[at], point[i]));
  }
}

/// Metrics by their columns, a row a point; an empty cell is no number.
std::vector<std::vector<double>> read_results(const Sweep& sweep, const std::string& path,
                                              const std::vector<std::vector<double>>& points) {
  std::ifstream results(path);
  std::vector<std::vector<double>> out;
  std::string line;
  std::getline(results, line);
  const std::vector<std::string> header = cells_of(line);
  std::vector<std::size_t> column;
  for (const Metric& metric : sweep.metrics) {
    const auto found = std::find(header.begin(), header.end(), metric.name);
    if (found == header.end())
      throw base::Error(base::Fault::input, metric.where + ": " + path + " has no column " + metric.name);
    column.push_back(static_cast<std::size_t>(found - header.begin()));
  }
  while (std::getline(results, line)) {
    const std::vector<std::string> row = cells_of(line);
    if (out.size() < points.size())
      check_point(sweep, header, row, points[out.size()], fmt::format("{}, row {}", path, out.size() + 1));
    auto& values = out.emplace_back();
    for (std::size_t m = 0; m < column.size(); ++m) {
      const std::string cell = column[m] < row.size() ? row[column[m]] : std::string();
      char* end = nullptr;
      const double value = std::strtod(cell.c_str(), &end);
      if (*end != '\0')
        throw base::Error(base::Fault::input,
                          fmt::format("{}, row {}: '{}' under {} is no number; leave it empty where "
                                      "there is none",
                                      path, out.size(), cell, sweep.metrics[m].name));
      values.push_back(cell.empty() ? std::numeric_limits<double>::quiet_NaN() : value * sweep.metrics[m].times);
    }
  }
  if (out.size() != points.size())
    throw base::Error(base::Fault::input,
                      fmt::format("{} has {} rows for {} points; a row is due for each, in their order", path,
                                  out.size(), points.size()));
  return out;
}

/// All points by one command: a CSV of the parameters in, a CSV of the metrics out.
std::vector<std::vector<double>> run_batch(const Sweep& sweep, const std::vector<std::vector<double>>& points,
                                           KeptSteps& steps) {
  Sweep bare = sweep;
  bare.metrics.clear();
  const std::string table = steps.folder() + "/points.csv";
  StepPlan step = *sweep.batch;
  step.more = sweep_csv(bare, points, std::vector<std::vector<double>>(points.size()));
  base::write_output_file(table, step.more, base::IfExists::replace);
  const Names names = {{"points", table}};
  for (Command& command : step.commands)
    for (std::string& word : command)
      if (const std::size_t at = word.find("{results}"); at != std::string::npos)
        word.replace(at, 9, "{folder}/results.csv");
  const KeptStep made = steps.make(step, names, true);
  return read_results(sweep, made.folder + "/results.csv", points);
}

nlohmann::ordered_json number_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
}

}  // namespace

std::vector<std::vector<double>> points_of(const Sweep& sweep) {
  std::vector<std::vector<double>> out;
  std::vector<double> rest;
  for (const Parameter& one : sweep.parameters) rest.push_back(one.rest);
  if (sweep.method == SweepMethod::sobol) {
    for (std::vector<double>& row : sobol_rows(sweep.base_points, static_cast<int>(sweep.parameters.size()))) {
      for (std::size_t i = 0; i < row.size(); ++i) row[i] = sweep.parameters[i].at(row[i]);
      out.push_back(std::move(row));
    }
  } else if (sweep.method == SweepMethod::one_at_a_time) {
    out.push_back(rest);
    for (std::size_t i = 0; i < sweep.parameters.size(); ++i)
      for (const double value : sweep.parameters[i].values)
        if (value != rest[i]) out.push_back(rest), out.back()[i] = value;
  } else {
    out.emplace_back();
    for (const Parameter& one : sweep.parameters) {
      std::vector<std::vector<double>> more;
      for (const auto& point : out)
        for (const double value : one.values) more.push_back(point), more.back().push_back(value);
      out = std::move(more);
    }
  }
  return out;
}

std::vector<std::vector<double>> run_points(const Sweep& sweep, const std::vector<std::vector<double>>& points,
                                            KeptSteps& steps, const std::function<void()>& told) {
  if (sweep.batch) return run_batch(sweep, points, steps);
  std::vector<std::vector<double>> out;
  for (const auto& point : points) {
    const Names names = names_of(sweep, point);
    try {
      for (const StepPlan& step : sweep.steps) steps.make(step, names, true);
      ResultFiles files;
      auto& row = out.emplace_back();
      Names folders = steps.folders();
      folders.insert(names.begin(), names.end());
      for (const Metric& metric : sweep.metrics) row.push_back(metric_of(metric, folders, files));
    } catch (const base::Error& error) {
      if (error.fault() == base::Fault::interrupted) throw;
      throw base::Error(error.fault(), "at " + point_text(sweep, point) + ": " + error.what());
    }
    told();
  }
  return out;
}

std::string sweep_csv(const Sweep& sweep, const std::vector<std::vector<double>>& points,
                      const std::vector<std::vector<double>>& metrics) {
  std::string out;
  for (const Parameter& one : sweep.parameters) out += (out.empty() ? "" : ",") + one.name;
  for (const Metric& one : sweep.metrics) out += "," + one.name;
  out += "\n";
  for (std::size_t p = 0; p < points.size(); ++p) {
    std::string row;
    for (const auto* values : {&points[p], &metrics[p]})
      for (const double value : *values)
        row += (row.empty() ? "" : ",") + (std::isfinite(value) ? fmt::format("{}", value) : std::string());
    out += row + "\n";
  }
  return out;
}

nlohmann::ordered_json sweep_json(const Sweep& sweep, const std::vector<std::vector<double>>& points,
                                  const std::vector<std::vector<double>>& metrics) {
  static constexpr const char* kMethods[] = {"factorial", "one_at_a_time", "sobol"};
  nlohmann::ordered_json out = {{"title", sweep.title}, {"method", kMethods[static_cast<int>(sweep.method)]}};
  for (const Parameter& one : sweep.parameters)
    out["parameters"].push_back({{"name", one.name}, {"rest", one.rest}, {"log", one.logarithmic}});
  for (std::size_t p = 0; p < points.size(); ++p) {
    nlohmann::ordered_json point;
    for (std::size_t i = 0; i < points[p].size(); ++i) point[sweep.parameters[i].name] = points[p][i];
    for (std::size_t m = 0; m < metrics[p].size(); ++m) point[sweep.metrics[m].name] = number_or_null(metrics[p][m]);
    out["points"].push_back(std::move(point));
  }
  for (std::size_t m = 0; m < sweep.metrics.size(); ++m) {
    nlohmann::ordered_json metric = {{"name", sweep.metrics[m].name}, {"unit", sweep.metrics[m].unit}};
    std::vector<double> values;
    for (const auto& row : metrics) values.push_back(row[m]);
    if (sweep.method == SweepMethod::sobol) {
      const auto indices = sobol_indices(values, sweep.base_points, static_cast<int>(sweep.parameters.size()));
      for (std::size_t i = 0; i < indices.size(); ++i)
        metric["indices"].push_back(
            {{"parameter", sweep.parameters[i].name},
             {"first", number_or_null(indices[i].first)},
             {"first_95", {number_or_null(indices[i].first_low), number_or_null(indices[i].first_high)}},
             {"total", number_or_null(indices[i].total)},
             {"total_95", {number_or_null(indices[i].total_low), number_or_null(indices[i].total_high)}}});
    } else if (sweep.method == SweepMethod::one_at_a_time) {
      std::size_t row = 1;
      for (const Parameter& one : sweep.parameters) {
        double low = values[0], high = values[0];
        for (const double value : one.values) {
          if (value == one.rest) continue;
          low = std::fmin(low, values[row]), high = std::fmax(high, values[row]), ++row;  // past what is no number
        }
        metric["spans"].push_back(
            {{"parameter", one.name}, {"low", number_or_null(low)}, {"high", number_or_null(high)}});
      }
    }
    out["metrics"].push_back(metric);
  }
  return out;
}

}  // namespace raycube::experiment
