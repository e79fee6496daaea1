#include "host/experiment/experiment_file.h"

#include <set>

#include "host/experiment/study_table.h"

namespace raycube::experiment {
namespace {

/// Reports names in braces that stand for nothing yet.
void check_names(StudyTable& table, const std::string& text, const std::set<std::string>& known) {
  for (const std::string& name : names_in(text))
    if (known.count(name) == 0)
      table.problem("", "nothing is called {" + name + "} here", "'" + text + "'",
                    "name a step before it, {folder} or {here}; a brace itself is {{");
}

FigureValue read_value(StudyTable& table) {
  FigureValue out;
  out.name = table.text("name"), out.file = table.text("file"), out.at = table.text("at");
  out.unit = table.text("unit", ""), out.times = table.number("times", 1);
  const double digits = table.number("digits", 3);
  if (!(digits >= 1 && digits <= 17))
    table.problem("digits", "digits lie from 1 to 17", std::to_string(digits), "correct it");
  else
    out.digits = static_cast<int>(digits);
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
  std::set<std::string> names, before;
  for (StudyTable& table : root.tables("step")) {
    StepPlan step;
    step.where = table.where().text();
    step.name = table.text("name"), step.commands = table.commands("run"), step.inputs = table.texts("inputs");
    require_name(table, step.name);
    if (!names.insert(step.name).second)
      table.problem("name", "two steps have one name", "'" + step.name + "'", "rename one");
    std::set<std::string> known = before;
    known.insert({"folder", "here"});
    for (const Command& command : step.commands)
      for (const std::string& word : command) check_names(table, word, known);
    before.insert(step.name);
    table.done();
    out.steps.push_back(std::move(step));
  }
  for (StudyTable& table : root.tables("figure")) {
    Figure figure;
    figure.where = table.where().text();
    figure.of = table.text("of", ""), figure.title = table.text("title"), figure.text = table.text("text", "");
    figure.why = table.text("why", ""), figure.pictures = table.texts("pictures");
    for (StudyTable& value : table.tables("value")) figure.values.push_back(read_value(value));
    std::set<std::string> known = before;
    known.insert("here");
    for (const std::string& picture : figure.pictures) check_names(table, picture, known);
    for (const FigureValue& value : figure.values) check_names(table, value.file, known);
    table.done();
    out.figures.push_back(std::move(figure));
  }
  if (out.steps.empty()) root.problem("", "an experiment has steps", "none", "add [[step]] with name and run");
  root.done();
  root.throw_if_any();
  return out;
}

}  // namespace raycube::experiment
