// What a run uses of the program around it, whichever that is: the command line, a bench, a test, or a program that
// links this library.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <string>

#include "host/base/log.h"

namespace raycube::run {

struct Services {
  /// Told how many more units of a step are done; its destruction ends the step's report.
  using Advance = std::function<void(std::uint64_t more)>;

  base::Log& log;
  /// Begins the report of a long step of `total` units; empty: nobody asks how far a run has come.
  std::function<Advance(const std::string& what, std::uint64_t total, const std::string& unit)> progress{};
  /// Throws what shall end the run; asked whenever a step advances. Empty: nothing but a signal ends it.
  std::function<void()> stop{};
  int threads = 0;               ///< of the host's own work; 0: as many as the machine has
  std::set<std::string> said{};  ///< notices that the log has and need not hear again

  /// A warning that several tables or instruments of a run may give: to the log once.
  void warn_once(const std::string& notice);
};

/// Those of a program that people watch: progress as base::Progress shows it, stopped by signals.
Services watched_services(base::Log& log, int threads = 0);

/// A long step of a run while it lives.
class Step {
 public:
  Step(const Services& services, const std::string& what, std::uint64_t total, const std::string& unit);
  /// Asks whether the run is to end, then tells of `more` units.
  void advance(std::uint64_t more = 1) const;

 private:
  const Services& services_;
  Services::Advance advance_;
};

}  // namespace raycube::run
