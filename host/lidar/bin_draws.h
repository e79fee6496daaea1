// Draws for all bins of a record at once: the same numbers as a Stream for each bin.
#pragma once

#include <cstddef>
#include <vector>

#include "host/lidar/draws.h"

namespace raycube::lidar {

/// Of one record, from one to the next.
class BinDraws {
 public:
  BinDraws(DrawSeed seed, std::uint32_t key, int line) : seed_(seed), key_(key), line_(line) {}
  void record(std::uint32_t key, int line) { key_ = key, line_ = line; }

  /// to[i] = Stream(seed, key, first + i, counts, line).poisson(mean[i]), i below `count`.
  void counts(std::size_t first, std::size_t count, const double* mean, double* to);
  /// to[i] += scale * Stream(seed, key, first + i, readout, line).normal().
  void add_readout(std::size_t first, std::size_t count, double scale, double* to);

 private:
  DrawSeed seed_;
  std::uint32_t key_;
  int line_;
  std::vector<std::uint8_t> may_;
  std::vector<double> uniform_, normal_, outer_uniform_, outer_normal_;
  std::vector<std::size_t> outer_;  ///< bins whose normals lie outside of the middle
};

}  // namespace raycube::lidar
