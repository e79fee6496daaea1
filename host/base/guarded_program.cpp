#include "host/base/guarded_program.h"

#include <atomic>
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
constexpr int kGrace_ms = 3000;  ///< from being told to end to being killed, and from there to giving up
constexpr char kEndIt = 'e', kHalt = 'h', kContinue = 'c', kGoOn = 0;

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

/// What the guard says at the end.
struct Result {
  int status = 0;  ///< of the program, as waitpid() says it
  int error = 0;   ///< errno where no program could be made
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
    const bool taken = file >= 0 && ::dup2(file, to) >= 0;
    if (file >= 0 && file != to) ::close(file);
    return taken;
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

/// The program's time is over: it and all that is left of its group end, also what is halted. Ends when nothing
/// of it is left: what is killed takes a moment.
[[noreturn]] void end_group(pid_t program) {
  for (const int number : {SIGTERM, SIGKILL}) {
    ::kill(-program, number), ::kill(-program, SIGCONT);
    for (int waited = 0; waited < kGrace_ms; waited += kLook_ms) {
      while (::waitpid(-1, nullptr, WNOHANG) > 0) continue;
      if (::kill(-program, 0) != 0) ::_exit(0);
      ::poll(nullptr, 0, kLook_ms);
    }
  }
  ::_exit(0);
}

/// In the child: starts the program and waits for its end and for ours.
[[noreturn]] void guard(Prepared& p) {
  ::setpgid(0, 0);  // Ctrl-C of a terminal comes by us
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE}) ::signal(number, SIG_IGN);
  ::sigprocmask(SIG_SETMASK, &p.mask_before, nullptr);
  Pipe::close(p.life.write), Pipe::close(p.result.read);
  // What the program's children leave behind is waited for here, so that end_group() sees when its group is empty.
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  const pid_t self = ::getpid(), program = ::fork();
  if (program == 0) become(p, self);
  Result result;
  const auto say = [&] {
    while (::write(p.result.write, &result, sizeof result) < 0 && errno == EINTR) continue;
  };
  if (program < 0) result.error = errno, say(), ::_exit(1);
  ::setpgid(program, program);
  bool told_to_end = false;
  for (pid_t ended = 0; ended != program;) {
    const int order = heard(p.life.read, kLook_ms);
    if (order < 0) end_group(program);
    if (order == kEndIt) told_to_end = true, ::kill(-program, SIGTERM);
    if (order == kHalt) ::kill(-program, SIGSTOP);
    if (order == kContinue) ::kill(-program, SIGCONT);
    for (pid_t any = 0; ended != program && (any = ::waitpid(-1, &result.status, WNOHANG)) > 0;) ended = any;
  }
  say();
  // What the program leaves behind by itself is its own affair; what outlives an order to end is not.
  if (told_to_end) end_group(program);
  ::_exit(0);
}

/// Where the guard hears us, for the handler of Ctrl-Z; -1: no program runs.
std::atomic<int> guard_hears{-1};
static_assert(std::atomic<int>::is_always_lock_free, "the handler needs it");

extern "C" void raycube_on_halt(int) {
  const int before = errno, guard = guard_hears;
  const auto say = [&](const char& order) { return guard < 0 || ::write(guard, &order, 1) == 1; };
  say(kHalt);
  ::kill(::getpid(), SIGSTOP);  // returns when somebody continues us
  say(kContinue);
  errno = before;
}

/// While it lives, Ctrl-Z halts the program, too, whose group the terminal does not know.
class HaltsToo {
 public:
  explicit HaltsToo(int guard) {
    if (::sigaction(SIGTSTP, nullptr, &before_) != 0 || before_.sa_handler != SIG_DFL) return;
    struct sigaction action {};
    action.sa_handler = raycube_on_halt;
    ::sigemptyset(&action.sa_mask);
    action.sa_flags = SA_RESTART;
    guard_hears = guard;
    installed_ = ::sigaction(SIGTSTP, &action, nullptr) == 0;
  }
  ~HaltsToo() {
    if (installed_) ::sigaction(SIGTSTP, &before_, nullptr), guard_hears = -1;
  }
  HaltsToo(const HaltsToo&) = delete;
  HaltsToo& operator=(const HaltsToo&) = delete;

 private:
  struct sigaction before_ {};
  bool installed_ = false;
};

/// In the parent: until the guard says how the program ended. Whether it did.
bool wait_for_end(Prepared& p, Result& result) {
  for (bool told = false;;) {
    pollfd from{p.result.read, POLLIN, 0};
    if (::poll(&from, 1, kLook_ms) == 1) {
      const ssize_t got = ::read(p.result.read, &result, sizeof result);
      if (got < 0 && errno == EINTR) continue;
      return got == sizeof result;
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
  const HaltsToo halts_too(p.life.write);
  ::pthread_sigmask(SIG_SETMASK, &p.mask_before, nullptr);
  errno = failed;
  if (child < 0) throw cannot(name, "made");
  Pipe::close(p.life.read), Pipe::close(p.result.write);
  Result result;
  const bool ended = wait_for_end(p, result);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) continue;
  if (!ended) throw Error(Fault::environment, name + ": the process that waits for its end was killed");
  errno = result.error;
  if (errno != 0) throw cannot(name, "made");
  return result.status;
}

}  // namespace raycube::base
