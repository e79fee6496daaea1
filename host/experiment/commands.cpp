#include "host/experiment/commands.h"

#include <sys/wait.h>

#include <deque>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/base/error.h"
#include "host/base/guarded_program.h"
#include "host/base/interrupt.h"

namespace raycube::experiment {
namespace {

constexpr std::size_t kLastLines = 12;

std::string last_lines(const std::string& file) {
  std::ifstream in(file);
  std::deque<std::string> lines;
  for (std::string line; std::getline(in, line);) {
    lines.push_back(line);
    if (lines.size() > kLastLines) lines.pop_front();
  }
  return fmt::format("{}", fmt::join(lines, "\n"));
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
  base::Started started{command, folder, out, err, true};
  if (command.front() == "raycube") started.words.front() = std::filesystem::read_symlink("/proc/self/exe").string();
  const int status = base::run_guarded(started);
  base::throw_if_interrupted();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  if (WIFEXITED(status) && WEXITSTATUS(status) == base::kNotStarted)
    throw base::Error(
        base::Fault::input,
        fmt::format("{}: cannot be started in {}; name a program, \"raycube\" is this one", command.front(), folder));
  const std::string how = WIFEXITED(status) ? fmt::format("ended with status {}", WEXITSTATUS(status))
                                            : fmt::format("was ended by signal {}", WTERMSIG(status));
  throw base::Error(base::Fault::check, fmt::format("`{}` {}; its last words ({}):\n{}", fmt::join(command, " "), how,
                                                    err, last_lines(err)));
}

}  // namespace raycube::experiment
