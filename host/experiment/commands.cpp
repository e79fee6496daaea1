#include "host/experiment/commands.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <deque>
#include <filesystem>
#include <fstream>
#include <thread>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/base/error.h"
#include "host/base/interrupt.h"

namespace raycube::experiment {
namespace {

constexpr std::size_t kLastLines = 12;
constexpr int kNotStarted = 127;  ///< as shells say it

std::string last_lines(const std::string& file) {
  std::ifstream in(file);
  std::deque<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line);
    if (lines.size() > kLastLines) lines.pop_front();
  }
  return fmt::format("{}", fmt::join(lines, "\n"));
}

/// In the child, where only what a signal handler may do is allowed: never returns. It ends with its parent, however
/// that ends, so that no step goes on that nobody waits for. status: of what could not be done.
[[noreturn]] void become(char* const* arguments, const char* folder, const char* out, const char* err, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  ::setpgid(0, 0);  // with what it starts it is told to end
  if (::getppid() != parent) ::_exit(kNotStarted);
  const auto take = [](const char* path, int flags, int to) {
    const int file = ::open(path, flags, 0666);
    return file >= 0 && ::dup2(file, to) >= 0;
  };
  const int append = O_WRONLY | O_CREAT | O_APPEND;
  if (::chdir(folder) == 0 && take("/dev/null", O_RDONLY, 0) && take(out, append, 1) && take(err, append, 2))
    ::execvp(arguments[0], arguments);
  ::_exit(kNotStarted);
}

}  // namespace

std::vector<std::string> names_in(const std::string& text) {
  std::vector<std::string> out;
  for (std::size_t at = 0; (at = text.find('{', at)) != std::string::npos;) {
    if (text.compare(at, 2, "{{") == 0) {
      at += 2;
      continue;
    }
    const std::size_t end = text.find('}', at);
    if (end == std::string::npos) break;
    out.push_back(text.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return out;
}

std::string with_names(const std::string& text, const Names& names, const std::string& where) {
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    if (text.compare(at, 2, "{{") == 0) {
      out += '{', at += 2;
      continue;
    }
    if (text[at] != '{') {
      out += text[at++];
      continue;
    }
    const std::size_t end = text.find('}', at);
    const std::string name = end == std::string::npos ? text.substr(at) : text.substr(at + 1, end - at - 1);
    const auto found = names.find(name);
    if (end == std::string::npos || found == names.end()) {
      std::string known;
      for (const auto& [one, value] : names) known += (known.empty() ? "{" : ", {") + one + "}";
      throw base::Error(base::Fault::input,
                        fmt::format("{}: '{}': nothing is called {{{}}} here; there are {} (a brace itself is {{{{)",
                                    where, text, name, known));
    }
    out += found->second;
    at = end + 1;
  }
  return out;
}

void run_command(const Command& command, const std::string& folder, const std::string& out, const std::string& err) {
  std::vector<std::string> words = command;
  if (words.front() == "raycube") words.front() = std::filesystem::read_symlink("/proc/self/exe").string();
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child == 0) become(arguments.data(), folder.c_str(), out.c_str(), err.c_str(), parent);
  if (child < 0)
    throw base::Error(base::Fault::environment,
                      command.front() + ": no process could be made: " + std::strerror(errno));
  int status = 0;
  bool told = false;
  for (pid_t ended = 0; ended != child;) {
    ended = waitpid(child, &status, WNOHANG);
    if (ended < 0 && errno != EINTR)
      throw base::Error(base::Fault::environment, command.front() + ": its end could not be waited for");
    if (base::interrupted() && !told) ::kill(-child, SIGTERM), told = true;
    if (ended != child) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  base::throw_if_interrupted();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotStarted)
    throw base::Error(
        base::Fault::input,
        fmt::format("{}: cannot be started in {}; name a program, \"raycube\" is this one", command.front(), folder));
  const std::string how = WIFEXITED(status) ? fmt::format("ended with status {}", WEXITSTATUS(status))
                                            : fmt::format("was ended by signal {}", WTERMSIG(status));
  throw base::Error(base::Fault::check, fmt::format("`{}` {}; its last words ({}):\n{}", fmt::join(command, " "), how,
                                                    err, last_lines(err)));
}

}  // namespace raycube::experiment
