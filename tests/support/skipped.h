// What a test could not show for want of reference data: said loudly, and the test ends as skipped (status 77) where
// all else passed.
#pragma once

#include <iostream>
#include <string>

namespace raycube::testing {

inline bool part_skipped = false;

inline void skip_part(const std::string& not_shown) {
  std::cerr << "SKIPPED: RAYCUBE_SHARED is not set, " << not_shown << "\n";
  part_skipped = true;
}

}  // namespace raycube::testing
