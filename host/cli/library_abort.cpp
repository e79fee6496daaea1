// PoCL asserts or aborts when a file of its kernel cache is damaged, and LLVM's own SIGABRT handler keeps ours from
// being called. So the program brings its own abort and __assert_fail, which libraries loaded into it call in place of
// libc's. raycube itself calls neither (base::install_signal_handlers takes std::terminate), so an abort is a
// library's.
#include <cstdio>
#include <cstdlib>

#include "host/base/crash_report.h"
#include "host/base/interrupt.h"

extern "C" {

[[noreturn]] void abort() noexcept {
  // What became of a child that reads a file its parent says.
  if (raycube::base::is_helper()) raycube::base::leave_at_once("", raycube::base::Fault::bug);
  // Ctrl-C ends the programs that a driver's compiler calls, and the driver gives up: that is no fault of the
  // device.
  if (raycube::base::interrupted_by_now())
    raycube::base::leave_at_once("interrupted by Ctrl-C; unfinished output was removed",
                                 raycube::base::Fault::interrupted);
  raycube::base::print_stack();
  raycube::base::leave_at_once(
      "a library ended the program, most likely the OpenCL driver; what it said stands above. A damaged kernel cache "
      "of your own does "
      "that: where POCL_CACHE_DIR is set, remove that folder or unset it (raycube's own cache is checked), and run "
      "again",
      raycube::base::Fault::device);
}

[[noreturn]] void __assert_fail(const char* assertion, const char* file, unsigned line, const char* function) noexcept {
  if (!raycube::base::is_helper())
    std::fprintf(stderr, "%s:%u: %s: assertion `%s' failed\n", file, line, function, assertion);
  abort();
}
}
