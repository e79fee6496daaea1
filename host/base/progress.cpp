#include "host/base/progress.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <mutex>

#include <fmt/format.h>

namespace raycube::base {
namespace {

constexpr double kTerminalInterval_s = 0.1, kPlainInterval_s = 5;

double steady_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

std::string format_duration(double seconds) {
  const auto s = static_cast<std::uint64_t>(std::llround(std::clamp(seconds, 0.0, 1e12)));
  if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  return fmt::format("{}:{:02}", s / 60, s % 60);
}

std::string progress_text(const std::string& what, std::uint64_t done, std::uint64_t total, const std::string& unit,
                          double elapsed_s, int columns) {
  const double share = total == 0 ? 1.0 : static_cast<double>(done) / static_cast<double>(total);
  const std::string head = fmt::format("{} {:3} %", what, static_cast<int>(std::floor(share * 100)));
  std::string tail = fmt::format("{}/{} {}", done, total, unit);
  if (done > 0 && elapsed_s > 0) {
    const double rate = static_cast<double>(done) / elapsed_s;
    tail += fmt::format(", {:.3g} {}/s", rate, unit);
    tail += done < total ? fmt::format(", {} left", format_duration(static_cast<double>(total - done) / rate))
                         : fmt::format(", took {}", format_duration(elapsed_s));
  }
  const int bar = std::min(columns - static_cast<int>(head.size() + tail.size()) - 5, 40);
  if (bar < 5) return head + " " + tail;
  const int full = static_cast<int>(share * bar);
  return fmt::format("{} [{}{}{}] {}", head, std::string(full, '='), full < bar ? ">" : "",
                     std::string(full < bar ? bar - full - 1 : 0, ' '), tail);
}

struct Progress::State {
  Log& log;
  std::string what, unit;
  std::uint64_t total, done = 0;
  Clock clock;
  double start_s, reported_s;
  std::mutex mutex;
};

Progress::Progress(Log& log, std::string what, std::uint64_t total, std::string unit, Clock clock) {
  if (!clock) clock = steady_seconds;
  const double now_s = clock();
  state_.reset(new State{log, std::move(what), std::move(unit), total, 0, std::move(clock), now_s, now_s, {}});
  if (log.on_terminal()) log.set_status(progress_text(state_->what, 0, total, state_->unit, 0, log.columns()));
}

Progress::~Progress() { state_->log.set_status(""); }

void Progress::advance(std::uint64_t more) {
  State& s = *state_;
  const std::lock_guard lock(s.mutex);
  s.done += more;
  const double now_s = s.clock();
  const bool bar = s.log.on_terminal();
  const bool finished = s.done >= s.total;
  if (!finished && now_s - s.reported_s < (bar ? kTerminalInterval_s : kPlainInterval_s)) return;
  s.reported_s = now_s;
  const double elapsed_s = now_s - s.start_s;
  if (bar) s.log.set_status(progress_text(s.what, s.done, s.total, s.unit, elapsed_s, s.log.columns()));
  if (!bar || finished) {
    s.log.set_status("");
    s.log.info(progress_text(s.what, s.done, s.total, s.unit, elapsed_s, 0));
  }
  s.log.event(
      "progress",
      {{"done", static_cast<double>(s.done)}, {"total", static_cast<double>(s.total)}, {"elapsed_s", elapsed_s}});
}

}  // namespace raycube::base
