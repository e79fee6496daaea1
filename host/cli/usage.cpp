#include "host/cli/usage.h"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/error.h"
#include "host/base/version.h"

namespace raycube::cli {
namespace {

using Json = nlohmann::ordered_json;

/// "-o, --output PATH" or "FILE".
std::string left_column(const base::Option& row) {
  std::string names = row.names;
  if (const auto comma = names.find(','); comma != std::string::npos)
    names.insert(comma + 1, " ");
  else if (!row.positional)
    names = "    " + names;
  if (row.takes_value() && !row.positional) names += " " + row.value_name;
  return names;
}

/// Help sentence with unit, range and default in brackets.
std::string full_help(const base::Option& row) {
  std::string out = row.help;
  std::vector<std::string> notes;
  if (!row.unit.empty()) notes.push_back(row.unit);
  if (!row.range.empty()) notes.push_back(row.range);
  if (!row.default_text.empty()) notes.push_back("default " + row.default_text);
  if (!notes.empty()) out += fmt::format(" [{}]", fmt::join(notes, "; "));
  return out;
}

std::string synopsis(const std::string& path, const base::OptionTable& table) {
  std::string line = "raycube " + path + " [options]";
  for (const auto& row : table.rows()) {
    if (!row.positional) continue;
    const std::string name = row.value_name + (row.repeats ? "..." : "");
    line += row.required ? " " + name : " [" + name + "]";
  }
  return line;
}

void append_rows(std::string& out, const char* title, const base::OptionTable& table,
                 bool (*wanted)(const base::Option&)) {
  bool first = true;
  for (const auto& row : table.rows()) {
    if (!wanted(row)) continue;
    if (first) out += fmt::format("\n{}:\n", title);
    first = false;
    const std::string left = left_column(row);
    out += fmt::format("  {:<26}{}{}\n", left, left.size() > 25 ? "\n" + std::string(28, ' ') : "", full_help(row));
  }
}

/// Paragraphs as lines of at most 100 characters, each at the blank before it is too long.
std::string wrapped(const std::string& text) {
  constexpr std::size_t kWidth = 100;
  std::string out;
  std::size_t line = 0, blank = std::string::npos;  // in `out`
  for (const char c : text) {
    out += c;
    if (c == '\n') line = out.size(), blank = std::string::npos;
    if (c == ' ') blank = out.size() - 1;
    if (out.size() - line <= kWidth || blank == std::string::npos) continue;
    out[blank] = '\n';
    line = blank + 1;
    blank = std::string::npos;
  }
  return out;
}

bool is_positional(const base::Option& row) { return row.positional; }
bool is_own(const base::Option& row) { return !row.positional && !row.common; }
bool is_common(const base::Option& row) { return row.common; }

Json verb_json(const Verb& verb) {
  Json out = {{"name", verb.name}, {"summary", verb.summary}};
  if (!verb.description.empty()) out["description"] = verb.description;
  if (!verb.examples.empty()) out["examples"] = verb.examples;
  CommonOptions values;
  out["options"] = Json::array();
  const base::OptionTable table = verb.run ? table_of(verb, values) : base::OptionTable();
  for (const auto& row : table.rows()) {
    Json option = {{"names", Json::array()}, {"type", row.type}, {"help", row.help}};
    std::string names = row.names;
    for (std::size_t at; !names.empty(); names = at == std::string::npos ? "" : names.substr(at + 1)) {
      at = names.find(',');
      option["names"].push_back(names.substr(0, at));
    }
    if (!row.unit.empty()) option["unit"] = row.unit;
    if (!row.default_text.empty()) option["default"] = row.default_text;
    if (!row.range.empty()) option["range"] = row.range;
    option["positional"] = row.positional;
    option["required"] = row.required;
    option["repeats"] = row.repeats;
    option["common"] = row.common;
    out["options"].push_back(std::move(option));
  }
  for (const auto& child : verb.verbs) out["verbs"].push_back(verb_json(child));
  return out;
}

std::string troff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
      out += std::string("\\&") + c;
    else
      out += c;
  }
  return out;
}

void append_man_rows(std::string& out, const base::OptionTable& table, bool (*wanted)(const base::Option&)) {
  for (const auto& row : table.rows()) {
    if (!wanted(row)) continue;
    std::string left = left_column(row);
    left.erase(0, left.find_first_not_of(' '));
    out += fmt::format(".TP\n.B {}\n{}\n", troff(left), troff(full_help(row)));
  }
}

void append_man_verb(std::string& out, const std::string& path, const Verb& verb) {
  CommonOptions values;
  if (verb.run) {
    const auto table = table_of(verb, values);
    out +=
        fmt::format(".SS {}\n.nf\n{}\n.fi\n.PP\n{}.\n", troff(path), troff(synopsis(path, table)), troff(verb.summary));
    if (!verb.description.empty()) out += ".PP\n" + troff(verb.description) + "\n";
    append_man_rows(out, table, is_positional);
    append_man_rows(out, table, is_own);
    std::vector<std::string> common;
    for (const auto& row : table.rows())
      if (row.common) common.push_back(row.long_name());
    out += fmt::format(".PP\nCommon options: {}.{}\n", troff(fmt::format("{}", fmt::join(common, ", "))),
                       verb.output_default.empty() ? "" : troff(" Default of --output: " + verb.output_default + "."));
    for (const auto& example : verb.examples) out += fmt::format(".PP\n.RS\n.nf\n{}\n.fi\n.RE\n", troff(example));
  }
  for (const auto& child : verb.verbs) append_man_verb(out, path + " " + child.name, child);
}

}  // namespace

base::OptionTable table_of(const Verb& verb, CommonOptions& values) {
  base::OptionTable table;
  if (verb.add_options) verb.add_options(table);
  add_common_options(table, values, verb.common);
  for (auto& row : table.rows())
    if (row.common && row.long_name() == "--output") row.default_text = verb.output_default;
  return table;
}

const std::vector<ExitStatus>& exit_statuses() {
  static const std::vector<ExitStatus> statuses = {
      {0, "done"},
      {1, "a check found a difference beyond its limits"},
      {2, "bad input or usage"},
      {3, "the environment: file system, memory, a missing library or data file"},
      {4, "the OpenCL device or its driver"},
      {70, "a bug of raycube"},
      {130, "interrupted"}};
  return statuses;
}

const std::vector<EnvironmentVariable>& environment_variables() {
  static const std::vector<EnvironmentVariable> variables = {
      {"RAYCUBE_DATA", "Folder with plots, scenes and compiled kernels, instead of share/raycube beside the program"},
      {"RAYCUBE_PYTHON", "Python with laspy and lazrs, which LAZ files need"}};
  return variables;
}

std::string program_help(const std::vector<Verb>& verbs) {
  std::string out =
      "raycube: radiance cubes and truth of imaging instruments, ray traced with OpenCL\n\n"
      "Usage: raycube VERB [options]\n\nVerbs:\n";
  for (const auto& verb : verbs) out += fmt::format("  {:<12}{}\n", verb.name, verb.summary);
  out +=
      "\nOptions:\n"
      "  -h, --help      This text; `raycube VERB --help` for one verb\n"
      "  --version       Version, commit and compiler\n"
      "  --json-usage    Every verb and option as one JSON document\n"
      "\nExit status:\n";
  for (const auto& [status, text] : exit_statuses()) out += fmt::format("  {:<4}{}\n", status, text);
  out += "\nEnvironment:\n";
  for (const auto& [name, text] : environment_variables()) out += fmt::format("  {:<16}{}\n", name, text);
  return out;
}

std::string verb_help(const std::string& path, const Verb& verb) {
  CommonOptions values;
  if (!verb.run) {
    std::string out = fmt::format("{}\n\nUsage: raycube {} VERB [options]\n\nVerbs:\n", verb.summary, path);
    for (const auto& child : verb.verbs) out += fmt::format("  {:<12}{}\n", child.name, child.summary);
    return out + fmt::format("\nOptions of each: `raycube {} VERB --help`\n", path);
  }
  const auto table = table_of(verb, values);
  std::string out = fmt::format("{}\n\nUsage: {}\n", verb.summary, synopsis(path, table));
  append_rows(out, "Arguments", table, is_positional);
  append_rows(out, "Options", table, is_own);
  append_rows(out, "Common options", table, is_common);
  out += "      --help                This text\n";
  if (!verb.description.empty()) out += "\n" + wrapped(verb.description) + "\n";
  for (std::size_t i = 0; i < verb.examples.size(); ++i)
    out += (i == 0 ? "\nExamples:\n  " : "  ") + verb.examples[i] + "\n";
  return out;
}

std::string json_usage(const std::vector<Verb>& verbs) {
  Json out = {{"program", "raycube"}, {"version", base::kVersion}};
  for (const auto& verb : verbs) out["verbs"].push_back(verb_json(verb));
  for (const auto& [status, text] : exit_statuses()) out["exit_status"][std::to_string(status)] = text;
  for (const auto& [name, text] : environment_variables()) out["environment"][name] = text;
  return out.dump(2) + "\n";
}

std::string man_page(const std::vector<Verb>& verbs) {
  std::string out = fmt::format(".TH RAYCUBE 1 \"\" \"raycube {}\" \"User Commands\"\n", base::kVersion);
  out += ".SH NAME\nraycube \\- radiance cubes and truth of imaging instruments, ray traced with OpenCL\n";
  out +=
      ".SH SYNOPSIS\n.B raycube\n.I VERB\n[options]\n.br\n.B raycube \\-\\-help | \\-\\-version | \\-\\-json\\-usage\n";
  out +=
      ".SH DESCRIPTION\n" +
      troff(
          "raycube renders what an imaging spectrometer sees of a described scene: a radiance cube in ENVI form, the "
          "truth behind every pixel, quicklooks and a record of the run. Results go to stdout and to files, messages "
          "to stderr. Files that exist are kept unless --overwrite is given.") +
      "\n.SH VERBS\n";
  for (const auto& verb : verbs) append_man_verb(out, verb.name, verb);
  out += ".SH COMMON OPTIONS\n";
  CommonOptions values;
  base::OptionTable common;
  add_common_options(common, values, ~0u);
  append_man_rows(out, common, is_common);
  out += ".SH EXIT STATUS\n";
  for (const auto& [status, text] : exit_statuses()) out += fmt::format(".TP\n.B {}\n{}\n", status, troff(text));
  out += ".SH ENVIRONMENT\n";
  for (const auto& [name, text] : environment_variables()) out += fmt::format(".TP\n.B {}\n{}\n", name, troff(text));
  return out;
}

std::string nearest(const std::string& typed, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t best_distance = std::string::npos;
  for (const auto& candidate : candidates) {
    std::vector<std::size_t> row(candidate.size() + 1);
    for (std::size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (std::size_t i = 0; i < typed.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i + 1;
      for (std::size_t j = 0; j < candidate.size(); ++j) {
        const std::size_t next = std::min({row[j + 1] + 1, row[j] + 1, diagonal + (typed[i] != candidate[j])});
        diagonal = row[j + 1];
        row[j + 1] = next;
      }
    }
    if (row.back() < best_distance) best_distance = row.back(), best = candidate;
  }
  const std::size_t near = best.size() <= 3 ? 1 : std::max<std::size_t>(2, best.size() / 3);
  return best_distance <= near ? best : "";
}

}  // namespace raycube::cli
