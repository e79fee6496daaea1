// raycube: parses the command line, runs one verb, and turns every failure into one message and an exit status.
#include <malloc.h>
#include <unistd.h>

#include <csignal>
#include <exception>
#include <iostream>
#include <new>
#include <string>
#include <string_view>
#include <vector>

#include "host/base/crash_report.h"
#include "host/base/doing.h"
#include "host/base/error.h"
#include "host/base/interrupt.h"
#include "host/base/memory.h"
#include "host/cl/kernel_cache.h"
#include "host/base/standard_streams.h"
#include "host/cli/parser.h"

namespace {

using raycube::base::Error;
using raycube::base::Fault;

constexpr int kMmapThreshold_bytes = 1 << 20, kTrimThreshold_bytes = 64 << 20;

/// One message, prefixed line by line: to the log when there is one, else to stderr.
int report(raycube::base::Log* log, int status, const std::string& message) {
  if (log) {
    log->error(message);
  } else {
    raycube::base::Log plain;
    plain.error(message);
  }
  return status;
}

/// What the report was for has ended before it, as in `raycube info cube.img | head -1`: quietly, by SIGPIPE,
/// as other programs do.
[[noreturn]] void leave_like_others() {
  ::signal(SIGPIPE, SIG_DFL);
  ::raise(SIGPIPE);
  ::_exit(128 + SIGPIPE);  // where it is blocked
}

int run(int argc, char** argv, std::unique_ptr<raycube::base::Log>& log) {
  using namespace raycube;
  const auto verbs = cli::all_verbs();
  cli::CommonOptions values;
  // "help render" is "render --help".
  std::vector<char*> words(argv, argv + argc);
  std::string flag = "--help";
  if (argc > 1 && std::string_view(argv[1]) == "help") {
    while (words.size() > 1 && std::string_view(words[1]) == "help") words.erase(words.begin() + 1);
    words.push_back(flag.data());
  }
  const auto parsed = cli::parse_command_line(static_cast<int>(words.size()), words.data(), verbs, values);
  int status = 0;
  if (!parsed.verb) {
    std::cout << parsed.text;
  } else {
    log = std::make_unique<base::Log>(base::LogOptions{values.verbose - values.quiet, values.log_file});
    std::string command_line;
    for (int i = 0; i < argc; ++i) command_line += (i ? " " : "") + std::string(argv[i]);
    cl::set_cache_notices([&log = *log](base::Level level, const std::string& text) { log.message(level, text); });
    const base::Doing doing("command", command_line);
    cli::Invocation invocation{values, *log, std::cout, command_line};
    status = parsed.verb->run(invocation);
  }
  const bool printed = static_cast<bool>(std::cout.flush());
  if (!printed && base::stdout_reader_is_gone()) leave_like_others();
  if (!printed) throw Error(Fault::environment, "stdout could not be written; is its disk full or its reader gone?");
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  raycube::base::claim_standard_descriptors();
  raycube::base::install_crash_report();
  raycube::base::install_signal_handlers();
  std::unique_ptr<raycube::base::Log> log;
  // A fixed threshold: what is large goes back to the system when it is freed, so that peak memory does not depend on
  // when. What is not, is kept: fresh pages for every small matrix of a plan took a tenth of its time.
  mallopt(M_MMAP_THRESHOLD, kMmapThreshold_bytes);
  mallopt(M_TRIM_THRESHOLD, kTrimThreshold_bytes);
  try {
    return run(argc, argv, log);
  } catch (const Error& error) {
    // Ctrl-C reaches the whole process group: the driver's compiler dies of it, and what is seen here is a
    // failed build.
    const bool consequence = error.fault() == Fault::device && raycube::base::interrupted_by_now();
    if (consequence) return report(log.get(), static_cast<int>(Fault::interrupted), raycube::base::interrupt_text());
    return report(log.get(), error.exit_status(), error.what());
  } catch (const std::bad_alloc&) {
    return report(log.get(), static_cast<int>(Fault::environment),
                  "not enough memory; a smaller --memory or image needs less" + raycube::base::address_space_text());
  } catch (const std::exception& failure) {
    return report(log.get(), static_cast<int>(Fault::bug),
                  std::string("our bug, please report it with the command and its input: ") + failure.what());
  } catch (...) {
    return report(log.get(), static_cast<int>(Fault::bug), "our bug, please report it with the command and its input");
  }
}
