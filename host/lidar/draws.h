// Random numbers as functions of what they are for: results do not depend on the order in which they are asked for.
#pragma once

#include <cstdint>

namespace raycube::lidar {

/// What a draw is for; part of its counter.
enum class DrawFor : std::uint32_t { speckle, counts, gain, readout, geiger, scintillation, wander, tilt };

/// A uniform draw's low bits come of another seed.
constexpr std::uint32_t kLowBits = 0x9E3779B9u;

/// Counter of a stream's first draw.
constexpr std::uint32_t first_counter(DrawFor purpose, int line) {
  return (static_cast<std::uint32_t>(line) * 16u + static_cast<std::uint32_t>(purpose)) << 16;
}

/// A seed made ready for streams; converts from the seed itself.
class DrawSeed {
 public:
  DrawSeed(std::uint64_t seed);  // NOLINT: a seed is a seed
  std::uint32_t bits() const { return bits_; }

 private:
  std::uint32_t bits_;
};

/// Draws of one purpose at one place (a bin, a cell, an event) of one record. Same arguments: same numbers. rc_hash of
/// (seed, key, index, line / purpose / count): up to 65536 uniforms a stream, 4096 lines.
class Stream {
 public:
  Stream(DrawSeed seed, std::uint32_t key, std::uint32_t index, DrawFor purpose, int line = 0);

  double uniform();            ///< in (0, 1), 53 bits
  double normal();             ///< mean 0, variance 1; inverse of the distribution function (normal_quantile.h)
  double exponential();        ///< mean 1
  double gamma(double shape);  ///< mean and variance `shape` > 0; Marsaglia & Tsang, ACM TOMS 26 (2000) 363
  /// Count with a mean >= 0: inversion below 10, PTRS (Hoermann, Insurance: Math. and Econ. 12 (1993) 39) up to 1e6,
  /// both exact; above, a Gaussian rounded to whole counts. Not a number stays not a number.
  double poisson(double mean);
  /// Photo-electrons of light with `modes` speckle modes: Poisson(Gamma(modes, mean / modes)); modes 0: Poisson.
  double negative_binomial(double mean, double modes);

 private:
  std::uint32_t seed_, key_, index_, counter_;
};

}  // namespace raycube::lidar
