// A library that gives up: the program ends with one error; a child that reads a file ends without a word,
// since its parent says what became of it.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

#include <cstdlib>
#include <functional>
#include <string>

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/error.h"
#include "host/base/limited_child.h"
#include "tests/support/patience.h"
#include "tests/unit/test_folder.h"

using namespace raycube::base;
using raycube::testing::TestFolder;

extern "C" [[noreturn]] void __assert_fail(const char*, const char*, unsigned, const char*) noexcept;

namespace {

void give_up() { std::abort(); }
void fail() { __assert_fail("x > 0", "library.c", 7, "f"); }

void say_into(const std::string& file) {
  ::dup2(::open(file.c_str(), O_CREAT | O_WRONLY | O_CLOEXEC, 0600), STDERR_FILENO);
}

}  // namespace

TEST_CASE("a library that gives up in a child that reads a file says nothing in the user's terminal") {
  for (const auto& deed : {give_up, fail}) {
    const TestFolder folder;
    const Unpacked out = in_limited_child({}, [&](Parcel&) {
      say_into(folder / "said");
      deed();
    });
    CHECK(out.end == ChildEnd::crashed);
    CHECK(folder.names() == std::set<std::string>{"said"});
    CHECK(folder.read("said") == "");
  }
}

TEST_CASE("a library that gives up ends the program with one error and the device's status") {
  for (const auto& deed : {give_up, fail}) {
    const raycube::testing::Patience patience("the end of a child whose library gives up");
    const TestFolder folder;
    const pid_t child = ::fork();
    if (child == 0) {
      say_into(folder / "said");
      deed();
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == static_cast<int>(Fault::device));
    const std::string said = folder.read("said");
    CHECK(said.find("raycube: error: a library ended the program") != std::string::npos);
    CHECK((said.find("assertion `x > 0' failed") != std::string::npos) == (deed == fail));
  }
}
