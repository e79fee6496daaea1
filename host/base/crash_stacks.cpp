// A stack for signal handlers in every thread: the system keeps that setting per thread, and those of OpenCL
// drivers are started by the drivers. So the program brings its own pthread_create, which libraries find
// before libc's, and which calls libc's.
#include <csignal>
#include <cstddef>
#include <memory>
#include <new>

#include <dlfcn.h>
#include <pthread.h>
#include <sys/mman.h>

#include "host/base/crash_report.h"

namespace raycube::base {

constexpr std::size_t kStackBytes = std::size_t{128}
                                    << 10;  ///< the unwinder's and the dynamic linker's frames, with room

CrashStack::CrashStack() noexcept {
  void* memory =
      ::mmap(nullptr, kStackBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (memory == MAP_FAILED) return;
  stack_t stack{};
  stack.ss_sp = memory;
  stack.ss_size = kStackBytes;
  if (::sigaltstack(&stack, nullptr) == 0) {
    memory_ = memory;
  } else {
    ::munmap(memory, kStackBytes);
  }
}

CrashStack::~CrashStack() {
  if (!memory_) return;
  stack_t none{};
  none.ss_flags = SS_DISABLE;
  if (::sigaltstack(&none, nullptr) == 0) ::munmap(memory_, kStackBytes);
}

}  // namespace raycube::base

#if !defined(__SANITIZE_ADDRESS__)

namespace {

using Body = void* (*)(void*);
using Create = int (*)(pthread_t*, const pthread_attr_t*, Body, void*);

struct Start {
  Body body;
  void* argument;
};

void* with_crash_stack(void* given) {
  const Start start = *std::unique_ptr<Start>(static_cast<Start*>(given));
  const raycube::base::CrashStack stack;
  return start.body(start.argument);
}

}  // namespace

extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, Body body, void* argument) noexcept {
  static const auto create = reinterpret_cast<Create>(::dlsym(RTLD_NEXT, "pthread_create"));
  auto* start = new (std::nothrow) Start{body, argument};
  if (!start) return create(thread, attributes, body, argument);
  const int status = create(thread, attributes, with_crash_stack, start);
  if (status != 0) delete start;
  return status;
}

#endif
