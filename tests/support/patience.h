// A limit on what a test waits for, which ends the test program and says what did not come. It is there for a test that
// hangs, not to measure: a machine that is slow or busy stays far from it, and CTest's own limit, which cannot say what
// was waited for, comes later (tests/CMakeLists.txt).
#pragma once

#include <csignal>
#include <cstdio>
#include <cstdlib>

#include <unistd.h>

namespace raycube::testing {

class Patience {
 public:
  explicit Patience(const char* what) {
    const char* const seconds = std::getenv("RAYCUBE_TEST_PATIENCE_S");
    const unsigned limit_s = seconds ? static_cast<unsigned>(std::atoi(seconds)) : 600;
    size_ = std::snprintf(text_, sizeof text_, "waited %u s in vain for %s\n", limit_s, what);
    std::signal(SIGALRM, end_in_vain);
    ::alarm(limit_s);
  }
  ~Patience() { ::alarm(0); }
  Patience(const Patience&) = delete;
  Patience& operator=(const Patience&) = delete;

 private:
  static void end_in_vain(int) {
    static_cast<void>(!::write(STDERR_FILENO, text_, static_cast<std::size_t>(size_)));
    ::_exit(1);
  }
  static inline char text_[256] = "";
  static inline int size_ = 0;
};

}  // namespace raycube::testing
