// Command lines of a study: names in braces for folders and values, programs run with their words in files.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace raycube::experiment {

using Command = std::vector<std::string>;
/// Names and what stands for them: "{name}".
using Names = std::map<std::string, std::string>;

/// The text with every {name} replaced; a name that is not there: Error(input) that says which there are. "{{" is "{".
std::string with_names(const std::string& text, const Names& names, const std::string& where);
/// Names in braces of a text, in order.
std::vector<std::string> names_in(const std::string& text);

/// Runs a program (the first word; "raycube": this one) in `folder`, its stdout to one file, its stderr to another,
/// both appended to. Throws Error(check) with the last lines of stderr where it fails, Error(interrupted) after Ctrl-C,
/// which ends it as well.
void run_command(const Command& command, const std::string& folder, const std::string& out, const std::string& err);

}  // namespace raycube::experiment
