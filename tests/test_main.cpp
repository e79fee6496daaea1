// main() of every test of ours. What ends a test by a signal is told by the program's own report, which names
// the case.
#define DOCTEST_CONFIG_IMPLEMENT
#define DOCTEST_CONFIG_NO_POSIX_SIGNALS
#include <doctest/doctest.h>

#include <cstdio>
#include <list>
#include <optional>

#include "host/base/crash_report.h"
#include "host/base/doing.h"
#include "tests/support/skipped.h"

namespace {

bool none_ran = false;

/// Says which case and which of its parts run, and nothing else.
class Crumbs : public doctest::IReporter {
 public:
  explicit Crumbs(const doctest::ContextOptions&) {}
  void test_case_start(const doctest::TestCaseData& test) override { doing_.emplace("test case", test.m_name); }
  void test_case_reenter(const doctest::TestCaseData&) override {}
  void test_case_end(const doctest::CurrentTestCaseStats&) override { doing_.reset(); }
  void subcase_start(const doctest::SubcaseSignature& part) override {
    parts_.emplace_back(std::in_place, "part", part.m_name.c_str());
  }
  void subcase_end() override { parts_.pop_back(); }
  void report_query(const doctest::QueryData&) override {}
  void test_run_start() override {}
  void test_run_end(const doctest::TestRunStats& run) override { none_ran = run.numTestCasesPassingFilters == 0; }
  void test_case_exception(const doctest::TestCaseException&) override {}
  void log_assert(const doctest::AssertData&) override {}
  void log_message(const doctest::MessageData&) override {}
  void test_case_skipped(const doctest::TestCaseData&) override {}

 private:
  std::optional<raycube::base::Doing> doing_;
  std::list<std::optional<raycube::base::Doing>> parts_;
};

}  // namespace

REGISTER_LISTENER("crumbs", 1, Crumbs);

// A library that gives up is reported too: LLVM's handler of SIGABRT keeps ours from being called
// (host/cli/library_abort.cpp).
extern "C" [[noreturn]] void abort() noexcept { raycube::base::end_by_abort(); }

int main(int argc, char** argv) {
  raycube::base::install_crash_report();
  const int status = doctest::Context(argc, argv).run();
  constexpr int kSkipped = 77;
  if (!none_ran) return status == 0 && raycube::testing::part_skipped ? kSkipped : status;
  std::fputs("FAILED: no test case has a name or a source file that was asked for\n", stderr);
  return 1;
}
