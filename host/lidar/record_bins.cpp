#include "host/lidar/record_bins.h"

#include <cmath>

#include "host/base/wide.h"

namespace raycube::lidar {
namespace {

/// Nearest whole number of 0 to `most`, halves upwards, as std::round has them.
inline __attribute__((always_inline)) double whole(double x, double most) {
  const double below = std::trunc(x), near = x - below >= 0.5 ? below + 1 : below;
  const double least = near > 0 ? near : 0;
  return least < most ? least : most;
}

constexpr std::size_t kDark = 8;  ///< bins looked at together
inline bool dark(const double* bins) {
  unsigned lit = 0;
  for (std::size_t k = 0; k < kDark; ++k) lit |= static_cast<unsigned>(bins[k] != 0);
  return lit == 0;
}

}  // namespace

RAYCUBE_WIDE void scale_bins(const float* from, double factor, std::size_t count, double* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = factor * static_cast<double>(from[i]);
}

RAYCUBE_WIDE void add_scaled_bins(const float* from, double factor, std::size_t count, double* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * static_cast<double>(from[i]);
}

RAYCUBE_WIDE double largest_of(const double* bins, std::size_t count) {
  constexpr std::size_t kLanes = 8;
  double of[kLanes] = {}, largest = 0;
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) of[k] = of[k] < bins[i + k] ? bins[i + k] : of[k];
  for (; i < count; ++i) largest = largest < bins[i] ? bins[i] : largest;
  for (const double lane : of) largest = largest < lane ? lane : largest;
  return largest;
}

RAYCUBE_WIDE BinSums sums_of(const float* bins, std::size_t count) {
  constexpr std::size_t kLanes = 8;
  double sum[kLanes] = {}, largest[kLanes] = {};
  std::size_t i = 0;
  for (; i + kLanes <= count; i += kLanes)
    for (std::size_t k = 0; k < kLanes; ++k) {
      const double bin = static_cast<double>(bins[i + k]);
      sum[k] += bin, largest[k] = largest[k] < bin ? bin : largest[k];
    }
  BinSums out;
  for (; i < count; ++i) {
    const double bin = static_cast<double>(bins[i]);
    out.sum += bin, out.largest = out.largest < bin ? bin : out.largest;
  }
  for (std::size_t k = 0; k < kLanes; ++k)
    out.sum += sum[k], out.largest = out.largest < largest[k] ? largest[k] : out.largest;
  return out;
}

std::size_t first_lit(const double* bins, std::size_t count) {
  std::size_t i = 0;
  while (i + kDark <= count && dark(bins + i)) i += kDark;
  while (i < count && bins[i] == 0) ++i;
  return i;
}

std::size_t past_lit(const double* bins, std::size_t count) {
  while (count >= kDark && dark(bins + count - kDark)) count -= kDark;
  while (count > 0 && bins[count - 1] == 0) --count;
  return count;
}

RAYCUBE_WIDE bool digitise_bins(const double* values, std::size_t count, double offset, double gain, double steps,
                                std::uint16_t* samples, float* back) {
  std::uint32_t full = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double sample = whole((values[i] - offset) / gain, steps);
    full |= static_cast<std::uint32_t>(sample == steps);
    samples[i] = static_cast<std::uint16_t>(static_cast<std::int32_t>(sample));
    back[i] = static_cast<float>(offset + gain * sample);
  }
  return full != 0;
}

RAYCUBE_WIDE void store_bins(const double* values, std::size_t count, double gain, std::uint16_t* samples,
                             float* back) {
  for (std::size_t i = 0; i < count; ++i) {
    samples[i] = static_cast<std::uint16_t>(static_cast<std::int32_t>(whole(values[i] / gain, 65535.0)));
    back[i] = static_cast<float>(values[i]);
  }
}

}  // namespace raycube::lidar
