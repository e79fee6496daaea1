#include "host/experiment/experiment_file.h"

#include <set>

#include "host/experiment/study_table.h"

namespace raycube::experiment {
namespace {

bool is_name(const std::string& text) {
  if (text.empty() || text == "folder" || text == "here") return false;
  for (const char c : text)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_' && c != '-') return false;
  return true;
}

FigureValue read_value(StudyTable& table) {
  FigureValue out;
  out.name = table.text("name"), out.file = table.text("file"), out.at = table.text("at");
  out.unit = table.text("unit", ""), out.times = table.number("times", 1);
  out.digits = static_cast<int>(table.number("digits", 3));
  if (table.has("published")) out.published = table.text("published");
  if (!out.at.empty() && out.at.front() != '/')
    table.problem("at", "a place in a JSON file begins with /", out.at, "as in /curves/0/auc (RFC 6901)");
  table.done();
  return out;
}

}  // namespace

Experiment read_experiment(const std::string& file) {
  StudyTable root = StudyTable::read(file);
  Experiment out;
  out.file = file, out.folder = root.folder();
  out.title = root.text("title"), out.text = root.text("text", ""), out.source = root.text("source", "");
  std::set<std::string> names;
  for (StudyTable& table : root.tables("step")) {
    StepPlan step;
    step.where = table.where().text();
    step.name = table.text("name"), step.commands = table.commands("run"), step.inputs = table.texts("inputs");
    if (!is_name(step.name))
      table.problem("name", "a step's name has letters, digits, _ and -, and is not folder or here",
                    "'" + step.name + "'", "choose another");
    if (!names.insert(step.name).second)
      table.problem("name", "two steps have one name", "'" + step.name + "'", "rename one");
    table.done();
    out.steps.push_back(std::move(step));
  }
  for (StudyTable& table : root.tables("figure")) {
    Figure figure;
    figure.where = table.where().text();
    figure.of = table.text("of", ""), figure.title = table.text("title"), figure.text = table.text("text", "");
    figure.why = table.text("why", ""), figure.pictures = table.texts("pictures");
    for (StudyTable& value : table.tables("value")) figure.values.push_back(read_value(value));
    table.done();
    out.figures.push_back(std::move(figure));
  }
  if (out.steps.empty()) root.problem("", "an experiment has steps", "none", "add [[step]] with name and run");
  root.done();
  root.throw_if_any();
  return out;
}

}  // namespace raycube::experiment
