// How much more memory this process can have: what the machine has free, and what limits leave of it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace raycube::base {

struct AvailableMemory {
  std::uint64_t bytes = 0;
  std::string by;  ///< what sets it: "free on this machine", "left by ulimit -v", "left by the limit of cgroup /a/b"
  std::string text() const;  ///< "1.5 GiB free on this machine"
};

/// The least of the memory that Linux can free for new use (MemAvailable), what the limits of this process's cgroups
/// (version 2 or 1, the process's own and those above it) leave, and what `ulimit -v` and `ulimit -d` leave.
/// root: where /proc and /sys lie.
AvailableMemory available_memory(const std::filesystem::path& root = "/");

}  // namespace raycube::base
