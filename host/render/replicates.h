// An image as the mean of replicates: renders that differ by their seeds alone, in the shifts of their samples and in
// their rays into the sky. Their spread says what the mean errs, on every pixel and without a reference.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/render/types.h"

namespace raycube::render {

/// Seed of a replicate; of the first the render's own.
std::uint64_t replicate_seed(std::uint64_t seed, int replicate);

/// Sums over replicates of some pixels in order. Two replicates at least have a spread.
class ReplicateSums {
 public:
  /// shares: layers that are shares of a pixel, the materials' abundances first.
  ReplicateSums(std::size_t pixels, std::size_t bands, std::size_t materials, std::size_t shares);

  /// Some pixels of one replicate: radiance [pixel][band], truth [pixel][layers].
  void add(std::size_t first_pixel, std::size_t pixels, const float* radiance, const float* truth, std::size_t layers);
  /// All pixels of a replicate have been added.
  void next() { ++count_; }
  int count() const { return count_; }

  /// The mean so far. The same bits whatever parts it was added in.
  void mean(std::size_t first_pixel, std::size_t pixels, float* radiance, float* truth, std::size_t layers) const;
  /// Of the first so many bands.
  ReplicateSpread spread(std::size_t bands) const;
  ReplicateSpread spread() const { return spread(bands_); }

 private:
  std::size_t pixels_, bands_, materials_, shares_, layers_;
  int count_ = 0;
  std::vector<double> radiance_, square_, truth_;
};

/// An image whose replicates have been rendered already, small objects aside.
struct RenderedImage {
  ReplicateSums sums;
  RenderStatistics statistics;
  double render_s = 0, processor_s = 0;  ///< that it took
};

}  // namespace raycube::render
