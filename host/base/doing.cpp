#include "host/base/doing.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include <unistd.h>

namespace raycube::base {
namespace {

constexpr std::size_t kTextBytes = 192, kLaunches = 8;

struct Slot {
  std::atomic<int> state{0};  // 0 free, 1 being filled, 2 holds a text
  std::atomic<std::uint64_t> number{0};
  char text[kTextBytes];
};
std::array<Slot, 64> slots;
std::atomic<std::uint64_t> begun{0};

/// Names of kernels, the oldest overwritten. A crash while one is written shows a torn name, nothing worse.
struct Launch {
  char text[48];
};
std::array<Launch, kLaunches> launches;
std::atomic<std::uint64_t> launched{0};

/// The end of what was written into `to`, which stays a string.
char* put(char* to, const char* end, std::string_view text) noexcept {
  const std::size_t count = end - to > 1 ? std::min(text.size(), static_cast<std::size_t>(end - to - 1)) : 0;
  if (count == 0) return to;
  std::memcpy(to, text.data(), count);
  to[count] = 0;
  return to + count;
}

}  // namespace

Doing::Doing(std::string_view what, std::string_view name) noexcept {
  for (int i = 0; i < static_cast<int>(slots.size()); ++i) {
    Slot& slot = slots[i];
    int free = 0;
    if (!slot.state.compare_exchange_strong(free, 1)) continue;
    char thread[24];
    std::snprintf(thread, sizeof thread, "thread %d: ", static_cast<int>(::gettid()));
    const char* end = slot.text + kTextBytes;
    slot.text[0] = 0;
    char* to = put(put(slot.text, end, thread), end, what);
    if (!name.empty()) put(put(put(to, end - 1, " '"), end - 1, name), end, "'");
    slot.number = ++begun;
    slot.state = 2;
    slot_ = i;
    return;
  }
}

Doing::~Doing() {
  if (slot_ >= 0) slots[slot_].state = 0;
}

void remember_launch(std::string_view kernel) noexcept {
  Launch& launch = launches[launched.fetch_add(1) % kLaunches];
  put(launch.text, launch.text + sizeof launch.text, kernel);
}

void each_doing(void (*line)(const char* text)) noexcept {
  for (std::uint64_t last = 0;;) {
    const Slot* next = nullptr;
    for (const Slot& slot : slots)
      if (slot.state.load() == 2 && slot.number > last && (!next || slot.number < next->number)) next = &slot;
    if (!next) break;
    last = next->number;
    line(next->text);
  }
  const std::uint64_t count = launched.load();
  if (count == 0) return;
  char text[kLaunches * sizeof(Launch) + 64];
  char* to = put(text, text + sizeof text, "kernels launched last:");
  for (std::uint64_t i = count - std::min<std::uint64_t>(count, kLaunches); i < count; ++i)
    to = put(put(to, text + sizeof text, " "), text + sizeof text, launches[i % kLaunches].text);
  line(text);
}

}  // namespace raycube::base
