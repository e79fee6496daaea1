// The pixels of a trial: short runs of a line, picked by a hash of seed and a counter; and statistics over them.
#pragma once

#include <cstdint>
#include <vector>

#include "host/render/tile_shape.h"
#include "scene_compiler/simulation.h"

namespace raycube::planner {

inline constexpr int kTrialRuns = 64, kRunPixels = 8;

/// At most `runs` runs of kRunPixels pixels (fewer at a line's end), in the order of the image; every pixel of a small image.
std::vector<render::Tile> trial_tiles(const scene::Instrument& instrument, std::uint64_t seed, int runs = kTrialRuns);

/// Radiances of the trial's pixels.
struct TrialImage {
  std::size_t bands = 0;
  std::vector<std::size_t> run_end;   ///< pixels up to and with each run
  std::vector<float> radiance;        ///< [pixel][band]
  std::size_t pixels() const { return bands ? radiance.size() / bands : 0; }
};

/// An error as DESIGN 5a has it, relative to the band's mean, of the worst band.
struct TrialError {
  double estimate = 0;   ///< from the mean square found (0 where that is below 0)
  double bound = 0;      ///< with one standard error of the mean square over the runs on top
};

/// Mean radiance of each band, held against 1e-4 of the largest.
std::vector<double> judged_means(const TrialImage& image);

/// Error of an image against the truth that `one` and `two` scatter about: E[(a - r1)(a - r2)] = E[(a - truth)^2] for references that
/// are without bias and independent of each other, however coarse they are.
TrialError error_against(const TrialImage& image, const TrialImage& one, const TrialImage& two, const std::vector<double>& mean);

/// Error of each of two images that differ by independent draws alone: half their mean squared difference.
TrialError error_between(const TrialImage& one, const TrialImage& two, const std::vector<double>& mean);

}  // namespace raycube::planner
