// What a scene takes of memory, summed before it is built: many things that are each within their limits may be more
// than a machine holds.
#pragma once

#include <string>

#include "host/base/available_memory.h"
#include "host/base/error.h"

namespace raycube::scene {

/// Peak of a process per triangle of a mesh and per placed mesh, trees and their building included: 144 and 497 bytes
/// were measured of renders, with 2e6 squares of a checkerboard and 1e6 scattered triangles. Building alone takes 80 of
/// the first.
inline constexpr double kTriangle_bytes = 140, kPlaced_bytes = 500;

class MemorySum {
 public:
  /// Adds what `what` takes. False after reporting that all so far is more than there was when the first was added; the
  /// thing is then not to be built.
  bool take(double bytes, const base::Where& where, const std::string& what, const std::string& way_out,
            base::Problems& problems);
  /// The same of one of many, which reports nothing: the caller gives back those before and take()s their sum.
  bool take_quietly(double bytes) {
    const bool fits = left() >= bytes;
    if (fits) bytes_ += bytes;
    return fits;
  }
  void give_back(double bytes) { bytes_ -= bytes; }
  /// What is left of it, bytes.
  double left() const { return static_cast<double>(available_.bytes) - bytes_; }
  const base::AvailableMemory& available() const { return available_; }

 private:
  base::AvailableMemory available_ = base::available_memory();
  double bytes_ = 0;
};

}  // namespace raycube::scene
