#include "bench/cases.h"

#include <algorithm>

namespace raycube::bench {

const std::vector<Case>& all_cases() {
  static const std::vector<Case> cases{
      {"embree", "Embree against itself on the terrain: the guard, and what each mode is worth", run_embree_baseline},
  };
  return cases;
}

const Case* find_case(const std::string& name) {
  const auto& cases = all_cases();
  const auto found = std::find_if(cases.begin(), cases.end(), [&](const Case& c) { return c.name == name; });
  return found == cases.end() ? nullptr : &*found;
}

}  // namespace raycube::bench
