#include "host/experiment/step_reader.h"

#include <cctype>

namespace raycube::experiment {

void take_name(StudyTable& table, const std::string& name, std::set<std::string>& known) {
  static const std::set<std::string> taken = {"folder", "here", "points", "results"};
  bool sound = !name.empty() && taken.count(name) == 0;
  for (const char c : name) sound = sound && (std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-');
  if (!sound)
    table.problem("name", "a name has letters, digits, _ and -, and is not folder, here, points or results",
                  "'" + name + "'", "choose another");
  if (!known.insert(name).second) table.problem("name", "two things have one name", "'" + name + "'", "rename one");
}

void check_names(StudyTable& table, const std::string& text, const std::set<std::string>& known,
                 const std::set<std::string>& more) {
  for (const std::string& name : names_in(text))
    if (known.count(name) == 0 && more.count(name) == 0)
      table.problem("", "nothing is called {" + name + "} here", "'" + text + "'",
                    "name what stands before it, {folder} or {here}; a brace itself is {{");
}

StepPlan read_commands(StudyTable& table, const std::string& name, const std::set<std::string>& known,
                       const std::set<std::string>& more) {
  StepPlan step;
  step.where = table.where().text(), step.name = name;
  step.commands = table.commands("run"), step.inputs = table.texts("inputs");
  for (const Command& command : step.commands)
    for (const std::string& word : command) check_names(table, word, known, more);
  for (const std::string& input : step.inputs) check_names(table, input, {});
  return step;
}

StepPlan read_step(StudyTable& table, std::set<std::string>& known) {
  const std::string name = table.text("name");
  StepPlan step = read_commands(table, name, known, {"folder", "here"});
  take_name(table, name, known);
  return step;
}

}  // namespace raycube::experiment
