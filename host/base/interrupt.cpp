#include "host/base/interrupt.h"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <exception>
#include <new>
#include <string_view>

#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "host/base/error.h"
#include "host/base/memory.h"

namespace raycube::base {
namespace {

constexpr int kHolds = 2;
struct Temporary {
  std::atomic<int> state{0};  // 0 free, 1 being filled or emptied, kHolds + its Kind: holds a path
  char path[4096];
};
std::array<Temporary, 64> temporaries;
std::atomic<int> arrived{0};
std::atomic<bool> helper{false};
static_assert(std::atomic<int>::is_always_lock_free, "the handler needs lock-free flags");

/// Removes what lies in an open folder, and closes it. By system calls alone, since readdir() may wait for a lock that
/// the interrupted thread holds. Links are removed and not followed.
void empty_folder(int folder, int depth) noexcept {
  constexpr int kDeepest = 8;
  struct Entry {  // of getdents64(2)
    std::uint64_t inode;
    std::int64_t next;
    unsigned short bytes;
    unsigned char type;
    char name[1];
  };
  alignas(Entry) char room[4096];
  if (folder < 0) return;
  for (bool removed = true; removed;) {  // what is removed while it is listed may hide others
    removed = false;
    ::lseek(folder, 0, SEEK_SET);
    for (long got = 0; (got = ::syscall(SYS_getdents64, folder, room, sizeof room)) > 0;)
      for (long at = 0; at < got; at += reinterpret_cast<Entry*>(room + at)->bytes) {
        const char* const name = reinterpret_cast<Entry*>(room + at)->name;
        if (std::strcmp(name, ".") == 0 || std::strcmp(name, "..") == 0) continue;
        if (::unlinkat(folder, name, 0) == 0) {
          removed = true;
        } else if (depth < kDeepest) {
          empty_folder(::openat(folder, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC), depth + 1);
          removed = ::unlinkat(folder, name, AT_REMOVEDIR) == 0 || removed;
        }
      }
  }
  ::close(folder);
}

extern "C" void raycube_on_nothing(int) {}

extern "C" void raycube_on_signal(int number) {
  int none = 0;
  if (arrived.compare_exchange_strong(none, number)) return;
  remove_temporaries();
  ::_exit(static_cast<int>(Fault::interrupted));
}

[[noreturn]] void on_terminate() noexcept {
  try {
    if (const auto thrown = std::current_exception()) std::rethrow_exception(thrown);
  } catch (const std::bad_alloc&) {  // in a thread of a library
    leave_at_once(address_space_limit_bytes() > 0
                      ? "not enough memory: this process may take little address space (ulimit -v)"
                      : "not enough memory; a smaller --memory or image needs less",
                  Fault::environment);
  } catch (...) {
  }
  leave_at_once("our bug, please report it with the command and its input: std::terminate was called", Fault::bug);
}

}  // namespace

void remove_temporaries() noexcept {
  for (auto& one : temporaries) {
    const int state = one.state.load();
    if (state == kHolds + static_cast<int>(TemporaryPath::Kind::file)) ::unlink(one.path);
    if (state != kHolds + static_cast<int>(TemporaryPath::Kind::folder)) continue;
    empty_folder(::open(one.path, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC), 0);
    ::rmdir(one.path);
  }
  // Inner ones were registered later than those around them, most often: where not, by the second round.
  for (int round = 0; round < 2; ++round)
    for (auto one = temporaries.rbegin(); one != temporaries.rend(); ++one)
      if (one->state.load() == kHolds + static_cast<int>(TemporaryPath::Kind::empty_folder)) ::rmdir(one->path);
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

TemporaryPath::TemporaryPath(const std::string& path, Kind kind) noexcept {
  if (path.size() >= sizeof(Temporary::path)) return;
  for (int i = 0; i < static_cast<int>(temporaries.size()); ++i) {
    int free = 0;
    if (!temporaries[i].state.compare_exchange_strong(free, 1)) continue;
    std::memcpy(temporaries[i].path, path.c_str(), path.size() + 1);
    temporaries[i].state = kHolds + static_cast<int>(kind);
    slot_ = i;
    return;
  }
}

TemporaryPath::~TemporaryPath() {
  if (slot_ >= 0) temporaries[slot_].state = 0;
}

}  // namespace raycube::base
