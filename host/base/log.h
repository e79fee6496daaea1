// Messages to people on stderr, and the same events as JSON lines in a file for programs. One object per run, passed by
// reference; results never go through it.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace raycube::base {

enum class Level { error, warning, info, detail, debug };

struct LogOptions {
  /// Shown on stderr: -2 errors, -1 and warnings, 0 and info, 1 and detail, 2 and debug.
  int verbosity = 0;
  /// JSON lines are appended here, every level; empty: none.
  std::string json_file;
};

/// Thread-safe. Construction throws Error(environment) when the JSON file cannot be opened.
class Log {
 public:
  explicit Log(const LogOptions& options = {});
  ~Log();
  Log(const Log&) = delete;
  Log& operator=(const Log&) = delete;

  void message(Level level, const std::string& text);
  void error(const std::string& text) { message(Level::error, text); }
  void warning(const std::string& text) { message(Level::warning, text); }
  void info(const std::string& text) { message(Level::info, text); }
  void detail(const std::string& text) { message(Level::detail, text); }
  void debug(const std::string& text) { message(Level::debug, text); }

  /// A numbered event for programs only: {"event": name, key: value ...} in the JSON file, nothing on stderr.
  void event(const std::string& name, const std::vector<std::pair<std::string, double>>& values);

  /// The line at the bottom of a terminal that messages scroll past (a progress bar); empty text removes it. Ignored
  /// when stderr is no terminal or info is not shown.
  void set_status(const std::string& line);

  bool shows(Level level) const;
  bool on_terminal() const;
  /// Columns of the terminal; 80 when unknown.
  int columns() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::base
