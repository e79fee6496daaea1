#include "host/experiment/sweep_file.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "host/experiment/sobol.h"
#include "host/experiment/result_files.h"
#include "host/experiment/step_reader.h"

namespace raycube::experiment {
namespace {

constexpr double kMostLevels = 1000, kMostBasePoints = 1 << 20;

Parameter read_parameter(StudyTable& table, std::set<std::string>& known) {
  Parameter out;
  out.name = table.text("name");
  take_name(table, out.name, known);
  out.values = table.numbers("values");
  out.range = table.has("from") || table.has("to");
  if (out.range == !out.values.empty())
    table.problem("name", "a parameter has either values, or from and to", out.range ? "both" : "neither", "give one");
  if (out.range) {
    out.from = table.number("from"), out.to = table.number("to");
    const std::string scale = table.text("scale", "linear");
    out.logarithmic = scale == "log";
    const double levels = table.number("levels", 3);
    if (!std::isfinite(out.from) || !std::isfinite(out.to))
      table.problem("to", "a range is finite", "inf", "give two numbers");
    if (scale != "linear" && scale != "log")
      table.problem("scale", "scale is linear or log", "'" + scale + "'", "choose");
    if (!(out.to > out.from)) table.problem("to", "to must lie above from", std::to_string(out.to), "exchange them");
    if (out.logarithmic && !(out.from > 0))
      table.problem("from", "a logarithmic range begins above 0", std::to_string(out.from), "raise it");
    if (!(levels >= 2 && levels <= kMostLevels) || levels != std::floor(levels))
      table.problem("levels", "levels must be a whole number, 2 or more", std::to_string(levels), "correct it");
    for (int i = 0; i < static_cast<int>(levels) && levels <= kMostLevels; ++i)
      out.values.push_back(out.at(i / (levels - 1)));
  }
  out.rest = table.number("rest", out.range ? out.at(0.5) : out.values.empty() ? 0 : out.values[out.values.size() / 2]);
  table.done();
  return out;
}

}  // namespace

double Parameter::at(double share) const {
  if (range && share == 1) return to;
  if (!range) {
    const auto count = static_cast<double>(values.size());
    return values[static_cast<std::size_t>(std::min(count - 1, std::floor(share * count)))];
  }
  return logarithmic ? from * std::pow(to / from, share) : from + share * (to - from);
}

Sweep read_sweep(const std::string& file) {
  StudyTable root = StudyTable::read(file);
  Sweep out;
  out.folder = root.folder(), out.title = root.text("title"), out.text = root.text("text", "");
  const std::string method = root.text("method", "one_at_a_time");
  out.method = method == "sobol"       ? SweepMethod::sobol
               : method == "factorial" ? SweepMethod::factorial
                                       : SweepMethod::one_at_a_time;
  if (method != "sobol" && method != "factorial" && method != "one_at_a_time")
    root.problem("method", "method is one_at_a_time, factorial or sobol", "'" + method + "'", "choose one");
  const double points = root.number("base_points", 64);
  if (!(points >= 2 && points <= kMostBasePoints) || points != std::floor(points))
    root.problem("base_points", "base_points must be a whole number from 2", std::to_string(points),
                 "a power of two is best");
  else
    out.base_points = static_cast<std::uint32_t>(points);
  std::set<std::string> known, metrics;
  for (StudyTable& table : root.tables("parameter")) out.parameters.push_back(read_parameter(table, known));
  for (StudyTable& table : root.tables("batch"))
    out.batch = read_commands(table, "batch", {}, {"folder", "here", "points", "results"});
  for (StudyTable& table : root.tables("step")) out.steps.push_back(read_step(table, known));
  for (StudyTable& table : root.tables("metric")) {
    Metric one;
    one.where = table.where().text();
    one.name = table.text("name");
    if (one.name.find_first_of(",\"\n") != std::string::npos || !metrics.insert(one.name).second)
      table.problem("name", "a metric's name has no comma, and is the only one of its kind", "'" + one.name + "'",
                    "rename it");
    one.unit = table.text("unit", ""), one.times = table.number("times", 1);
    if (!out.batch) one.file = table.text("file"), one.at = table.text("at");
    check_names(table, one.file, known);
    check_place(table, "at", one.at);
    table.done();
    out.metrics.push_back(std::move(one));
  }
  if (out.parameters.empty()) root.problem("", "a sweep has parameters", "none", "add [[parameter]]");
  if (out.metrics.empty()) root.problem("", "a sweep has metrics", "none", "add [[metric]]");
  if (out.steps.empty() == !out.batch)
    root.problem("", "a sweep has either steps or a batch", out.batch ? "both" : "neither", "add [[step]], or [batch]");
  if (out.method == SweepMethod::sobol && 2 * out.parameters.size() > kMostDimensions)
    root.problem("method", "indices are had of 10 parameters at most", std::to_string(out.parameters.size()),
                 "fix some");
  root.done();
  root.throw_if_any();
  return out;
}

}  // namespace raycube::experiment
