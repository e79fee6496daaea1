// Work in a child process under a limit: what it hands back, and every way in which it can fail to.
#include <doctest/doctest.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <stdexcept>

#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/available_memory.h"
#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/interrupt.h"
#include "host/base/limited_child.h"
#include "host/base/output_file.h"
#include "tests/support/patience.h"
#include "tests/unit/test_folder.h"

using namespace raycube::base;
using raycube::testing::Patience;
using raycube::testing::TestFolder;

TEST_CASE("what the child packs the parent unpacks, small and large") {
  std::vector<double> many(3000000);
  std::iota(many.begin(), many.end(), 0.5);
  auto out = in_limited_child({}, [&](Parcel& parcel) {
    parcel.text("hello");
    for (int i = 0; i < 1000; ++i) parcel.value(i);
    parcel.list(many.data(), many.size());
    parcel.text("");
    parcel.value(2.5);
  });
  REQUIRE(out.end == ChildEnd::done);
  CHECK(out.text() == "hello");
  for (int i = 0; i < 1000; ++i) REQUIRE(out.value<int>() == i);
  CHECK(out.list<double>() == many);
  CHECK(out.text().empty());
  CHECK(out.value<double>() == 2.5);
  CHECK_THROWS_AS(out.value<char>(), Error);
  CHECK(in_limited_child({}, [](Parcel&) {}).end == ChildEnd::done);
}

TEST_CASE("a child that computes for ever, waits for ever, takes all memory, crashes or throws ends in words") {
  const TestFolder folder;
  OutputFile mine(folder / "a");  // a child that dies must leave it alone
  ChildLimits limits;
  limits.cpu_s = 0.3;
  const auto end_of = [](const ChildLimits& l, const std::function<void(Parcel&)>& work) {
    auto result = in_limited_child(l, work);
    return std::pair{result.end, result.why};
  };
  const Patience patience("the end of children that compute or wait for ever");
  auto end = end_of(limits, [](Parcel&) {
    while (true) asm volatile("");
  });
  CHECK(end.first == ChildEnd::out_of_time);
  CHECK(end.second == "did not end in 0.3 s of computing");

  limits.cpu_s = 100, limits.idle_s = 0.3;
  end = end_of(limits, [](Parcel&) { ::pause(); });
  CHECK(end.first == ChildEnd::out_of_time);
  CHECK(end.second.find("waited 0.3 s") == 0);

  limits = ChildLimits();
  limits.memory_bytes = 64 << 20;
  end = end_of(limits, [](Parcel& parcel) {
    const std::vector<char> large(100 << 20, 'x');
    parcel.list(large.data(), large.size());
  });
  CHECK(end.first == ChildEnd::out_of_memory);

  end = end_of({}, [](Parcel&) { ::raise(SIGSEGV); });
  CHECK(end.first == ChildEnd::crashed);
  CHECK(end.second == "was ended by signal 11");
  CHECK(end_of({}, [](Parcel&) { throw std::runtime_error("x"); }).first == ChildEnd::crashed);
  CHECK(end_of({}, [](Parcel&) { leave_at_once("x", Fault::bug); }).first == ChildEnd::crashed);
  CHECK(std::filesystem::exists(mine.temporary_path()));
}

TEST_CASE("a child hands back no more than there is memory for") {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_AS, &before) == 0);
  rlimit space = before;
  space.rlim_cur = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE)) + (std::uint64_t{64} << 20);
  REQUIRE(::setrlimit(RLIMIT_AS, &space) == 0);
  const AvailableMemory available = available_memory();
  std::string ends;
  for (const int mebibytes : {8, 256}) {
    const auto out = in_limited_child({}, [&](Parcel& parcel) {
      const std::vector<char> piece(1 << 20, 'x');
      for (int i = 0; i < mebibytes; ++i) parcel.list(piece.data(), piece.size());
    });
    ends += (out.end == ChildEnd::done ? "done" : out.why) + "\n";
  }
  REQUIRE(::setrlimit(RLIMIT_AS, &before) == 0);
  CHECK(available.bytes <= std::uint64_t{64} << 20);
  CHECK(available.bytes > std::uint64_t{56} << 20);
  CHECK(available.by == "left by ulimit -v");
  CHECK(ends.starts_with("done\nhands back more than "));
  CHECK(ends.ends_with(" MiB left by ulimit -v\n"));
}

TEST_CASE("Ctrl-C ends the child and is told") {
  install_signal_handlers();
  const Patience patience("the end of a child after Ctrl-C");
  const auto work = [](Parcel&) {
    ::kill(::getppid(), SIGINT);
    ::pause();
  };
  CHECK_THROWS_WITH_AS(in_limited_child({}, work), doctest::Contains("interrupted by Ctrl-C"), Error);
  clear_interrupt();
  CHECK(::waitpid(-1, nullptr, WNOHANG) == -1);  // no child is left
}

TEST_CASE("a caller that ignores SIGCHLD, which exec keeps, takes no child from us") {
  ::signal(SIGCHLD, SIG_IGN);
  install_signal_handlers();
  auto out = in_limited_child({}, [](Parcel& parcel) { parcel.value(7); });
  REQUIRE(out.end == ChildEnd::done);
  CHECK(out.value<int>() == 7);
}

TEST_CASE("what is no plain file is told by its kind, and nothing is opened") {
  const TestFolder folder;
  folder.write("plain", "x");
  std::filesystem::create_symlink(folder / "plain", folder / "link");
  std::filesystem::create_symlink(folder / "none", folder / "dangling");
  REQUIRE(::mkfifo((folder / "fifo").c_str(), 0600) == 0);
  CHECK(why_no_plain_file(folder / "plain").empty());
  CHECK(why_no_plain_file(folder / "link").empty());
  CHECK(why_no_plain_file(folder / "none") == "is not there");
  CHECK(why_no_plain_file(folder / "dangling") == "is not there");
  CHECK(why_no_plain_file(folder.path.string()) == "is a folder");
  CHECK(why_no_plain_file(folder / "fifo") == "is a pipe");
  CHECK(why_no_plain_file("/dev/zero") == "is a device");
  refuse_other_than_plain(folder / "plain");
  refuse_other_than_plain(folder / "none");
  CHECK_THROWS_WITH_AS(refuse_other_than_plain(folder / "fifo"),
                       doctest::Contains("fifo: is a pipe; give the path of a plain file"), Error);
}
