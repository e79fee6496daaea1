#include "host/experiment/html_report.h"

#include <array>
#include <cmath>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/text.h"
#include "host/experiment/result_files.h"

namespace raycube::experiment {
namespace {

constexpr const char* kStyle = R"(
:root { color-scheme: light dark; --ink: #1c2329; --paper: #fdfdfb; --line: #cfd5d9; --soft: #f1f3f2; --accent: #1f5f8b;
        --quiet: #5b6770; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e4e8ea; --paper: #15191c; --line: #3a444b; --soft: #1f262b; --accent: #7db8dd; --quiet: #9aa6ae; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 68rem; padding: 1.5rem 1rem 4rem; color: var(--ink); background: var(--paper);
       font: 1rem/1.55 system-ui, sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0.5rem 0; }
h2 { font-size: 1.2rem; margin: 0 0 0.4rem; }
a { color: var(--accent); }
nav ol { columns: 18rem; padding-left: 1.4rem; font-size: 0.92rem; }
section { border-top: 1px solid var(--line); padding: 1.4rem 0 0.8rem; break-inside: avoid; }
.of { color: var(--accent); font-weight: 600; font-size: 0.9rem; }
.pictures { display: grid; grid-template-columns: 1fr; gap: 0.8rem; margin: 0.8rem 0; }
@media (min-width: 44rem), print {
  .pictures.of2, .pictures.of4 { grid-template-columns: 1fr 1fr; }
  .pictures.of3 { grid-template-columns: 1fr 1fr 1fr; } }
.pictures img { width: 100%; height: auto; background: #fff; border: 1px solid var(--line); align-self: start; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; margin: 0.6rem 0; font-size: 0.94rem; }
th, td { text-align: left; padding: 0.3rem 0.9rem 0.3rem 0; border-bottom: 1px solid var(--line); vertical-align: top; }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.why { background: var(--soft); padding: 0.6rem 0.8rem; border-left: 3px solid var(--accent); margin: 0.6rem 0; }
.quiet { color: var(--quiet); font-size: 0.9rem; }
@media print { body { max-width: none; font-size: 10pt; } nav { display: none; } }
)";

/// Words between backticks as code.
std::string with_code(const std::string& text) {
  std::string out;
  bool inside = false;
  for (const char c : text) {
    if (c != '`') {
      out += c;
      continue;
    }
    out += inside ? "</code>" : "<code>";
    inside = !inside;
  }
  return inside ? out + "</code>" : out;
}

/// Paragraphs: split by empty lines.
std::string paragraphs(const std::string& text) {
  std::string out;
  std::istringstream lines(text);
  std::string paragraph;
  const auto end = [&] {
    if (!paragraph.empty()) out += "<p>" + with_code(base::escaped_markup(paragraph)) + "</p>\n";
    paragraph.clear();
  };
  for (std::string line; std::getline(lines, line);) {
    if (line.find_first_not_of(" \t\r") == std::string::npos)
      end();
    else
      paragraph += (paragraph.empty() ? "" : " ") + line;
  }
  end();
  return out;
}

std::string whole(const std::string& path, const std::string& where) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw base::Error(base::Fault::input, where + ": " + path + " is not there; is its step among the steps?");
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(bytes.size() / 3 * 4 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto at = [&](std::size_t k) {
      return i + k < bytes.size() ? std::uint32_t(static_cast<unsigned char>(bytes[i + k])) : 0u;
    };
    const std::uint32_t three = at(0) << 16 | at(1) << 8 | at(2);
    for (int digit = 0; digit < 4; ++digit)
      out += i + static_cast<std::size_t>(digit) > bytes.size() ? '=' : kDigits[three >> (18 - 6 * digit) & 63];
  }
  return out;
}

std::string value_text(const FigureValue& value, const nlohmann::json& found) {
  if (found.is_number()) {
    const std::string unit = value.unit.empty() ? "" : " " + value.unit;
    return fmt::format("{:.{}g}{}", found.get<double>(), value.digits, unit);
  }
  return found.is_string() ? found.get<std::string>() : found.is_null() ? "none" : found.dump();
}

std::string figure_html(const ToldFigure& told, std::size_t number) {
  const Figure& figure = *told.figure;
  std::string out = fmt::format("<section id=\"f{}\">\n", number);
  if (!figure.of.empty()) out += "<div class=\"of\">" + base::escaped_markup(figure.of) + "</div>\n";
  out += "<h2>" + base::escaped_markup(figure.title) + "</h2>\n" + paragraphs(figure.text);
  if (!told.pictures.empty()) {
    out += fmt::format("<div class=\"pictures of{}\">\n", told.pictures.size());
    for (const std::string& picture : told.pictures)
      out += fmt::format("<img alt=\"{}\" src=\"data:image/png;base64,{}\">\n", base::escaped_markup(figure.title),
                         base64(whole(picture, figure.where)));
    out += "</div>\n";
  }
  if (!told.values.empty()) {
    bool published = false;
    for (const ToldValue& value : told.values) published = published || value.value->published.has_value();
    out += "<div class=\"scroll\"><table><tr><th></th><th class=\"n\">here</th>";
    if (published) out += "<th class=\"n\">published</th>";
    out += "</tr>\n";
    for (const ToldValue& value : told.values) {
      out += "<tr><td>" + base::escaped_markup(value.value->name) + "</td><td class=\"n\">" +
             base::escaped_markup(value.text) + "</td>";
      if (published) out += "<td class=\"n\">" + base::escaped_markup(value.value->published.value_or("")) + "</td>";
      out += "</tr>\n";
    }
    out += "</table></div>\n";
  }
  if (!figure.why.empty()) out += "<div class=\"why\">" + paragraphs(figure.why) + "</div>\n";
  return out + "</section>\n";
}

}  // namespace

std::vector<ToldFigure> told_figures(const Experiment& experiment, const Names& folders) {
  ResultFiles files;
  std::vector<ToldFigure> out;
  for (const Figure& figure : experiment.figures) {
    ToldFigure told;
    told.figure = &figure;
    for (const std::string& picture : figure.pictures) {
      told.pictures.push_back(with_names(picture, folders, figure.where));
      if (whole(told.pictures.back(), figure.where).compare(0, 8, "\x89PNG\r\n\x1a\n") != 0)
        throw base::Error(base::Fault::input, figure.where + ": " + told.pictures.back() + " is no PNG");
    }
    for (const FigureValue& value : figure.values) {
      ToldValue one;
      one.value = &value;
      one.found = files.at(with_names(value.file, folders, figure.where), value.at, figure.where);
      if (one.found.is_number()) one.found = one.found.get<double>() * value.times;
      one.text = value_text(value, one.found);
      told.values.push_back(std::move(one));
    }
    out.push_back(std::move(told));
  }
  return out;
}

nlohmann::ordered_json numbers_json(const Experiment& experiment, const std::vector<ToldFigure>& figures,
                                    const std::vector<std::pair<std::string, KeptStep>>& steps) {
  nlohmann::ordered_json out = {{"title", experiment.title}, {"file", experiment.file}};
  out["figures"] = nlohmann::ordered_json::array(), out["steps"] = nlohmann::ordered_json::array();
  for (const ToldFigure& told : figures) {
    nlohmann::ordered_json values = nlohmann::ordered_json::array();
    for (const ToldValue& value : told.values) {
      nlohmann::ordered_json one = {{"name", value.value->name}, {"value", value.found}, {"unit", value.value->unit}};
      if (value.value->published) one["published"] = *value.value->published;
      values.push_back(one);
    }
    out["figures"].push_back({{"of", told.figure->of}, {"title", told.figure->title}, {"values", values}});
  }
  for (const auto& [name, step] : steps)
    out["steps"].push_back({{"name", name}, {"seconds", step.seconds}, {"processor_s", step.processor_s}});
  return out;
}

std::string report_html(const Experiment& experiment, const std::vector<ToldFigure>& figures,
                        const std::vector<std::pair<std::string, KeptStep>>& steps) {
  std::string out =
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
      base::escaped_markup(experiment.title) + "</title>\n<style>" + kStyle + "</style></head><body>\n<h1>" +
      base::escaped_markup(experiment.title) + "</h1>\n" + paragraphs(experiment.text);
  if (!experiment.source.empty())
    out += "<p class=\"quiet\">Published: " + base::escaped_markup(experiment.source) + "</p>\n";
  out += "<nav><ol>\n";
  for (std::size_t i = 0; i < figures.size(); ++i)
    out += fmt::format("<li><a href=\"#f{}\">{}{}</a></li>\n", i,
                       figures[i].figure->of.empty() ? "" : base::escaped_markup(figures[i].figure->of) + ": ",
                       base::escaped_markup(figures[i].figure->title));
  out += "<li><a href=\"#steps\">Steps and times</a></li>\n</ol></nav>\n";
  for (std::size_t i = 0; i < figures.size(); ++i) out += figure_html(figures[i], i);
  double total_s = 0;
  out +=
      "<section id=\"steps\"><h2>Steps and times</h2>\n<div class=\"scroll\"><table><tr><th>step</th>"
      "<th class=\"n\">seconds</th><th class=\"n\">of processors</th></tr>\n";
  for (const auto& [name, step] : steps) {
    out += fmt::format("<tr><td>{}</td><td class=\"n\">{:.1f}</td><td class=\"n\">{:.1f}</td></tr>\n",
                       base::escaped_markup(name), step.seconds, step.processor_s);
    total_s += step.seconds;
  }
  out += fmt::format("<tr><td>all</td><td class=\"n\">{:.1f}</td><td></td></tr></table></div>\n", total_s);
  return out + "<p class=\"quiet\">Every number is in numbers.json beside this page.</p></section>\n</body></html>\n";
}

}  // namespace raycube::experiment
