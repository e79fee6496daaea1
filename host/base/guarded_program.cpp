#include "host/base/guarded_program.h"

#include <cerrno>
#include <csignal>
#include <cstring>

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/error.h"
#include "host/base/interrupt.h"

namespace raycube::base {
namespace {

constexpr int kLook_ms = 5;      ///< between two looks at what has ended
constexpr int kGrace_ms = 3000;  ///< from being told to end to being killed
constexpr char kEndIt = 'e', kGoOn = 0;

Error cannot(const std::string& program, const char* what) {
  return Error(Fault::environment, program + ": no process could be " + what + ": " + std::strerror(errno));
}

struct Pipe {
  int read = -1, write = -1;
  bool open() {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) return false;
    read = ends[0], write = ends[1];
    return true;
  }
  static void close(int& end) {
    if (end >= 0) ::close(end);
    end = -1;
  }
  ~Pipe() { close(read), close(write); }
};

/// What the processes need, prepared before the first fork: behind it only what a signal handler may do is allowed.
struct Prepared {
  const Started& started;
  std::vector<char*> arguments;
  sigset_t mask_before;
  bool hangup_ignored;  ///< as under nohup
  Pipe life, result;    ///< our end and orders are heard by the first; how it ended by the second
};

/// In the grandchild: becomes the program.
[[noreturn]] void become(const Prepared& p, pid_t guard) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // only where somebody kills the guard
  ::setpgid(0, 0);
  if (::getppid() != guard) ::_exit(kNotStarted);
  for (const int number : {SIGINT, SIGTERM, SIGPIPE, SIGXFSZ, SIGCHLD}) ::signal(number, SIG_DFL);
  ::signal(SIGHUP, p.hangup_ignored ? SIG_IGN : SIG_DFL);
  ::sigprocmask(SIG_SETMASK, &p.mask_before, nullptr);
  const auto take = [](const char* path, int flags, int to) {
    const int file = ::open(path, flags, 0666);
    return file >= 0 && ::dup2(file, to) >= 0;
  };
  const int append = O_WRONLY | O_CREAT | O_APPEND;
  const Started& s = p.started;
  if ((s.folder.empty() || ::chdir(s.folder.c_str()) == 0) && (!s.reads_nothing || take("/dev/null", O_RDONLY, 0)) &&
      (s.out.empty() || take(s.out.c_str(), append, 1)) && (s.err.empty() || take(s.err.c_str(), append, 2)))
    ::execvp(p.arguments[0], p.arguments.data());
  ::_exit(kNotStarted);
}

/// What the parent says within a moment: an order, kGoOn, or -1 when it is gone.
int heard(int life, int milliseconds) {
  pollfd from{life, POLLIN, 0};
  if (::poll(&from, 1, milliseconds) != 1) return kGoOn;
  char order = kGoOn;
  const ssize_t got = ::read(life, &order, 1);
  return got < 0 ? int{kGoOn} : got == 0 ? -1 : int{order};
}

/// Nobody waits any more: the program and all of its group end.
[[noreturn]] void end_group(pid_t program) {
  ::kill(-program, SIGTERM);
  for (int waited = 0; waited < kGrace_ms; waited += kLook_ms) {
    while (::waitpid(-1, nullptr, WNOHANG) > 0) continue;
    if (::kill(-program, 0) != 0) break;
    ::poll(nullptr, 0, kLook_ms);
  }
  ::kill(-program, SIGKILL);
  ::_exit(0);
}

/// In the child: starts the program and waits for its end and for ours.
[[noreturn]] void guard(Prepared& p) {
  ::setpgid(0, 0);  // Ctrl-C of a terminal comes by us
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(number, SIG_IGN);
  ::sigprocmask(SIG_SETMASK, &p.mask_before, nullptr);
  Pipe::close(p.life.write), Pipe::close(p.result.read);
  // What the program starts and leaves behind is found again here.
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  const pid_t self = ::getpid(), program = ::fork();
  if (program == 0) become(p, self);
  if (program < 0) ::_exit(1);
  ::setpgid(program, program);
  int status = 0;
  for (pid_t ended = 0; ended != program;) {
    const int order = heard(p.life.read, kLook_ms);
    if (order < 0) end_group(program);
    if (order == kEndIt) ::kill(-program, SIGTERM);
    for (pid_t any = 0; ended != program && (any = ::waitpid(-1, &status, WNOHANG)) > 0;) ended = any;
  }
  while (::write(p.result.write, &status, sizeof status) < 0 && errno == EINTR) continue;
  ::_exit(0);
}

/// In the parent: until the guard says how the program ended. Whether it did.
bool wait_for_end(Prepared& p, int& status) {
  for (bool told = false;;) {
    pollfd from{p.result.read, POLLIN, 0};
    if (::poll(&from, 1, kLook_ms) == 1) {
      const ssize_t got = ::read(p.result.read, &status, sizeof status);
      if (got < 0 && errno == EINTR) continue;
      return got == sizeof status;
    }
    if (interrupted() && !told) told = ::write(p.life.write, &kEndIt, 1) == 1;
  }
}

}  // namespace

int run_guarded(const Started& started) {
  Prepared p{started, {}, {}, false, {}, {}};
  for (const std::string& word : started.words) p.arguments.push_back(const_cast<char*>(word.c_str()));
  p.arguments.push_back(nullptr);
  struct sigaction hangup {};
  p.hangup_ignored = ::sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler == SIG_IGN;
  const std::string& name = started.words.front();
  if (!p.life.open() || !p.result.open()) throw cannot(name, "prepared");
  // No signal reaches the guard before it passes over them: our handler would take our temporaries away.
  sigset_t all;
  ::sigfillset(&all);
  ::pthread_sigmask(SIG_SETMASK, &all, &p.mask_before);
  const pid_t child = ::fork();
  if (child == 0) guard(p);
  const int failed = errno;
  ::pthread_sigmask(SIG_SETMASK, &p.mask_before, nullptr);
  errno = failed;
  if (child < 0) throw cannot(name, "made");
  Pipe::close(p.life.read), Pipe::close(p.result.write);
  int status = 0;
  const bool ended = wait_for_end(p, status);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) continue;
  if (!ended) throw Error(Fault::environment, name + ": the process that waits for its end was killed");
  return status;
}

}  // namespace raycube::base
