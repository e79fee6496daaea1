// Mutations of every file of every corpus, fed to its reader in the ordinary build: mutate CORPUS_FOLDER NUMBER
// [TARGET ..]. Each reader runs in a process with 2 GiB of address space and 30 s of computing for each mutation, its
// children's too, so that a signal or a hang is counted and the next mutation is tried. Of texts that count their
// numbers, every tenth mutation takes one number out of the body or puts one more into it: such a file is not to be
// read. Fails on a signal, a hang, an exception that is no base::Error, or such a file that was read. Mutations are the
// same in every run.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/fuzz/targets.h"

namespace {

namespace fs = std::filesystem;
using raycube::fuzz::Target;

constexpr rlim_t kMemory_bytes = rlim_t{2} << 30;
constexpr double kMost_s = 30;         ///< of computing
constexpr unsigned kMostWait_s = 600;  ///< in all, on any machine

/// splitmix64 (Steele et al. 2014).
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9, z = (z ^ z >> 27) * 0x94d049bb133111eb;
    return z ^ z >> 31;
  }
  std::size_t below(std::size_t count) { return count == 0 ? 0 : next() % count; }

 private:
  std::uint64_t state_;
};

/// Begin and end of the numbers of a text from a place on.
std::vector<std::pair<std::size_t, std::size_t>> numbers_of(const std::string& text, std::size_t from) {
  std::vector<std::pair<std::size_t, std::size_t>> out;
  const auto is_part = [&](std::size_t i) {
    return i < text.size() && (std::isdigit(static_cast<unsigned char>(text[i])) || text[i] == '.' || text[i] == '-');
  };
  for (std::size_t i = from; i < text.size(); ++i) {
    if (!is_part(i) || (i > 0 && is_part(i - 1))) continue;
    std::size_t end = i;
    while (is_part(end)) ++end;
    out.emplace_back(i, end);
  }
  return out;
}

void mutate_once(std::string& text, Draws& draws) {
  static const char* const kNumbers[] = {
      "-1", "0",   "1e400",       "nan",  "inf", "4294967296", "99999999999999999999",
      "",   "1e9", "-2147483649", "0x7f", "1,5", "65536",      "1e-320"};
  const std::size_t at = draws.below(text.size() + 1), length = 1 + draws.below(1 + draws.below(64));
  switch (draws.below(8)) {
    case 0:
      if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << draws.below(8)));
      return;
    case 1:
      if (at < text.size()) text[at] = static_cast<char>(draws.next());
      return;
    case 2:
      text.erase(std::min(at, text.size()), length);
      return;
    case 3:
      text.insert(at, text.substr(draws.below(text.size() + 1), length));
      return;
    case 4:
      for (std::size_t i = 0; i < length; ++i) text.insert(at, 1, static_cast<char>(draws.next()));
      return;
    case 5:
      text.resize(at);
      return;
    default:
      if (const auto numbers = numbers_of(text, 0); !numbers.empty()) {
        const auto [begin, end] = numbers[draws.below(numbers.size())];
        text.replace(begin, end - begin, kNumbers[draws.below(std::size(kNumbers))]);
      }
  }
}

/// One number of the body taken out, or one more put beside it; false: there is none.
bool miscount(std::string& text, std::size_t body, Draws& draws) {
  const auto numbers = numbers_of(text, body);
  if (numbers.empty()) return false;
  const auto [begin, end] = numbers[draws.below(numbers.size())];
  if (draws.below(2) == 0)
    text.erase(begin, end - begin);
  else
    text.insert(end, " 7");
  return true;
}

/// Shared with the process that reads.
struct Tally {
  std::size_t next = 0, refused = 0, read = 0, miscounted = 0, miscounted_read = 0, odd = 0, hangs = 0;
  bool miscount = false;
};

std::string name_of_seed(const Target& target, std::size_t index) {
  return std::string(target.name) + ", mutation " + std::to_string(index);
}

std::uint64_t seed_of(const Target& target, std::size_t index) {
  std::uint64_t seed = 14695981039346656037u;  // FNV-1a
  for (const char* c = target.name; *c; ++c) seed = (seed ^ static_cast<unsigned char>(*c)) * 1099511628211u;
  return seed + index;
}

/// Seconds that this process and its children, those that have ended, have computed.
double computed_s() {
  double out = 0;
  for (const int whose : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage used{};
    ::getrusage(whose, &used);
    for (const timeval& time : {used.ru_utime, used.ru_stime})
      out += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  }
  return out;
}

void try_one(const Target& target, const std::vector<std::string>& files, std::size_t index, Tally& tally) {
  Draws draws(seed_of(target, index));
  std::string text = files[draws.below(files.size())];
  const std::size_t body = target.body ? target.body(text) : std::string::npos;
  tally.miscount = index % 10 == 0 && body != std::string::npos && miscount(text, body, draws);
  for (std::size_t k = tally.miscount ? 0 : 1 + draws.below(1 + draws.below(4)); k > 0; --k) mutate_once(text, draws);
  bool read = false;
  try {
    read = raycube::fuzz::feed(target, reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  } catch (const std::exception& error) {
    ++tally.odd;
    std::printf("%s: %s\n", name_of_seed(target, index).c_str(), error.what());
  }
  ++(read ? tally.read : tally.refused);
  tally.miscounted += tally.miscount;
  if (!tally.miscount || !read) return;
  ++tally.miscounted_read;
  std::printf("%s: read, though its numbers are not those that it counts:\n%s\n", name_of_seed(target, index).c_str(),
              text.substr(0, 2000).c_str());
}

/// All mutations of a reader; how many faults.
std::size_t try_all(const Target& target, const std::vector<std::string>& files, std::size_t number) {
  auto* const tally =
      new (::mmap(nullptr, sizeof(Tally), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Tally;
  std::size_t signals = 0;
  while (tally->next < number) {
    std::fflush(stdout);
    const pid_t child = ::fork();
    if (child == 0) {
      const rlimit memory{kMemory_bytes, kMemory_bytes}, no_core{0, 0};
      ::setrlimit(RLIMIT_AS, &memory), ::setrlimit(RLIMIT_CORE, &no_core);
      while (tally->next < number) {
        ::alarm(kMostWait_s);
        const itimerval own{{0, 0}, {static_cast<time_t>(kMost_s), 0}};
        ::setitimer(ITIMER_PROF, &own, nullptr);
        const double begun_s = computed_s();
        try_one(target, files, tally->next, *tally);
        if (computed_s() - begun_s > kMost_s) {
          std::printf("%s: %.0f s of computing\n", name_of_seed(target, tally->next).c_str(), computed_s() - begun_s);
          ++tally->hangs;
        }
        ++tally->next;
      }
      std::fflush(stdout);
      raycube::fuzz::remove_scratch();
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    if (WIFSIGNALED(status)) {
      const int signal = WTERMSIG(status);
      std::printf("%s: %s\n", name_of_seed(target, tally->next).c_str(), ::strsignal(signal));
      ++(signal == SIGALRM || signal == SIGPROF ? tally->hangs : signals);
      ++tally->next;
    } else if (WEXITSTATUS(status) != 0) {
      std::printf("%s: ended with status %d\n", name_of_seed(target, tally->next).c_str(), WEXITSTATUS(status));
      ++tally->odd, ++tally->next;
    }
  }
  std::printf("%-20s %6zu %8zu %8zu %8zu %6zu %10zu %10zu\n", target.name, number, tally->refused, tally->read, signals,
              tally->hangs, tally->miscounted, tally->miscounted_read);
  return signals + tally->hangs + tally->odd + tally->miscounted_read;
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3 || !fs::is_directory(arguments[1])) {
    std::fprintf(stderr, "usage: mutate CORPUS_FOLDER NUMBER [TARGET ...]\n");
    return 2;
  }
  const std::set<std::string> asked(arguments + 3, arguments + count);
  std::size_t faults = 0;
  std::printf("%-20s %6s %8s %8s %8s %6s %10s %10s\n", "reader", "tried", "refused", "read", "signals", "hangs",
              "miscounted", "read");
  for (const Target& target : raycube::fuzz::targets()) {
    if (!asked.empty() && !asked.contains(target.name)) continue;
    std::set<fs::path> paths;
    for (const auto& entry : fs::directory_iterator(fs::path(arguments[1]) / target.name)) paths.insert(entry.path());
    std::vector<std::string> files;
    for (const fs::path& path : paths) {
      std::ifstream in(path, std::ios::binary);
      files.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    }
    faults += try_all(target, files, std::strtoul(arguments[2], nullptr, 10));
  }
  return faults > 0;
}
