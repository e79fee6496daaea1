// What the threads of the process are doing, kept where a crash report finds it (crash_report.h): fixed
// memory, no locks.
#pragma once

#include <cstddef>
#include <string_view>

namespace raycube::base {

/// While it lives, a crash report says that its thread is at this: "rendering instrument 'camera'". Up to 64
/// at a time are kept, further ones go unsaid; what is longer than a line's worth is cut.
class Doing {
 public:
  explicit Doing(std::string_view what, std::string_view name = {}) noexcept;
  ~Doing();
  Doing(const Doing&) = delete;
  Doing& operator=(const Doing&) = delete;

 private:
  int slot_ = -1;
};

/// Remembers a kernel as launched. A crash report names the last eight, since what a device runs returns at
/// once to whom launched it.
void remember_launch(std::string_view kernel) noexcept;

/// Calls line(text) for every Doing alive, in the order they began, then for the launches remembered. Safe in
/// a signal handler.
void each_doing(void (*line)(const char* text)) noexcept;

}  // namespace raycube::base
