#include "host/base/log.h"

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <mutex>

#include <fcntl.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include "host/base/error.h"

namespace raycube::base {
namespace {

using OrderedJson = nlohmann::ordered_json;

const char* name_of(Level level) {
  switch (level) {
    case Level::error:
      return "error";
    case Level::warning:
      return "warning";
    case Level::info:
      return "info";
    case Level::detail:
      return "detail";
    case Level::debug:
      return "debug";
  }
  return "?";
}

/// Every line of a message carries the program's name and, for errors and warnings, the kind.
std::string for_people(Level level, const std::string& text) {
  std::string prefix = "raycube: ";
  if (level <= Level::warning) prefix += std::string(name_of(level)) + ": ";
  std::string out = prefix;
  for (const char c : text) {
    out += c;
    if (c == '\n') out += prefix;
  }
  return out;
}

std::string utc_now() {
  const auto now = std::chrono::system_clock::now();
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() % 1000;
  std::tm utc{};
  ::gmtime_r(&seconds, &utc);
  char text[40];
  const std::size_t used = std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
  std::snprintf(text + used, sizeof text - used, ".%03dZ", static_cast<int>(ms));
  return text;
}

}  // namespace

struct Log::State {
  LogOptions options;
  bool terminal = false;
  std::mutex mutex;
  std::string status;
  std::shared_ptr<spdlog::logger> people;
  int programs = -1;  ///< descriptor of the JSON file
  bool lost = false;  ///< a line of it, which was told

  /// Told once, however quiet the program is to be: whoever reads the file cannot see what is not in it.
  void write_line(const OrderedJson& line) {
    const std::string text = line.dump(-1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
    int code = 0;
    for (std::size_t done = 0; done < text.size() && code == 0;) {
      const ssize_t written = ::write(programs, text.data() + done, text.size() - done);
      if (written > 0)
        done += static_cast<std::size_t>(written);
      else if (written == 0 || errno != EINTR)
        code = written == 0 ? ENOSPC : errno;
    }
    if (code == 0 || lost) return;
    lost = true;
    clear_status();
    people->log(spdlog::level::info, for_people(Level::warning, "--log " + options.json_file +
                                                                    ": cannot be written: " + std::strerror(code) +
                                                                    "; lines of the log are lost, the run goes on"));
    draw_status();
  }

  void clear_status() {
    if (!status.empty()) std::fputs("\r\033[K", stderr);
  }
  void draw_status() {
    if (status.empty()) return;
    std::fputs(("\r" + status + "\033[K").c_str(), stderr);
    std::fflush(stderr);
  }
};

Log::Log(const LogOptions& options) : state_(std::make_unique<State>()) {
  state_->options = options;
  state_->terminal = ::isatty(STDERR_FILENO) != 0;
  state_->people = std::make_shared<spdlog::logger>("stderr", std::make_shared<spdlog::sinks::stderr_sink_mt>());
  state_->people->set_pattern("%v");
  state_->people->set_level(spdlog::level::trace);
  state_->people->flush_on(spdlog::level::trace);
  if (options.json_file.empty()) return;
  state_->programs = ::open(options.json_file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (state_->programs < 0)
    throw Error(Fault::environment, "--log " + options.json_file + ": cannot be opened: " + std::strerror(errno) +
                                        "; name a file in a folder you may write to");
}

Log::~Log() {
  set_status("");
  if (state_->programs >= 0) ::close(state_->programs);
}

bool Log::shows(Level level) const {
  return static_cast<int>(level) <= static_cast<int>(Level::info) + state_->options.verbosity;
}
bool Log::on_terminal() const { return state_->terminal; }

int Log::columns() const {
  winsize size{};
  return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

void Log::message(Level level, const std::string& text) {
  const std::lock_guard lock(state_->mutex);
  if (shows(level) || level == Level::error) {
    state_->clear_status();
    state_->people->log(spdlog::level::info, for_people(level, text));
    state_->draw_status();
  }
  if (state_->programs >= 0) state_->write_line({{"time", utc_now()}, {"level", name_of(level)}, {"message", text}});
}

void Log::event(const std::string& name, const std::vector<std::pair<std::string, double>>& values) {
  if (state_->programs < 0) return;
  OrderedJson line = {{"time", utc_now()}, {"event", name}};
  for (const auto& [key, value] : values) line[key] = value;
  const std::lock_guard lock(state_->mutex);
  state_->write_line(line);
}

void Log::set_status(const std::string& line) {
  if (!state_->terminal || !shows(Level::info)) return;
  const std::lock_guard lock(state_->mutex);
  if (line.empty()) {
    state_->clear_status();
    std::fflush(stderr);
  }
  state_->status = line;
  state_->draw_status();
}

}  // namespace raycube::base
