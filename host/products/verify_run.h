// What lies on the disk against the hashes in its run.json.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace raycube::products {

struct VerifiedRun {
  std::size_t files = 0;                 ///< that run.json has hashes of
  std::uint64_t bytes = 0;               ///< read and found as they were written
  std::vector<std::string> differences;  ///< of each file the first: file, block, bytes
  bool whole() const { return differences.empty(); }
};

/// Reads every file of the run beside `record_path` once, block by block; `done` hears of bytes as they are
/// read. Throws Error(input) when the record is none, is damaged, or has no hashes (those written before
/// hashes were kept).
VerifiedRun verify_run(const std::string& record_path, const std::function<void(std::uint64_t)>& done = {});

}  // namespace raycube::products
