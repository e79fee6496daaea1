// Weight of each sample of a pixel.
#pragma once

#include <cstddef>
#include <vector>

#include "scene_compiler/simulation.h"

namespace raycube::sensors {

/// One weight per sample s, in the order of rc_sample_uv, sum 1. Sensor response = detector box of one pixel convolved
/// with the optics' Gaussian of psf_sigma_px, cut to the sampled square of psf_support_px and renormalised; each weight
/// is the response's exact integral over the sample's cell (closed form). Uniform weights for the plain box (sigma 0,
/// support 1). Throws Error(input) for a point spread with the lattice (its shifted points have no cells) and for a
/// support that cuts more than 1 % of the response: need psf_support_px >= 1 + 5 sigma or so.
std::vector<float> psf_weights(const scene::Instrument& instrument);

/// Interleaved parts of a pixel's samples whose means tell its standard error: of a grid the samples of even and odd
/// columns and rows, each a grid of twice the spacing; of a lattice, or a single row, every fourth.
inline constexpr int kSampleSubsets = 4;
/// Instead of a part: all samples.
inline constexpr int kAllSamples = -1;

/// The same weights a stretch at a time, so that memory does not grow with the samples of a pixel; relative to their
/// mean
/// 1 / count(), so that the plain box's are exactly 1.
class SampleWeights {
 public:
  explicit SampleWeights(const scene::Instrument& instrument);
  std::size_t count() const { return count_; }
  /// Weights of samples first .. first + count - 1 (inside the pixel's).
  std::vector<float> stretch(std::size_t first, std::size_t count) const;
  /// Those of one part of the samples: the others' are 0, and the part's sum over the pixel is what all samples' is.
  std::vector<float> stretch(std::size_t first, std::size_t count, int subset) const;
  int subset_of(std::size_t sample) const;
  /// Share of all weight that a part has.
  double share_of(int subset) const;
  /// Samples in each part at least one.

 private:
  std::size_t count_ = 0, columns_ = 1;  ///< columns_: of a grid with at least two rows and columns; else 0
  std::vector<double> along_, across_;   ///< shares of columns and rows, sum 1 each; empty for the plain box
};

}  // namespace raycube::sensors
