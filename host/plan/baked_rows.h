// Rows that bake_row made, for a plan that is rendered again and again: a trial's small renders would take longer to
// bake than to trace.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <vector>

namespace raycube::plan {

class BakedRows {
 public:
  /// False: not known.
  bool read(std::uint64_t key, std::vector<float>& row) const;
  /// Forgets it at once where rows of 16 MiB are known.
  void keep(std::uint64_t key, const std::vector<float>& row);

 private:
  mutable std::mutex mutex_;
  std::map<std::uint64_t, std::vector<float>> rows_;
  std::size_t bytes_ = 0;
};

}  // namespace raycube::plan
