#include "host/base/available_memory.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>

#include <sys/resource.h>
#include <unistd.h>

#include "host/base/memory.h"

namespace raycube::base {
namespace {

namespace fs = std::filesystem;

/// The number behind a word that begins a line of a file.
std::optional<std::uint64_t> number_behind(const fs::path& file, const std::string& word) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string first;
    std::uint64_t number = 0;
    if (words >> first && first == word && words >> number) return number;
  }
  return std::nullopt;
}

/// The number that a file holds; none where it says "max", or is not there.
std::optional<std::uint64_t> number_in(const fs::path& file) {
  std::ifstream in(file);
  std::uint64_t number = 0;
  return in >> number ? std::optional(number) : std::nullopt;
}

void take_less(AvailableMemory& least, std::uint64_t limit, std::uint64_t used, const std::string& by) {
  const std::uint64_t left = limit > used ? limit - used : 0;
  if (left < least.bytes) least = {left, by};
}

/// The limits of a group and of those above it. Files that a group has read count as used and can be given back.
void take_cgroup(AvailableMemory& least, const fs::path& mount, fs::path group, const char* limit_file,
                 const char* used_file, const std::string& total) {
  for (int depth = 0; depth < 64; ++depth) {
    const fs::path at = mount / group.relative_path();
    const auto limit = number_in(at / limit_file), used = number_in(at / used_file);
    if (limit && used && *limit < (std::uint64_t{1} << 60)) {
      std::uint64_t kept = 0;
      for (const char* list : {"inactive_file", "active_file"})
        kept += number_behind(at / "memory.stat", total + list).value_or(0);
      take_less(least, *limit, *used - std::min(*used, kept), "left by the limit of cgroup " + group.string());
    }
    if (!group.has_relative_path()) return;
    group = group.parent_path();
  }
}

void take_cgroups(AvailableMemory& least, const fs::path& root) {
  std::ifstream in(root / "proc/self/cgroup");  // "0::/user.slice" of version 2, "5:memory:/user.slice" of 1
  for (std::string line; std::getline(in, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1), group = line.substr(second + 1);
    if (controllers.empty())
      take_cgroup(least, root / "sys/fs/cgroup", group, "memory.max", "memory.current", "");
    else if (controllers.find("memory") != std::string::npos)
      take_cgroup(least, root / "sys/fs/cgroup/memory", group, "memory.limit_in_bytes", "memory.usage_in_bytes",
                  "total_");
  }
}

void take_limit(AvailableMemory& least, const fs::path& root, int what, const char* used, const std::string& by) {
  rlimit limit{};
  if (::getrlimit(static_cast<__rlimit_resource>(what), &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  take_less(least, limit.rlim_cur, 1024 * number_behind(root / "proc/self/status", used).value_or(0), by);
}

}  // namespace

std::string AvailableMemory::text() const { return format_bytes(bytes) + " " + by; }

AvailableMemory available_memory(const fs::path& root) {
  AvailableMemory least{std::numeric_limits<std::uint64_t>::max(), "free on this machine"};
  if (const auto kibibytes = number_behind(root / "proc/meminfo", "MemAvailable:")) least.bytes = 1024 * *kibibytes;
  take_cgroups(least, root);
  take_limit(least, root, RLIMIT_AS, "VmSize:", "left by ulimit -v");
  take_limit(least, root, RLIMIT_DATA, "VmData:", "left by ulimit -d");
  return least;
}

}  // namespace raycube::base
