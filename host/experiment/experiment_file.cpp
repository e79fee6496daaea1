#include "host/experiment/experiment_file.h"

#include <set>

#include "host/experiment/result_files.h"
#include "host/experiment/step_reader.h"
#include "host/experiment/study_keys.h"

namespace raycube::experiment {
namespace {

FigureValue read_value(StudyTable& table) {
  FigureValue out;
  out.name = table.text("name"), out.file = table.text("file"), out.at = table.text("at");
  out.unit = table.text("unit"), out.times = table.number("times");
  out.digits = static_cast<int>(table.number("digits"));
  if (table.has("published")) out.published = table.text("published");
  check_place(table, "at", out.at);
  return out;
}

}  // namespace

Experiment read_experiment(const std::string& file) {
  StudyTable root = StudyTable::read(file, experiment_format());
  Experiment out;
  out.file = file, out.folder = root.folder();
  out.title = root.text("title"), out.text = root.text("text"), out.source = root.text("source");
  std::set<std::string> known;
  for (StudyTable& table : root.tables("step")) out.steps.push_back(read_step(table, known));
  for (StudyTable& table : root.tables("figure")) {
    Figure figure;
    figure.where = table.where().text();
    figure.of = table.text("of"), figure.title = table.text("title"), figure.text = table.text("text");
    figure.why = table.text("why"), figure.pictures = table.texts("pictures");
    for (StudyTable& value : table.tables("value")) figure.values.push_back(read_value(value));
    for (const std::string& picture : figure.pictures) check_names(table, picture, known);
    for (const FigureValue& value : figure.values) check_names(table, value.file, known);
    out.figures.push_back(std::move(figure));
  }
  if (out.steps.empty()) root.problem("", "an experiment has steps", "none", "add [[step]] with name and run");
  root.throw_if_any();
  return out;
}

}  // namespace raycube::experiment
