#include "host/base/crash_report.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstring>

#include <execinfo.h>
#include <unistd.h>

#include "host/base/doing.h"
#include "host/base/interrupt.h"

namespace raycube::base {
namespace {

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif
constexpr std::array kSignals{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};
constexpr unsigned kPatience_s = 20;  ///< a report takes milliseconds; past this something in it waits for a lock
constexpr int kMostFrames = 64;

std::atomic<int> reporter{0};  // the thread whose report this is
std::atomic<int> ending{0};    // its signal

void say(std::string_view text) noexcept {
  while (!text.empty()) {
    const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
    if (written <= 0) return;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
}

void say_number(std::uint64_t value, unsigned base) noexcept {
  char digits[24];
  char* at = digits + sizeof digits;
  do {
    *--at = "0123456789abcdef"[value % base];
  } while (value /= base);
  say({at, static_cast<std::size_t>(digits + sizeof digits - at)});
}

void say_line(const char* text) noexcept {
  say("raycube:   ");
  say(text);
  say("\n");
}

const char* name_of(int number) noexcept {
  switch (number) {
    case SIGSEGV:
      return "SIGSEGV, a wrong address or a stack that overflowed";
    case SIGBUS:
      return "SIGBUS, a mapped file that was cut short or a memory that failed";
    case SIGFPE:
      return "SIGFPE, an integer division";
    case SIGILL:
      return "SIGILL, an instruction that this processor does not know";
    case SIGABRT:
      return "SIGABRT, a library or the program gave up";
  }
  return "a signal";
}

/// From now on the signal does what it does to a program without handlers.
void set_default(int number) noexcept {
  struct sigaction action {};
  action.sa_handler = SIG_DFL;
  sigemptyset(&action.sa_mask);
  ::sigaction(number, &action, nullptr);
  sigset_t one;
  sigemptyset(&one);
  sigaddset(&one, number);
  ::pthread_sigmask(SIG_UNBLOCK, &one, nullptr);
}

extern "C" void raycube_on_patience_lost(int) {
  set_default(ending);
  ::raise(ending);
}

/// True for the one thread that reports; false for a fault inside its own report. Other threads wait here for
/// the end.
bool claim_report(int number) noexcept {
  int nobody = 0;
  const int self = static_cast<int>(::gettid());
  if (reporter.compare_exchange_strong(nobody, self)) {
    ending = number;
    struct sigaction clock {};
    clock.sa_handler = raycube_on_patience_lost;
    sigemptyset(&clock.sa_mask);
    ::sigaction(SIGALRM, &clock, nullptr);
    ::alarm(kPatience_s);
    return true;
  }
  while (nobody != self) ::pause();
  return false;
}

void report(int number, const siginfo_t* info) noexcept {
  remove_temporaries();
  say("raycube: error: ended by signal ");
  say_number(static_cast<unsigned>(number), 10);
  say(" (");
  say(name_of(number));
  say(") in thread ");
  say_number(static_cast<std::uint64_t>(::gettid()), 10);
  if (info && info->si_code > 0) {
    say(", address 0x");
    say_number(reinterpret_cast<std::uintptr_t>(info->si_addr), 16);
  }
  say("; please report it with the command, its input and what follows\n");
  print_stack();
}

extern "C" void raycube_on_crash(int number, siginfo_t* info, void*) {
  if (claim_report(number)) report(number, info);
  set_default(number);
  // A fault comes again at its own place when this returns; what was sent has to be sent again.
  if (info->si_code <= 0) ::raise(number);
}

}  // namespace

void print_stack() noexcept {
  say("raycube: what its threads were doing:\n");
  each_doing(say_line);
  say("raycube: stack (addr2line -Cfe FILE +OFFSET names what has no name):\n");
  void* frames[kMostFrames];
  ::backtrace_symbols_fd(frames, ::backtrace(frames, kMostFrames), STDERR_FILENO);
}

void end_by_abort() noexcept {
  if (claim_report(SIGABRT)) report(SIGABRT, nullptr);
  set_default(SIGABRT);
  ::raise(SIGABRT);
  ::_exit(128 + SIGABRT);
}

void install_crash_report() {
  if (kSanitized) return;
  static const auto* main_stack = new CrashStack;  // to the very end of the process
  static_cast<void>(main_stack);
  void* first[1];
  ::backtrace(first, 1);  // loads the unwinder, which allocates
  struct sigaction action {};
  action.sa_sigaction = raycube_on_crash;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_SIGINFO | SA_ONSTACK;
  for (const int number : kSignals) ::sigaction(number, &action, nullptr);
}

}  // namespace raycube::base
