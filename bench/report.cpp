#include "bench/report.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/base/error.h"

namespace raycube::bench {
namespace {

std::string cpu_model() {
  std::ifstream info("/proc/cpuinfo");
  for (std::string line; std::getline(info, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "unknown";
}

}  // namespace

Spread spread_of(std::vector<double> values) {
  if (values.empty()) throw base::Error(base::Fault::bug, "spread of no measurement");
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  const double median = n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
  return {median, values.front(), values.back(), static_cast<int>(n)};
}

Report::Report(const std::string& commit) {
  utsname system{};
  uname(&system);
  set_text("commit", commit);
  set_text("cpu", cpu_model());
  set_text("hardware_threads", std::to_string(std::thread::hardware_concurrency()));
  set_text("system", std::string(system.sysname) + " " + system.release + " " + system.machine);
  set_text("compiler", "g++ " __VERSION__);
}

void Report::set_text(const std::string& key, const std::string& value) { texts_.emplace_back(key, value); }

void Report::add(const std::string& key, double value, const std::string& unit, std::optional<Goal> goal) {
  add(key, Spread{value, value, value, 1}, unit, goal);
}

void Report::add(const std::string& key, const Spread& spread, const std::string& unit, std::optional<Goal> goal) {
  figures_.push_back({key, unit, spread, goal});
  fmt::print("  {:<34} {:.6g} {}\n", key, spread.median, unit);
  std::fflush(stdout);
}

void Report::validate(const std::string& what, double found, double limit) {
  fmt::print("  valid: {}: {:.4g} (limit {:.4g})\n", what, found, limit);
  std::fflush(stdout);
  if (!(found <= limit))
    throw base::Error(base::Fault::check,
                      fmt::format("bench: {}: found {:.6g}, limit {:.6g}; nothing wrong is timed", what, found, limit));
}

void Report::add_programs(const std::string& launcher, const Programs& programs) {
  for (const auto& [key, hash] :
       {std::pair<std::string, std::string>{"program_hash", programs.all}, {"trace_program_hash", programs.trace}}) {
    if (hash.empty()) continue;
    const auto [known, fresh] = programs_.try_emplace(key, hash, launcher);
    if (fresh) set_text(key, hash);
    if (fresh || known->second.second != launcher) fmt::print("  valid: {} of {}: {}\n", key, launcher, hash);
    if (known->second.first != hash)
      throw base::Error(
          base::Fault::check,
          fmt::format("bench: {} differs: {} launched {}, {} launched {}; what is timed must be what `render` "
                      "launches: build both from one commit",
                      key, known->second.second, known->second.first, launcher, hash));
  }
}

std::vector<std::string> Report::missed() const {
  std::vector<std::string> out;
  for (const Figure& f : figures_)
    if (f.goal && !f.goal->met(f.spread.median))
      out.push_back(fmt::format("{} {:.4g} ({} {:g})", f.key, f.spread.median,
                                f.goal->sense == Goal::Sense::at_least ? ">=" : "<=", f.goal->value));
  return out;
}

void Report::print_table() const {
  fmt::print("\n{:<34} {:>11} {:>25}  {:<10} {}\n", "figure", "median", "[lowest .. highest] runs", "unit", "goal");
  for (const Figure& f : figures_) {
    const std::string range =
        f.spread.count > 1 ? fmt::format("[{:.4g} .. {:.4g}] {}", f.spread.lowest, f.spread.highest, f.spread.count)
                           : "";
    std::string goal;
    if (f.goal)
      goal = fmt::format("{} {:g}: {}", f.goal->sense == Goal::Sense::at_least ? ">=" : "<=", f.goal->value,
                         f.goal->met(f.spread.median) ? "met"
                         : f.goal->guard              ? "GUARD FAILED"
                                                      : "MISSED");
    fmt::print("{:<34} {:>11.5g} {:>25}  {:<10} {}\n", f.key, f.spread.median, range, f.unit, goal);
  }
  for (const auto& [key, value] : texts_) fmt::print("{}: {}\n", key, value);
  const auto goals =
      std::count_if(figures_.begin(), figures_.end(), [](const Figure& f) { return f.goal.has_value(); });
  const auto lost = missed();
  if (goals && lost.empty())
    fmt::print("goals: {} of {} met\n", goals, goals);
  else if (goals)
    fmt::print("goals: {} of {} MISSED: {}\n", lost.size(), goals, fmt::join(lost, "; "));
}

void Report::write_json(const std::string& path) const {
  nlohmann::ordered_json json;
  for (const auto& [key, value] : texts_) json[key] = value;
  for (const Figure& f : figures_) {
    json[f.key] = f.spread.median;
    if (f.spread.count > 1) {
      json[f.key + "_min"] = f.spread.lowest;
      json[f.key + "_max"] = f.spread.highest;
      json[f.key + "_runs"] = f.spread.count;
    }
    if (f.goal) {
      json[f.key + "_goal"] = f.goal->value;
      json[f.key + "_goal_is"] = f.goal->sense == Goal::Sense::at_least ? "at least" : "at most";
    }
  }
  json["goals_missed"] = fmt::format("{}", fmt::join(missed(), "; "));
  const std::string partial = path + ".partial";
  std::ofstream file(partial);
  file << json.dump(2) << '\n';
  file.close();
  if (!file)
    throw base::Error(base::Fault::environment, "bench: " + partial + " cannot be written; check space and rights");
  std::filesystem::rename(partial, path);
}

bool Report::guards_hold() const {
  return std::all_of(figures_.begin(), figures_.end(),
                     [](const Figure& f) { return !f.goal || !f.goal->guard || f.goal->met(f.spread.median); });
}

}  // namespace raycube::bench
