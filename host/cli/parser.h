// Turns a command line into a verb and its option values.
#pragma once

#include <string>
#include <vector>

#include "host/cli/verb.h"

namespace raycube::cli {

struct Parsed {
  const Verb* verb = nullptr;  ///< null: `text` is the whole answer
  std::string text;            ///< help, version, usage: printed on stdout
};

/// Parses argv; fills `values` and the variables the verb bound. Throws Error(input) for bad usage, with a suggestion
/// where a name was nearly right.
Parsed parse_command_line(int argc, const char* const* argv, const std::vector<Verb>& verbs, CommonOptions& values);

}  // namespace raycube::cli
