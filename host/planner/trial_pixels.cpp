#include "host/planner/trial_pixels.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "kernels/sampling/sampler.h"

namespace raycube::planner {

namespace {

constexpr rc_u32 kTrialDimension = 43;  ///< of the hash: no sampler uses it
constexpr double kDarkShare = 1e-4;     ///< DESIGN 5a: darker bands are judged against this share of the brightest

/// Worst band of a mean over pixels of `square(pixel, band)`, over the judged mean squared.
template <class Square>
TrialError worst_band(const TrialImage& image, const std::vector<double>& mean, Square square) {
  TrialError worst;
  double worst_square = 0, worst_bound = 0;
  const double runs = static_cast<double>(image.run_end.size());
  for (std::size_t b = 0; b < image.bands; ++b) {
    // Runs as the units of the standard error: pixels side by side are not independent.
    double sum = 0, square_sum = 0;
    std::vector<double> of_run;
    std::size_t p = 0;
    for (const std::size_t end : image.run_end) {
      double run = 0;
      for (; p < end; ++p) run += square(p * image.bands + b);
      of_run.push_back(run);
      sum += run;
    }
    const double pixels = static_cast<double>(image.pixels()), average = sum / runs;
    for (const double run : of_run) square_sum += (run - average) * (run - average);
    const double deviation = runs > 1 ? std::sqrt(square_sum / (runs - 1) / runs) * runs / pixels : 0;
    const double here = sum / pixels / (mean[b] * mean[b]), bound = here + deviation / (mean[b] * mean[b]);
    worst_square = std::max(worst_square, here);
    worst_bound = std::max(worst_bound, bound);
  }
  worst.estimate = std::sqrt(std::max(0.0, worst_square));
  worst.bound = std::sqrt(std::max(0.0, worst_bound));
  return worst;
}

}  // namespace

std::vector<render::Tile> trial_tiles(const scene::Instrument& instrument, std::uint64_t seed, int runs) {
  const int per_line = (instrument.pixels + kRunPixels - 1) / kRunPixels;
  const std::uint64_t all = static_cast<std::uint64_t>(per_line) * static_cast<std::uint64_t>(instrument.lines);
  std::set<std::uint64_t> places;
  if (all <= static_cast<std::uint64_t>(runs))
    for (std::uint64_t i = 0; i < all; ++i) places.insert(i);
  // A 64-bit place from two draws: an image may have more than 2^32 runs.
  for (rc_u32 i = 0; places.size() < std::min<std::uint64_t>(all, static_cast<std::uint64_t>(runs)); ++i) {
    const std::uint64_t high = rc_hash(static_cast<rc_u32>(seed), i, static_cast<rc_u32>(seed >> 32), kTrialDimension);
    const std::uint64_t low = rc_hash(static_cast<rc_u32>(seed), i, static_cast<rc_u32>(seed >> 32), kTrialDimension + 1);
    places.insert((high << 32 | low) % all);
  }
  std::vector<render::Tile> tiles;
  for (const std::uint64_t place : places) {
    const int line = static_cast<int>(place / static_cast<std::uint64_t>(per_line));
    const int column = static_cast<int>(place % static_cast<std::uint64_t>(per_line)) * kRunPixels;
    tiles.push_back({line, 1, column, std::min(kRunPixels, instrument.pixels - column)});
  }
  return tiles;
}

std::vector<double> judged_means(const TrialImage& image) {
  std::vector<double> mean(image.bands, 0.0);
  for (std::size_t i = 0; i < image.radiance.size(); ++i) mean[i % image.bands] += image.radiance[i];
  double largest = 0;
  for (double& m : mean) m = std::abs(m) / static_cast<double>(std::max<std::size_t>(1, image.pixels())), largest = std::max(largest, m);
  for (double& m : mean) m = std::max({m, kDarkShare * largest, 1e-300});
  return mean;
}

TrialError error_against(const TrialImage& image, const TrialImage& one, const TrialImage& two, const std::vector<double>& mean) {
  return worst_band(image, mean, [&](std::size_t i) {
    const double a = image.radiance[i];
    return (a - one.radiance[i]) * (a - two.radiance[i]);
  });
}

TrialError error_between(const TrialImage& one, const TrialImage& two, const std::vector<double>& mean) {
  return worst_band(one, mean, [&](std::size_t i) {
    const double difference = static_cast<double>(one.radiance[i]) - two.radiance[i];
    return 0.5 * difference * difference;
  });
}

}  // namespace raycube::planner
