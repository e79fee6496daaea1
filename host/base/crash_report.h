// What a process that a signal ends leaves on stderr: which signal, what its threads were doing, the stack.
// Nothing here allocates or locks once it is installed, but for what the unwinder does; should that hang, a
// clock ends it.
#pragma once

#include <string_view>

namespace raycube::base {

/// From now on SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGABRT print a report and remove the registered
/// temporaries (interrupt.h) before they end the process, whose status stays the signal's. Call it first in
/// main(). Every thread that starts later, those of libraries too, gets a stack of its own for the handler
/// (crash_stacks.cpp), so that a stack that overflows is reported as well. Under the address sanitizer it
/// does nothing: that reports such signals itself.
void install_crash_report();

/// Gives the calling thread its stack for handlers; for threads that started before install_crash_report().
class CrashStack {
 public:
  CrashStack() noexcept;
  ~CrashStack();
  CrashStack(const CrashStack&) = delete;
  CrashStack& operator=(const CrashStack&) = delete;

 private:
  void* memory_ = nullptr;
};

/// Prints what the threads were doing and the calling thread's stack. Safe in a signal handler.
void print_stack() noexcept;

/// The report of SIGABRT, for a replacement of abort(): then the process ends by that signal, whoever has
/// taken its handler.
[[noreturn]] void end_by_abort() noexcept;

}  // namespace raycube::base
