#include "host/base/limited_child.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <new>
#include <utility>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/available_memory.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"

namespace raycube::base {
namespace {

constexpr int kNoMemory = 3, kThrew = 4, kTooMuch = 5, kGlance_ms = 50;
constexpr std::size_t kPiece_bytes = 1 << 20;

struct Descriptor {
  int fd = -1;
  ~Descriptor() { close(); }
  void close() {
    if (fd >= 0) ::close(fd);
    fd = -1;
  }
};

Error cannot(const char* what) {
  return Error(Fault::environment,
               std::string("a child process to read a file in cannot be ") + what + ": " + std::strerror(errno));
}

std::uint64_t address_space_bytes() {
  std::ifstream file("/proc/self/statm");
  std::uint64_t pages = 0;
  file >> pages;
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

[[noreturn]] void be_child(const ChildLimits& limits, const std::function<void(Parcel&)>& work, int out, pid_t parent,
                           std::uint64_t most_handed_bytes) {
  become_helper();
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kThrew);  // it died meanwhile
  rlimit space{};
  if (::getrlimit(RLIMIT_AS, &space) == 0) {
    space.rlim_cur = std::min<rlim_t>(space.rlim_cur, address_space_bytes() + limits.memory_bytes);
    ::setrlimit(RLIMIT_AS, &space);
  }
  const rlimit no_core{0, 0};
  ::setrlimit(RLIMIT_CORE, &no_core);
  int status = 0;
  Parcel parcel(out, most_handed_bytes);
  try {
    work(parcel);
    parcel.flush();
  } catch (const std::bad_alloc&) {
    status = parcel.exceeded() ? kTooMuch : kNoMemory;
  } catch (...) {
    status = kThrew;
  }
  ::_exit(status);
}

double cpu_seconds(pid_t child) {
  clockid_t clock;
  timespec spent{};
  if (::clock_getcpuclockid(child, &clock) != 0 || ::clock_gettime(clock, &spent) != 0) return 0;
  return static_cast<double>(spent.tv_sec) + 1e-9 * static_cast<double>(spent.tv_nsec);
}

double wall_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::string seconds_text(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g s", seconds);
  return text;
}

/// Until the child closes its end of the pipe, which it does by ending. What it exceeded; empty: nothing.
std::string watch(pid_t child, int ended, const ChildLimits& limits) {
  double last_cpu = 0, moved_at = wall_seconds();
  while (true) {
    pollfd end{ended, POLLIN, 0};
    if (::poll(&end, 1, kGlance_ms) == 1) return "";
    const double cpu = cpu_seconds(child), now = wall_seconds();
    if (cpu > last_cpu) last_cpu = cpu, moved_at = now;
    if (interrupted()) return "interrupted";
    if (cpu > limits.cpu_s) return "did not end in " + seconds_text(limits.cpu_s) + " of computing";
    if (now - moved_at > limits.idle_s)
      return "waited " + seconds_text(limits.idle_s) + " for something that does not come";
  }
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw cannot("waited for");
  return status;
}

}  // namespace

void Parcel::bytes(const void* data, std::size_t count) {
  bytes_ += count;
  if (exceeded()) throw std::bad_alloc();
  if (waiting_.size() + count > kPiece_bytes) flush();
  if (count < kPiece_bytes) {
    waiting_.append(static_cast<const char*>(data), count);
    return;
  }
  auto* next = static_cast<const char*>(data);
  while (count > 0) {
    const ssize_t written = ::write(fd_, next, count);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw std::bad_alloc();  // a file in memory: there is no room
    next += written, count -= static_cast<std::size_t>(written);
  }
}

void Parcel::flush() {
  std::string full;
  full.swap(waiting_);
  for (std::size_t done = 0; done < full.size();) {
    const ssize_t written = ::write(fd_, full.data() + done, full.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) throw std::bad_alloc();
    done += static_cast<std::size_t>(written);
  }
}

Unpacked::~Unpacked() {
  if (data_) ::munmap(const_cast<unsigned char*>(data_), size_);
}

Unpacked::Unpacked(Unpacked&& other) noexcept
    : end(other.end),
      why(std::move(other.why)),
      data_(std::exchange(other.data_, nullptr)),
      size_(other.size_),
      next_(other.next_) {}

const unsigned char* Unpacked::take(std::size_t bytes) {
  if (bytes > size_ - next_) throw Error(Fault::bug, "more is taken from a child process than it handed back");
  next_ += bytes;
  return data_ + next_ - bytes;
}

Unpacked in_limited_child(const ChildLimits& limits, const std::function<void(Parcel&)>& work) {
  Descriptor bytes{::memfd_create("raycube", MFD_CLOEXEC)}, ended, held;
  int pipe_ends[2];
  if (bytes.fd < 0 || ::pipe2(pipe_ends, O_CLOEXEC) != 0) throw cannot("prepared");
  ended.fd = pipe_ends[0], held.fd = pipe_ends[1];
  const AvailableMemory available = available_memory();
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) throw cannot("started");
  if (child == 0) be_child(limits, work, bytes.fd, parent, available.bytes);
  held.close();

  Unpacked out;
  out.why = watch(child, ended.fd, limits);
  if (!out.why.empty()) {
    ::kill(child, SIGKILL);
    wait_for(child);
    throw_if_interrupted();
    out.end = ChildEnd::out_of_time;
    return out;
  }
  const int status = wait_for(child);
  throw_if_interrupted();
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNoMemory) {
    out.end = ChildEnd::out_of_memory;
    out.why = "asked for more memory than a file of its size can need";
  } else if (WIFEXITED(status) && WEXITSTATUS(status) == kTooMuch) {
    out.end = ChildEnd::out_of_memory;
    out.why = "hands back more than " + available.text();
  } else if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    out.end = ChildEnd::crashed;
    out.why = WIFSIGNALED(status) ? "was ended by signal " + std::to_string(WTERMSIG(status)) : "gave up";
  }
  if (out.end != ChildEnd::done) return out;
  struct stat size {};
  if (::fstat(bytes.fd, &size) != 0) throw cannot("heard");
  out.size_ = static_cast<std::size_t>(size.st_size);
  if (out.size_ == 0) return out;
  void* const mapped = ::mmap(nullptr, out.size_, PROT_READ, MAP_PRIVATE, bytes.fd, 0);
  if (mapped == MAP_FAILED) throw cannot("heard");
  out.data_ = static_cast<const unsigned char*>(mapped);
  return out;
}

}  // namespace raycube::base
