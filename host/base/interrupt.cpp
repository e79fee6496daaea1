#include "host/base/interrupt.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <exception>
#include <string_view>

#include <unistd.h>

#include "host/base/error.h"

namespace raycube::base {
namespace {

struct Temporary {
  std::atomic<int> state{0};  // 0 free, 1 being filled or emptied, 2 holds a path
  char path[4096];
};
std::array<Temporary, 64> temporaries;
std::atomic<int> arrived{0};
std::atomic<bool> helper{false};
static_assert(std::atomic<int>::is_always_lock_free, "the handler needs lock-free flags");

extern "C" void raycube_on_nothing(int) {}

extern "C" void raycube_on_signal(int number) {
  int none = 0;
  if (arrived.compare_exchange_strong(none, number)) return;
  remove_temporaries();
  ::_exit(static_cast<int>(Fault::interrupted));
}

[[noreturn]] void on_terminate() noexcept {
  leave_at_once("our bug, please report it with the command and its input: std::terminate was called", Fault::bug);
}

}  // namespace

void remove_temporaries() noexcept {
  for (auto& file : temporaries)
    if (file.state.load() == 2) ::unlink(file.path);
}

void leave_at_once(std::string_view message, Fault fault) noexcept {
  if (helper) ::_exit(static_cast<int>(Fault::bug));
  remove_temporaries();
  for (const std::string_view part : {std::string_view("raycube: error: "), message, std::string_view("\n")})
    if (::write(STDERR_FILENO, part.data(), part.size()) < 0) break;
  ::_exit(static_cast<int>(fault));
}

void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = raycube_on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  ::sigaction(SIGINT, &action, nullptr);
  ::sigaction(SIGTERM, &action, nullptr);
  struct sigaction before {};
  if (::sigaction(SIGHUP, nullptr, &before) != 0 || before.sa_handler != SIG_IGN) ::sigaction(SIGHUP, &action, nullptr);
  // A handler and not SIG_IGN: programs that this one starts then find them as they were.
  action.sa_handler = raycube_on_nothing;
  ::sigaction(SIGXFSZ, &action, nullptr);
  ::sigaction(SIGPIPE, &action, nullptr);
  // A caller may have ignored it, and exec keeps that: then no child could be waited for.
  ::signal(SIGCHLD, SIG_DFL);
  std::set_terminate(on_terminate);
}

bool interrupted() noexcept { return arrived.load(std::memory_order_relaxed) != 0; }

bool interrupted_by_now() noexcept {
  for (int glance = 0; glance < 50 && !interrupted(); ++glance) ::usleep(5000);
  return interrupted();
}

std::string interrupt_text() {
  const int number = arrived.load();
  const char* const name = number == SIGTERM  ? "SIGTERM"
                           : number == SIGHUP ? "SIGHUP (its terminal is gone)"
                                              : "Ctrl-C";
  return std::string("interrupted by ") + name + "; unfinished output was removed";
}

void throw_if_interrupted() {
  if (interrupted()) throw Error(Fault::interrupted, interrupt_text());
}

void become_helper() noexcept {
  helper = true;
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGXFSZ, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
    ::signal(number, SIG_DFL);
}

bool is_helper() noexcept { return helper; }

void clear_interrupt() noexcept { arrived = 0; }

TemporaryPath::TemporaryPath(const std::string& path) noexcept {
  if (path.size() >= sizeof(Temporary::path)) return;
  for (int i = 0; i < static_cast<int>(temporaries.size()); ++i) {
    int free = 0;
    if (!temporaries[i].state.compare_exchange_strong(free, 1)) continue;
    std::memcpy(temporaries[i].path, path.c_str(), path.size() + 1);
    temporaries[i].state = 2;
    slot_ = i;
    return;
  }
}

TemporaryPath::~TemporaryPath() {
  if (slot_ >= 0) temporaries[slot_].state = 0;
}

}  // namespace raycube::base
