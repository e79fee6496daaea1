// How far a long step has come: a bar with rate and time left on a terminal, a plain line now and then otherwise.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host/base/log.h"

namespace raycube::base {

/// The text of one report: "render spectir  42 % [=====>     ] 134/320 lines, 12.4 lines/s, 0:15 left". columns = 0
/// leaves the bar out. Time left comes from the mean rate so far; it is omitted while nothing is done.
std::string progress_text(const std::string& what, std::uint64_t done, std::uint64_t total, const std::string& unit,
                          double elapsed_s, int columns);

/// "0:15", "12:03", "3:07:40".
std::string format_duration(double seconds);

/// Thread-safe. Reports at most ten times a second on a terminal and every 5 s otherwise, with the same figures as a
/// "progress" event in the JSON log. The destructor removes the bar.
class Progress {
 public:
  using Clock = std::function<double()>;  ///< seconds since anything
  Progress(Log& log, std::string what, std::uint64_t total, std::string unit, Clock clock = {});
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void advance(std::uint64_t more = 1);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raycube::base
