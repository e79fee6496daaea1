// Embree in every mode and form that a scene allows, timed in turn with ours: the fastest is the baseline.
#pragma once

#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench/embree_baseline.h"
#include "bench/timing.h"
#include "scene_compiler/simulation.h"

namespace raycube::bench {

inline constexpr double kMostRays = 1.2e6;  ///< of a timed run: 0.1 to 0.3 s

struct Opponent {
  std::string name;
  const EmbreeBaseline* embree;
  EmbreeMode mode;
  Pairs times;
};

/// Embree's forms of a scene; the merged one where memory allows.
std::vector<std::pair<EmbreeForm, std::unique_ptr<EmbreeBaseline>>> embree_forms(const scene::CompiledScene& scene,
                                                                                 const std::string& label);

/// Whole lines of the image, evenly chosen, of at most `most` rays.
std::vector<shared::RayGroup> some_lines(const scene::Instrument& instrument, const scene::CompiledScene& scene,
                                         double most);

/// The opponent that is fastest against us, by the median over all rounds.
const Opponent& best_of(const std::vector<Opponent>& opponents);

/// theirs(opponent) and ours() do their work and return seconds.
template <typename Theirs, typename Ours>
void time_in_turn(std::vector<Opponent>& opponents, const Theirs& theirs, const Ours& ours) {
  for (int pair = 0; pair < kPairs; ++pair) {
    for (Opponent& opponent : opponents) opponent.times.reference_s.push_back(theirs(opponent));
    const double ours_s = ours();
    for (Opponent& opponent : opponents) opponent.times.ours_s.push_back(ours_s);
  }
  for (const Opponent& opponent : opponents)
    std::printf("  %s: %.4f s, ours %.4f s: %.3g x\n", opponent.name.c_str(),
                spread_of(opponent.times.reference_s).median, spread_of(opponent.times.ours_s).median,
                opponent.times.ratio().median);
}

}  // namespace raycube::bench
