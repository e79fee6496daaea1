// PoCL asserts or aborts when a file of its kernel cache is damaged, and LLVM's own SIGABRT handler keeps ours from
// being called. So the program brings its own abort and __assert_fail, which libraries loaded into it call in place of
// libc's. raycube itself calls neither (base::install_signal_handlers takes std::terminate), so an abort is a
// library's.
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <unistd.h>

#include "host/base/crash_report.h"
#include "host/base/interrupt.h"
#include "host/base/memory.h"

namespace {

/// Whether the user has named a folder for the driver's kernels: later raycube names its own (kernel_cache.h).
const bool users_cache = std::getenv("POCL_CACHE_DIR") != nullptr;

/// Whether a folder of PATH has this program. Allocates nothing.
bool path_has(const char* program) noexcept {
  const char* folder = std::getenv("PATH");
  while (folder && *folder) {
    const std::size_t length = std::strcspn(folder, ":");
    char file[4096];
    if (std::snprintf(file, sizeof file, "%.*s/%s", static_cast<int>(length), folder, program) < int{sizeof file} &&
        ::access(file, X_OK) == 0)
      return true;
    folder += length + (folder[length] == ':');
  }
  return false;
}

/// The error of a library that gave up, by what it most likely lacks.
[[noreturn]] void blame() noexcept {
  using raycube::base::Fault;
  using raycube::base::leave_at_once;
  char text[400];
  if (const auto limit = raycube::base::address_space_limit_bytes(); limit > 0) {
    std::snprintf(text, sizeof text,
                  "a library ended the program, most likely the OpenCL driver for want of memory: this process may "
                  "take %.3g MiB of address space (ulimit -v); what the library said stands above",
                  static_cast<double>(limit) / (1 << 20));
    leave_at_once(text, Fault::environment);
  }
  if (!path_has("ld"))
    leave_at_once(
        "a library ended the program, most likely the OpenCL driver PoCL, which links kernels by the program 'ld': no "
        "folder of PATH has it. Install it (on Debian: apt-get install binutils), or add its folder to PATH; what the "
        "library said stands above",
        Fault::environment);
  if (users_cache)
    leave_at_once(
        "a library ended the program, most likely the OpenCL driver; what it said stands above. A damaged kernel cache "
        "of your own does that: remove the folder that POCL_CACHE_DIR names or unset it (raycube's own cache is "
        "checked), and run again",
        Fault::device);
  leave_at_once("a library ended the program, most likely the OpenCL driver; what it said stands above", Fault::device);
}

}  // namespace

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
  blame();
}

[[noreturn]] void __assert_fail(const char* assertion, const char* file, unsigned line, const char* function) noexcept {
  if (!raycube::base::is_helper())
    std::fprintf(stderr, "%s:%u: %s: assertion `%s' failed\n", file, line, function, assertion);
  abort();
}
}
