// Help, man page and machine-readable usage, all written from the verbs' option tables.
#pragma once

#include <string>
#include <vector>

#include "host/cli/verb.h"

namespace raycube::cli {

/// The option rows of a verb: its own, then the common ones it obeys. `values` must outlive the table.
base::OptionTable table_of(const Verb& verb, CommonOptions& values);

/// `raycube --help`.
std::string program_help(const std::vector<Verb>& verbs);
/// `raycube NAME --help`; path is "render" or "atmos build".
std::string verb_help(const std::string& path, const Verb& verb);
/// One JSON document: every verb and option with type, unit, default, range and help.
std::string json_usage(const std::vector<Verb>& verbs);
/// raycube(1) in troff.
std::string man_page(const std::vector<Verb>& verbs);

/// The candidate closest to `typed`; empty when none is within an edit distance of 2 or a third of its length (1 up to
/// 3 letters).
std::string nearest(const std::string& typed, const std::vector<std::string>& candidates);

/// Exit statuses, one line each.
struct ExitStatus {
  int status;
  const char* text;
};
const std::vector<ExitStatus>& exit_statuses();

/// Environment variables the program reads.
struct EnvironmentVariable {
  const char* name;
  const char* text;
};
const std::vector<EnvironmentVariable>& environment_variables();

}  // namespace raycube::cli
