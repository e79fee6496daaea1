#include "host/experiment/sweep_file.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include <fmt/format.h>

#include "host/experiment/result_files.h"
#include "host/experiment/sobol.h"
#include "host/experiment/step_reader.h"
#include "host/experiment/study_keys.h"

namespace raycube::experiment {
namespace {

/// A level of a range as it would be typed: fifteen digits, and no -0. Other ends and other counts of levels, which
/// round differently, so come to the same number, and a point that has been there is found again.
double as_typed(double value) { return std::stod(fmt::format("{:.15g}", value)) + 0.0; }

void read_range(StudyTable& table, Parameter& out) {
  for (const char* key : {"from", "to"})
    if (!table.has(key)) return table.problem("name", "a range has two ends", fmt::format("no '{}'", key), "give it");
  out.from = table.number("from"), out.to = table.number("to");
  out.logarithmic = table.text("scale") == "log";
  if (!(out.to > out.from)) table.problem("to", "to must lie above from", fmt::format("{}", out.to), "exchange them");
  if (out.logarithmic && !(out.from > 0))
    table.problem("from", "a logarithmic range begins above 0", fmt::format("{}", out.from), "raise it");
  const int levels = static_cast<int>(table.number("levels"));
  for (int i = 0; i < levels; ++i) out.values.push_back(out.at(i / (levels - 1.0)));
}

Parameter read_parameter(StudyTable& table, std::set<std::string>& known) {
  Parameter out;
  out.name = table.text("name");
  take_name(table, out.name, known);
  out.values = table.numbers("values");
  for (double& value : out.values) value += 0.0;  // -0 is 0
  out.range = table.has("from") || table.has("to");
  if (out.range == table.has("values") || (!out.range && out.values.empty()))
    table.problem("name", "a parameter has either values, or from and to", out.range ? "both" : "neither", "give one");
  else if (out.range)
    read_range(table, out);
  for (std::size_t i = 0; i < out.values.size() && !out.range; ++i)
    if (std::count(out.values.begin(), out.values.begin() + static_cast<std::ptrdiff_t>(i), out.values[i]) == 1)
      table.problem("values", "a level is given twice", fmt::format("{}", out.values[i]), "remove one");
  const double middle = out.range ? out.at(0.5) : out.values.empty() ? 0 : out.values[out.values.size() / 2];
  out.rest = table.has("rest") ? table.number("rest") + 0.0 : middle;
  return out;
}

Metric read_metric(StudyTable& table, const Sweep& sweep, const std::set<std::string>& known,
                   std::set<std::string>& columns) {
  Metric out;
  out.where = table.where().text(), out.name = table.text("name");
  if (out.name.find_first_of(",\"\n") != std::string::npos || !columns.insert(out.name).second)
    table.problem("name", "a metric's name has no comma, and no other metric or parameter has it", "'" + out.name + "'",
                  "rename it");
  out.unit = table.text("unit"), out.times = table.number("times");
  out.file = table.text("file"), out.at = table.text("at");
  for (const char* key : {"file", "at"})
    if (table.has(key) == sweep.batch.has_value())
      table.problem("name", "a metric is a place in a file of a step, or a column that a batch writes",
                    fmt::format("{} '{}'", sweep.batch ? "a batch and" : "no", key),
                    sweep.batch ? "remove it" : "add it");
  check_names(table, out.file, known);
  check_place(table, "at", out.at);
  return out;
}

}  // namespace

double Parameter::at(double share) const {
  if (range && share == 1) return to;
  if (!range) {
    const auto count = static_cast<double>(values.size());
    return values[static_cast<std::size_t>(std::min(count - 1, std::floor(share * count)))];
  }
  return as_typed(logarithmic ? from * std::pow(to / from, share) : from + share * (to - from));
}

Sweep read_sweep(const std::string& file) {
  StudyTable root = StudyTable::read(file, sweep_format());
  Sweep out;
  out.folder = root.folder(), out.title = root.text("title"), out.text = root.text("text");
  const std::string method = root.text("method");
  out.method = method == "sobol"       ? SweepMethod::sobol
               : method == "factorial" ? SweepMethod::factorial
                                       : SweepMethod::one_at_a_time;
  out.base_points = static_cast<std::uint32_t>(root.number("base_points"));
  std::set<std::string> known, columns;
  for (StudyTable& table : root.tables("parameter")) out.parameters.push_back(read_parameter(table, known));
  for (const Parameter& one : out.parameters) columns.insert(one.name);
  for (StudyTable& table : root.tables("batch"))
    out.batch = read_commands(table, "batch", {}, {"folder", "here", "points", "results"});
  for (StudyTable& table : root.tables("step")) out.steps.push_back(read_step(table, known));
  for (StudyTable& table : root.tables("metric")) out.metrics.push_back(read_metric(table, out, known, columns));
  if (out.parameters.empty()) root.problem("", "a sweep has parameters", "none", "add [[parameter]]");
  if (out.metrics.empty()) root.problem("", "a sweep has metrics", "none", "add [[metric]]");
  if (out.steps.empty() == !out.batch)
    root.problem("", "a sweep has either steps or a batch", out.batch ? "both" : "neither", "add [[step]], or [batch]");
  if (out.method == SweepMethod::sobol && 2 * out.parameters.size() > kMostDimensions)
    root.problem("method", "indices are had of 10 parameters at most", std::to_string(out.parameters.size()),
                 "fix some");
  root.throw_if_any();
  return out;
}

}  // namespace raycube::experiment
