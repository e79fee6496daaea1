// Programs that are started and waited for: what they inherit, and that nothing of them outlives an order to end, goes
// on after Ctrl-Z or fails to start without its cause. Oracle: /proc.
#include "host/base/guarded_program.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <csignal>
#include <functional>

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "tests/support/patience.h"
#include "tests/unit/test_folder.h"

using namespace raycube::base;
using raycube::testing::Patience;
using raycube::testing::TestFolder;

namespace {

/// The state letter of a process; Z also of one that is gone.
char state_of(const std::string& pid) {
  std::ifstream in("/proc/" + pid + "/stat");
  std::string line;
  if (!std::getline(in, line)) return 'Z';
  return line[line.rfind(')') + 2];
}

void until(const char* what, const std::function<bool()>& is) {
  const Patience patience(what);
  while (!is()) ::usleep(2000);
}

/// In a child: runs a shell's script in a folder, as the program's signal handlers have it; exits with its status.
pid_t start(const TestFolder& folder, const std::string& script) {
  const pid_t child = ::fork();
  if (child != 0) return child;
  install_signal_handlers();
  int status = 99;
  try {
    const int ended = run_guarded({{"sh", "-c", script}, folder.path.string(), "", "", false});
    status = WIFEXITED(ended) ? WEXITSTATUS(ended) : 100 + WTERMSIG(ended);
  } catch (...) {
  }
  ::_exit(status);
}

std::string pid_in(const TestFolder& folder, const char* what) {
  until(what, [&] { return folder.read("pid").ends_with('\n'); });
  const std::string text = folder.read("pid");
  return text.substr(0, text.size() - 1);
}

/// Exit status of a child.
int end_of(pid_t child) {
  const Patience patience("the end of what waits for the program");
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t out = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++out;
  return out;
}

}  // namespace

TEST_CASE("after a signal nothing of the program's group is left, though the program itself has ended of it") {
  const TestFolder folder;
  const pid_t child = start(folder, "(trap '' TERM; sh -c 'echo $$ > pid; exec sleep 3600') & wait");
  const std::string left = pid_in(folder, "the program's child");
  ::kill(child, SIGTERM);
  CHECK(end_of(child) == 100 + SIGTERM);  // handed on, and said before the rest has ended
  CHECK(state_of(left) == 'Z');           // and not before that do we go on
  if (state_of(left) != 'Z') ::kill(std::stoi(left), SIGKILL);
}

TEST_CASE("what a program leaves behind by itself is let alone") {
  const TestFolder folder;
  const pid_t child = start(folder, "sleep 3600 & echo $! > pid; exit 3");
  CHECK(end_of(child) == 3);
  const std::string left = pid_in(folder, "the program's child");
  CHECK(state_of(left) != 'Z');
  ::kill(std::stoi(left), SIGKILL);
}

TEST_CASE("Ctrl-Z halts the program and goes on with it; a halted one hears an end") {
  const TestFolder folder;
  const pid_t child = start(folder, "echo $$ > pid; exec sleep 3600");
  const std::string program = pid_in(folder, "the program");
  for (const bool goes_on : {true, false}) {
    ::kill(child, SIGTSTP);
    int status = 0;
    ::waitpid(child, &status, WUNTRACED);
    CHECK(WIFSTOPPED(status));
    until("the program's halt", [&] { return state_of(program) == 'T'; });
    if (!goes_on) break;
    ::kill(child, SIGCONT);
    until("the program to go on", [&] { return state_of(program) != 'T'; });
  }
  ::kill(child, SIGKILL);  // of the halted, as by a closed terminal
  end_of(child);
  until("the end of the halted program", [&] { return state_of(program) == 'Z'; });
}

TEST_CASE("a program inherits no file of ours but its three") {
  const TestFolder folder;
  const std::string out = folder / "out", err = folder / "err";
  const int status = run_guarded({{"sh", "-c", "ls -l /proc/$$/fd; true"}, folder.path.string(), out, err, true});
  CHECK(status == 0);
  const std::string files = folder.read("out");
  CAPTURE(files);
  CHECK(count(files, "-> " + out) == 1);
  CHECK(count(files, "-> " + err) == 1);
  CHECK(count(files, " 0 -> /dev/null") == 1);
}

TEST_CASE(
    "no such program is status 127; where no process can be made, the cause is told, of the program's as of ours") {
  CHECK(WEXITSTATUS(run_guarded({{"/no/such/program"}, "", "", "", false})) == kNotStarted);
  if (::geteuid() != 0) {
    MESSAGE("SKIPPED: limits of processes are counted for a user of its own, whom only root can become");
    return;
  }
  for (const rlim_t most : {1, 2}) {  // the guard cannot be made; the program cannot
    int ends[2];
    REQUIRE(::pipe(ends) == 0);
    const pid_t child = ::fork();
    if (child == 0) {
      const rlimit limit{most, most};
      std::string said = "ended";
      try {
        if (::setresuid(64123, 64123, 64123) != 0 || ::setrlimit(RLIMIT_NPROC, &limit) != 0)
          said = "SKIPPED";
        else
          run_guarded({{"true"}, "", "", "", false});
      } catch (const Error& error) {
        said = (error.fault() == Fault::environment ? "" : "another kind: ") + std::string(error.what());
      }
      static_cast<void>(!::write(ends[1], said.data(), said.size()));
      ::_exit(0);
    }
    ::close(ends[1]);
    char text[400] = "";
    static_cast<void>(!::read(ends[0], text, sizeof text - 1));
    ::close(ends[0]), end_of(child);
    CAPTURE(most);
    if (std::string(text) == "SKIPPED")
      MESSAGE("SKIPPED: no user of its own can be had here");
    else
      CHECK(std::string(text) == "true: no process could be made: Resource temporarily unavailable");
  }
}
