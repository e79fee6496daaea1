// How samples lie in a pixel where the file leaves them open, and the numbers of them that are tried.
//
// No edge runs along a lattice, and every seed moves it: its spread over seeds is its error. Under a point spread,
// which weighs cells of a square, samples are random points in such cells.
#pragma once

#include <string>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::planner {

/// Most samples of a pixel, and cells along it, as the scene format has them.
inline constexpr int kMostSamples = 65536, kMostSide = 256;

struct SamplePattern {
  scene::SamplerKind sampler;
  std::vector<int> levels;  ///< samples of a pixel, rising
  int look;                 ///< the level of the planner's first look

  /// Samples along a pixel's line and across it.
  int along(int samples) const;
  int across(int samples) const { return samples / along(samples); }
  /// "lattice 21", "jittered 5 x 5".
  std::string name(int samples) const;
};

/// Numbers of Fibonacci and of Lucas, on which the golden ratio's lattice closes nearly without a seam; squares of
/// jittered cells under a point spread.
const SamplePattern& sample_pattern(const scene::Instrument& instrument);

/// The instrument with so many samples of its pattern, one of its levels.
void give_samples(scene::Instrument& instrument, int samples);

/// "grid 3 x 3", "lattice 16".
std::string sampler_text(scene::SamplerKind sampler, int samples_u, int samples_v);

}  // namespace raycube::planner
