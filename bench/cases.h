// The groups of figures a run may name.
#pragma once

#include <string>
#include <vector>

#include "bench/report.h"

namespace raycube::bench {

struct Settings {
  int threads = 2;
  std::string park_file = "build/bench/scene/park.toml";
  std::string peer_file = "build/bench/peer/peer.toml";
};

struct Case {
  const char* name;
  const char* text;
  void (*run)(const Settings&, Report&);
};

const std::vector<Case>& all_cases();
const Case* find_case(const std::string& name);

void run_embree_baseline(const Settings&, Report&);
void run_terrain(const Settings&, Report&);
void run_crowns(const Settings&, Report&);
void run_layers(const Settings&, Report&);
void run_park(const Settings&, Report&);
void run_any_hit(const Settings&, Report&);
void run_bounce(const Settings&, Report&);
void run_render(const Settings&, Report&);
void run_kernel_build(const Settings&, Report&);
struct KernelBuild {
  double seconds = 0;  ///< to build the park's programs and first launch each kernel
  Programs programs;
};
/// In this process.
KernelBuild kernel_build(const Settings&);
/// What a run.json of `raycube render` says was launched. Throws Error(input) when it does not say.
Programs programs_of_run(const std::string& run_json);
void run_integrate(const Settings&, Report&);
void run_check(const Settings&, Report&);
void run_lidar(const Settings&, Report&);
void run_lines(const Settings&, Report&);
void run_leaks(const Settings&, Report&);
void run_roofline(const Settings&, Report&);

}  // namespace raycube::bench
