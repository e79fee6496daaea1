#include "scene_compiler/memory_sum.h"

#include <cstdint>

#include "host/base/memory.h"

namespace raycube::scene {
namespace {

std::string bytes_text(double bytes) { return base::format_bytes(static_cast<std::uint64_t>(bytes)); }

}  // namespace

bool MemorySum::take(double bytes, const base::Where& where, const std::string& what, const std::string& way_out,
                     base::Problems& problems) {
  const double before = bytes_;
  bytes_ += bytes;
  if (bytes_ <= static_cast<double>(available_.bytes)) return true;
  problems.add(where, "the scene needs more memory than there is",
               what + ": about " + bytes_text(bytes) + (before > 0.01 * bytes ? " beside " + bytes_text(before) : "") +
                   ", of " + available_.text(),
               way_out);
  bytes_ = before;
  return false;
}

}  // namespace raycube::scene
