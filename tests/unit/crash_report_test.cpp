// What a process that a signal ends leaves behind: a child does what ends it, the parent reads its stderr and
// status.
#include <doctest/doctest.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/crash_report.h"
#include "host/base/doing.h"
#include "host/base/interrupt.h"
#include "tests/support/patience.h"
#include "tests/unit/test_folder.h"

namespace {

using namespace raycube;
using raycube::testing::TestFolder;

struct End {
  int signal = 0;
  std::string said;
  bool says(const std::string& part) const { return said.find(part) != std::string::npos; }
};

/// What becomes of a child that does `deed`; it is no core's worth.
End end_of(const std::function<void()>& deed) {
  const testing::Patience patience("the end of a child that a signal ends");
  int ends[2];
  REQUIRE(::pipe(ends) == 0);
  std::fflush(nullptr);
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_CORE, &none);
    ::dup2(ends[1], STDERR_FILENO);
    ::close(ends[0]);
    base::install_crash_report();
    deed();
    ::_exit(0);
  }
  ::close(ends[1]);
  End end;
  char piece[4096];
  for (ssize_t count; (count = ::read(ends[0], piece, sizeof piece)) > 0;)
    end.said.append(piece, static_cast<std::size_t>(count));
  ::close(ends[0]);
  int status = 0;
  ::waitpid(child, &status, 0);
  end.signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  INFO(end.said);
  return end;
}

[[gnu::noinline]] int fall(volatile int* to, int depth) {
  volatile char frame[512] = {};
  frame[0] = static_cast<char>(depth);
  return frame[0] + (to[0] ? fall(to, depth + 1) : 0) + frame[1];
}

volatile int* volatile nowhere = nullptr;
volatile int zero = 0;

#if defined(__SANITIZE_ADDRESS__)
constexpr bool kSanitizerReports = true;  // in the place of ours
#else
constexpr bool kSanitizerReports = false;
#endif

}  // namespace

TEST_CASE(
    "every signal of the five is reported with what was being done and the stack, and stays the process's "
    "status" *
    doctest::skip(kSanitizerReports)) {
  const TestFolder folder;
  folder.write("mapped", std::string(10, 'x'));
  const struct {
    int signal;
    std::function<void()> deed;
  } ends[] = {{SIGSEGV, [] { *nowhere = 1; }},
              {SIGFPE, [] { zero = 70 / zero; }},
              {SIGILL, [] { __builtin_trap(); }},
              {SIGABRT, [] { std::abort(); }},
              {SIGABRT, [] { ::raise(SIGABRT); }},
              {SIGBUS, [&] {
                 const int file = ::open((folder / "mapped").c_str(), O_RDWR);
                 auto* at = static_cast<volatile char*>(::mmap(nullptr, 4096, PROT_READ, MAP_SHARED, file, 0));
                 static_cast<void>(::ftruncate(file, 0));
                 zero = at[5];
               }}};
  for (const auto& [signal, deed] : ends) {
    CAPTURE(signal);
    const End end = end_of([&, &deed = deed] {
      const base::Doing outer("rendering instrument", "camera"), inner("stage", "shade");
      base::remember_launch("trace_primary");
      base::remember_launch("trace_sun");
      deed();
    });
    CHECK(end.signal == signal);
    CHECK(end.says("ended by signal " + std::to_string(signal) + " ("));
    CHECK(end.says(": rendering instrument 'camera'\n"));
    CHECK(end.says(": stage 'shade'\n"));
    CHECK(end.said.find("'camera'") < end.said.find("'shade'"));
    CHECK(end.says("kernels launched last: trace_primary trace_sun\n"));
    CHECK(end.says("test_crash_report"));  // frames name their file
    CHECK(end.says("test case 'every signal of the five"));
  }
}

TEST_CASE("a stack that overflows is reported on the main thread and on one that somebody else starts" *
          doctest::skip(kSanitizerReports)) {
  volatile int one = 1;
  for (const bool thread : {false, true}) {
    const End end = end_of([&] {
      const base::Doing doing("falling");
      if (thread) {
        std::thread([&] { fall(&one, 0); }).join();
      } else {
        const rlimit small{1 << 20, 1 << 20};
        ::setrlimit(RLIMIT_STACK, &small);
        fall(&one, 0);
      }
    });
    CHECK(end.signal == SIGSEGV);
    CHECK(end.says(": falling\n"));
    CHECK(end.says("stack (addr2line"));
  }
}

TEST_CASE(
    "two threads that fall at once leave one report; registered temporaries go, what is done no longer is "
    "not told" *
    doctest::skip(kSanitizerReports)) {
  const TestFolder folder;
  folder.write(".half", "written");
  const End end = end_of([&] {
    const base::TemporaryPath temporary(folder / ".half");
    { const base::Doing over("over by then"); }
    std::thread other([] { *nowhere = 1; });
    *nowhere = 1;
    other.join();
  });
  CHECK(end.signal == SIGSEGV);
  CHECK(end.said.find("ended by signal") == end.said.rfind("ended by signal"));
  CHECK(!end.says("over by then"));
  CHECK(folder.names().empty());
}

TEST_CASE("names of any length, and more of them than are kept, do no harm" * doctest::skip(kSanitizerReports)) {
  const End end = end_of([] {
    const base::Doing longest(std::string(10000, 'a'), std::string(10000, 'b'));
    base::remember_launch(std::string(10000, 'c'));
    std::vector<std::unique_ptr<base::Doing>> many;
    for (int i = 0; i < 200; ++i) many.push_back(std::make_unique<base::Doing>("one of many", std::to_string(i)));
    ::raise(SIGSEGV);
  });
  CHECK(end.signal == SIGSEGV);
  CHECK(end.says("one of many '50'\n"));
  CHECK(end.said.size() < 60000);
}
