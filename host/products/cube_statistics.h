// Minimum, maximum, mean and standard deviation of each band, in one pass over the file with bounded memory.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "host/products/envi_reader.h"

namespace raycube::products {

struct BandStatistics {
  std::uint64_t count = 0;       ///< finite samples that are not the header's data ignore value
  std::uint64_t ignored = 0;     ///< equal to the data ignore value
  std::uint64_t not_finite = 0;  ///< NaN or infinite
  double min = 0, max = 0, mean = 0;
  double sum_squares = 0;  ///< of deviations from the mean (Welford 1962; merges after Chan et al. 1979)
  /// Sample standard deviation, N - 1 in the denominator; 0 below two samples.
  double standard_deviation() const;
  void add(double value);
  void merge(const BandStatistics& other);
};

/// One per band, of the scaled values; of a complex file the magnitudes. after_lines is called with the number of lines
/// just done, for progress and interrupts.
std::vector<BandStatistics> band_statistics(const EnviReader& reader,
                                            const std::function<void(std::int64_t)>& after_lines = {});

/// All bands together.
BandStatistics merged(const std::vector<BandStatistics>& bands);

}  // namespace raycube::products
