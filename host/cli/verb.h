// A verb of the command line: `raycube NAME ...`. To add one: write host/cli/verb_NAME.cpp with
//     Verb raycube::cli::verb_NAME();
// and name it in RAYCUBE_VERBS of host/cli/CMakeLists.txt. Help, man page and --json-usage follow from its option
// table.
//
//     Verb verb_example() {
//       struct Options { std::string file; double gsd_m = 1; };
//       auto o = std::make_shared<Options>();               // lives as long as the verb
//       Verb verb("example", "Say what it does in one line");
//       verb.common = kOutput | kCompute;                   // the common options it obeys
//       verb.add_options = [o](base::OptionTable& table) {
//         table.argument("FILE", "A scene file", o->file);
//         table.number("--gsd", "m", 0.001, 1e4, "Ground sample distance", o->gsd_m);
//       };
//       verb.run = [o](Invocation& invocation) { invocation.log.info("reading " + o->file); return 0; };
//       return verb;
//     }
#pragma once

#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/base/log.h"
#include "host/base/options.h"

namespace raycube::cli {

/// Common options a verb obeys; -q, -v, --log, --json and --help belong to every verb. One that it does not obey is
/// refused.
enum CommonSet : unsigned {
  kOutput = 1,    ///< -o, --overwrite
  kDryRun = 2,    ///< --dry-run
  kSeed = 4,      ///< --seed
  kDevice = 8,    ///< --device
  kThreads = 16,  ///< --threads
  kMemory = 32,   ///< --memory
  kSet = 64,      ///< --set
  kCompute = kSeed | kDevice | kThreads | kMemory
};

/// Values of the common options.
struct CommonOptions {
  std::string output;  ///< empty: the verb's own default
  bool overwrite = false;
  bool dry_run = false;
  std::optional<std::uint64_t> seed;                    ///< empty: what the file says
  std::string device;                                   ///< empty: first device; else its number or a part of its name
  std::vector<std::string> set;                         ///< KEY=VALUE in place of what a simulation file says
  int threads = 0;                                      ///< 0: as many as the machine has
  std::uint64_t memory_bytes = std::uint64_t{2} << 30;  ///< bound of host plus device memory
  int quiet = 0, verbose = 0;
  std::string log_file;
  bool json = false;  ///< the result on stdout is one JSON document
};

/// What a running verb may use. Results go to `out` (stdout), all else to `log`.
struct Invocation {
  const CommonOptions& common;
  base::Log& log;
  std::ostream& out;
  std::string command_line;  ///< as typed, for sidecars
};

struct Verb {
  Verb(std::string name_, std::string summary_) : name(std::move(name_)), summary(std::move(summary_)) {}

  std::string name;
  std::string summary;                ///< one line, imperative, no full stop
  std::string description;            ///< paragraphs of the man page, split by empty lines; may be empty
  std::vector<std::string> examples;  ///< complete commands
  unsigned common = 0;                ///< union of CommonSet
  std::string output_default;         ///< what help says of -o when it is not given; empty: nothing
  std::function<void(base::OptionTable&)> add_options;  ///< may be empty
  /// Returns 0, or 1 when a check found a difference beyond its limits; every other failure is a base::Error.
  std::function<int(Invocation&)> run;
  std::vector<Verb> verbs;  ///< second-level verbs (`raycube atmos build`); then run stays empty
};

/// Every verb of this build, in the order help shows them.
std::vector<Verb> all_verbs();

/// The one table of common options; `set` limits it to those a verb obeys.
void add_common_options(base::OptionTable& table, CommonOptions& values, unsigned set);

}  // namespace raycube::cli
