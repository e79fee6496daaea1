// Classes by k-means: each pixel belongs to the centre that is nearest, each centre is the mean of its pixels.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/analysis/cube.h"

namespace raycube::analysis {

struct KMeansOptions {
  int classes = 5;
  /// spread: along the mean, from one standard deviation of each band below it to one above; plusplus: pixels drawn by
  /// their squared distance from the centres so far (Arthur & Vassilvitskii 2007).
  std::string start = "spread";
  std::uint64_t seed = 1;
  double least_change = 0;  ///< ends when no larger share of pixels changes its class
  int most_rounds = 100;
};

struct KMeans {
  Eigen::MatrixXd center;             ///< [class][band]
  std::vector<std::uint64_t> count;   ///< pixels of each; 0: its centre stayed where it was
  std::vector<std::uint16_t> number;  ///< [pixel]: its class in the last round, from 1; 0: it does not count
  int rounds = 0;
  double changed = 0;    ///< share of pixels in the last round
  double rms_apart = 0;  ///< of pixels from their centres, over pixels, of the sum over bands
};

/// Lloyd's rounds (IEEE Trans. Inf. Theory 28, 1982). Each pixel is known in short, by its coordinates along eight
/// principal directions and how far it is from their space; distances to centres are bounded by these, and only pixels
/// for which the bounds do not say which is nearest are looked at whole: the classes of each round are those of the
/// plain rounds. The same bits on any number of threads. Takes 80 bytes a pixel. Throws Error(input): fewer pixels than
/// classes, or all alike.
KMeans k_means(const Cube& cube, const KMeansOptions& options, const Pass& pass);

}  // namespace raycube::analysis
