// Loops over the bins of a record.
#pragma once

#include <cstddef>
#include <cstdint>

namespace raycube::lidar {

/// to[i] = factor from[i], or more of it.
void scale_bins(const float* from, double factor, std::size_t count, double* to);
void add_scaled_bins(const float* from, double factor, std::size_t count, double* to);
/// Largest value, at least 0.
double largest_of(const double* bins, std::size_t count);
struct BinSums {
  double sum = 0, largest = 0;
};
BinSums sums_of(const float* bins, std::size_t count);
/// First bin that is not 0, `count` if all are; and one past the last.
std::size_t first_lit(const double* bins, std::size_t count);
std::size_t past_lit(const double* bins, std::size_t count);

/// Digitiser's steps of values: samples of 0 to `steps`, and what they stand for, offset + gain sample. Returns whether
/// one is at full scale.
bool digitise_bins(const double* values, std::size_t count, double offset, double gain, double steps,
                   std::uint16_t* samples, float* back);
/// Samples of 16 bits of value / gain, and the values.
void store_bins(const double* values, std::size_t count, double gain, std::uint16_t* samples, float* back);

}  // namespace raycube::lidar
