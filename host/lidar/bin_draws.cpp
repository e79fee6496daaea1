#include "host/lidar/bin_draws.h"

#include <cmath>

#include "host/base/wide.h"
#include "host/lidar/normal_quantile.h"
#include "kernels/sampling/sampler.h"

namespace raycube::lidar {
namespace {

/// Exact, by the conversion that vector instructions have.
inline __attribute__((always_inline)) double number(std::uint32_t bits) {
  return static_cast<double>(static_cast<std::int32_t>(bits ^ 0x80000000u)) + 0x1p31;
}

/// The first uniform of each bin's stream, Stream::uniform.
RAYCUBE_WIDE void first_uniforms(std::uint32_t seed, std::uint32_t key, std::uint32_t first, std::uint32_t counter,
                                 std::size_t count, double* to) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t bin = first + static_cast<std::uint32_t>(i);
    const std::uint32_t high = rc_hash(seed, key, bin, counter), low = rc_hash(seed ^ kLowBits, key, bin, counter);
    to[i] = (number(high) * 0x1p21 + number(low >> 11) + 0.5) * 0x1p-53;
  }
}

/// 0 for bins whose first uniform, of which half the bits are enough, says that nothing is counted; else 1.
RAYCUBE_WIDE void may_count(std::uint32_t seed, std::uint32_t key, std::uint32_t first, std::uint32_t counter,
                            std::size_t count, const double* mean, std::uint8_t* to) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t high = rc_hash(seed, key, first + static_cast<std::uint32_t>(i), counter);
    const bool none = (number(high) + 1) * 0x1p-32 <= 1 - mean[i];  // then the whole is, as Stream::poisson wants it
    to[i] = none ? 0 : 1;
  }
}

/// Quantiles of each that lies in the middle; of others anything.
RAYCUBE_WIDE void middle_quantiles(std::size_t count, const double* uniform, double* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = normal_quantile_middle(uniform[i] - 0.5);
}

/// Quantiles beyond the middle, r as normal_quantile has it at most 5.
RAYCUBE_WIDE void outer_quantiles(std::size_t count, const double* uniform, double* to) {
  for (std::size_t i = 0; i < count; ++i) to[i] = normal_quantile_outer(uniform[i]);
}

}  // namespace

void BinDraws::counts(std::size_t first, std::size_t count, const double* mean, double* to) {
  may_.resize(count);
  may_count(seed_.bits(), key_, static_cast<std::uint32_t>(first), first_counter(DrawFor::counts, line_), count, mean,
            may_.data());
  for (std::size_t i = 0; i < count; ++i)
    to[i] = may_[i] == 0
                ? 0
                : Stream(seed_, key_, static_cast<std::uint32_t>(first + i), DrawFor::counts, line_).poisson(mean[i]);
}

void BinDraws::add_readout(std::size_t first, std::size_t count, double scale, double* to) {
  uniform_.resize(count), normal_.resize(count);
  first_uniforms(seed_.bits(), key_, static_cast<std::uint32_t>(first), first_counter(DrawFor::readout, line_), count,
                 uniform_.data());
  middle_quantiles(count, uniform_.data(), normal_.data());
  outer_.clear(), outer_uniform_.clear();
  for (std::size_t i = 0; i < count; ++i)
    if (std::abs(uniform_[i] - 0.5) > kQuantileMiddle) outer_.push_back(i), outer_uniform_.push_back(uniform_[i]);
  outer_normal_.resize(outer_.size());
  outer_quantiles(outer_.size(), outer_uniform_.data(), outer_normal_.data());
  for (std::size_t k = 0; k < outer_.size(); ++k)
    normal_[outer_[k]] = is_far(outer_uniform_[k]) ? normal_quantile(outer_uniform_[k]) : outer_normal_[k];
  for (std::size_t i = 0; i < count; ++i) to[i] += scale * normal_[i];
}

}  // namespace raycube::lidar
