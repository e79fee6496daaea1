// The groups of figures a run may name.
#pragma once

#include <string>
#include <vector>

#include "bench/report.h"

namespace raycube::bench {

struct Settings {
  int threads = 2;
  std::string park_file = "scenes/park/park.toml";
};

struct Case {
  const char* name;
  const char* text;
  void (*run)(const Settings&, Report&);
};

const std::vector<Case>& all_cases();
const Case* find_case(const std::string& name);

void run_embree_baseline(const Settings&, Report&);

}  // namespace raycube::bench
