#include "bench/cases.h"

#include <algorithm>

namespace raycube::bench {

const std::vector<Case>& all_cases() {
  static const std::vector<Case> cases{
      {"embree", "Embree against itself on the terrain: the guard, and what each mode is worth", run_embree_baseline},
      {"terrain", "primary and sun rays on 1 M large triangles, against Embree", run_terrain},
      {"crowns", "primary and sun rays on generated leaves, two levels and merged, bytes per triangle and instance",
       run_crowns},
      {"layers", "primary and sun rays through 2, 4, 7 and 14 layers of leaves", run_layers},
      {"park", "the shipped park: pixels with at least 100 candidates, against every mode of Embree", run_park},
      {"any_hit",
       "rays into the sky from what the park's and the peer scene's cameras see, and primary rays among leaves,"
       " against the best of Embree's modes and forms",
       run_any_hit},
      {"bounce",
       "closest hits of rays from surface to surface, first and second, in the park and on the terrain, against the "
       "best"
       " of Embree's modes and forms",
       run_bounce},
      {"render", "the park as render renders it: its term lists and their integration, against the write bandwidth",
       run_render},
      {"build", "kernels built cold and from the cache, each in a process of its own", run_kernel_build},
      {"integrate", "band integration on synthetic term lists, against the write bandwidth", run_integrate},
      {"check", "first hits on the terrain against Embree (robust) and double, as `raycube check` compares them",
       run_check},
      {"lidar", "pulses traced and binned against Embree doing the same; pulses a second with waveforms and echoes",
       run_lidar},
      {"lines", "3000 spectral lines summed at 4001 wavenumbers in the whole air, against every profile at every one",
       run_lines},
      {"leaks", "1e8 camera rays and 1e8 rays aimed at edges through closed meshes", run_leaks},
      {"roofline", "each stage of the park: bytes and flops over the write bandwidth and the FMA peak", run_roofline},
  };
  return cases;
}

const Case* find_case(const std::string& name) {
  const auto& cases = all_cases();
  const auto found = std::find_if(cases.begin(), cases.end(), [&](const Case& c) { return c.name == name; });
  return found == cases.end() ? nullptr : &*found;
}

}  // namespace raycube::bench
