#include "host/planner/trial_pixels.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "kernels/sampling/sampler.h"

namespace raycube::planner {

namespace {

constexpr rc_u32 kTrialDimension = 43;  ///< of the hash: no sampler uses it
constexpr rc_u32 kDrawDimension = 46;   ///< of the hash, for the draws
constexpr double kDarkShare = 1e-4;     ///< DESIGN 5a: darker bands are judged against this share of the brightest

/// Worst and every band of a mean over pixels of `square(pixel, band)`, over the judged mean squared. A run that was
/// drawn with more than an even chance counts for less. `noise(pixel, band)`: variance of the square by the random
/// points of the renders, for images that no draw of pixels makes uncertain.
template <class Square, class Noise>
TrialError errors_of(const TrialImage& image, const std::vector<double>& mean, Square square, Noise noise) {
  TrialError out;
  const std::size_t runs = image.run_end.size();
  double draws = 0;
  for (std::size_t r = 0; r < runs; ++r) draws += image.draw.empty() ? 1 : image.draw[r].times;
  const double pixels_per_run = image.pixels_per_run > 0 ? image.pixels_per_run
                                                         : static_cast<double>(image.pixels()) /
                                                               static_cast<double>(std::max<std::size_t>(1, runs));
  for (std::size_t b = 0; b < image.bands; ++b) {
    // Runs as the units of the standard error: pixels side by side are not independent.
    double sum = 0, square_sum = 0, even_square_sum = 0, noise_sum = 0;
    std::size_t p = 0;
    for (std::size_t r = 0; r < runs; ++r) {
      double run = 0;
      for (; p < image.run_end[r]; ++p) {
        run += square(p * image.bands + b);
        if (image.whole) noise_sum += noise(p * image.bands + b);
      }
      const Draw draw = image.draw.empty() ? Draw{} : image.draw[r];
      run /= draw.share * pixels_per_run;
      sum += draw.times * run;
      square_sum += draw.times * run * run;
      even_square_sum += draw.times * run * run * draw.share;
    }
    const double average = sum / draws;
    const double pixels = static_cast<double>(image.pixels());
    double variance = image.whole ? std::max(0.0, noise_sum) / (pixels * pixels)
                      : draws > 1 ? std::max(0.0, square_sum / draws - average * average) / (draws - 1)
                                  : 0;
    // The runs drawn from are themselves but a part of the image.
    if (image.drawn_from > 1)
      variance += image.left_out * std::max(0.0, even_square_sum / draws - average * average) / (image.drawn_from - 1);
    const double deviation = std::sqrt(variance);
    const double here = average / (mean[b] * mean[b]), bound = here + deviation / (mean[b] * mean[b]);
    out.bands.estimate.push_back(std::sqrt(std::max(0.0, here)));
    out.bands.bound.push_back(std::sqrt(std::max(0.0, bound)));
  }
  out.estimate = out.bands.worst_estimate(), out.bound = out.bands.worst_bound();
  return out;
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
    const std::uint64_t low =
        rc_hash(static_cast<rc_u32>(seed), i, static_cast<rc_u32>(seed >> 32), kTrialDimension + 1);
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

std::vector<Draw> draw_runs(const std::vector<double>& error, std::uint64_t seed, int draws, int whole) {
  std::vector<Draw> out;
  const std::size_t runs = error.size();
  if (runs <= static_cast<std::size_t>(whole)) {
    for (std::size_t r = 0; r < runs; ++r) out.push_back({r, 1, 1.0});
    return out;
  }
  double sum = 0, roots = 0;
  for (const double e : error) sum += e, roots += std::sqrt(e);
  const double even = 1.0 / static_cast<double>(runs);
  const auto chance = [&](std::size_t r) {
    return 0.25 * even + 0.5 * (sum > 0 ? error[r] / sum : even) +
           0.25 * (roots > 0 ? std::sqrt(error[r]) / roots : even);
  };
  const double step = 1.0 / draws;
  double next = step *
                rc_unit_float(rc_hash(static_cast<rc_u32>(seed), 0, static_cast<rc_u32>(seed >> 32), kDrawDimension)),
         reached = 0;
  for (std::size_t r = 0; r < runs; ++r) {
    reached += chance(r);
    Draw draw{r, 0, chance(r) / even};
    for (; next < reached; next += step) ++draw.times;
    if (draw.times > 0) out.push_back(draw);
  }
  return out;
}

std::vector<double> run_differences(const TrialImage& one, const TrialImage& two, const std::vector<double>& mean) {
  std::vector<double> out;
  std::size_t i = 0;
  for (const std::size_t end : one.run_end) {
    double sum = 0;
    for (; i < end * one.bands; ++i)
      sum += std::pow((static_cast<double>(one.radiance[i]) - two.radiance[i]) / mean[i % one.bands], 2);
    out.push_back(sum / static_cast<double>(one.bands));
  }
  return out;
}

std::vector<render::Tile> joined(const std::vector<render::Tile>& runs, int columns) {
  std::vector<render::Tile> out;
  for (const render::Tile& run : runs) {
    if (!out.empty()) {
      render::Tile& last = out.back();
      if (last.first_line == run.first_line && last.first_column + last.columns == run.first_column &&
          last.columns + run.columns <= columns) {
        last.columns += run.columns;
        continue;
      }
    }
    out.push_back(run);
  }
  return out;
}

std::vector<double> judged_means(const TrialImage& image) {
  std::vector<double> sums(image.bands, 0.0);
  for (std::size_t i = 0; i < image.radiance.size(); ++i) sums[i % image.bands] += image.radiance[i];
  return judged_means(std::move(sums), static_cast<double>(std::max<std::size_t>(1, image.pixels())));
}

std::vector<double> judged_means(std::vector<double> mean, double pixels) {
  double largest = 0;
  for (double& m : mean) m = std::abs(m) / pixels, largest = std::max(largest, m);
  for (double& m : mean) m = std::max({m, kDarkShare * largest, 1e-300});
  return mean;
}

TrialError of_pixels(TrialError error, const scene::Instrument& instrument) {
  const double share = instrument.share_of_draws;
  error.estimate *= share, error.bound *= share;
  for (auto* values : {&error.bands.estimate, &error.bands.bound})
    for (double& value : *values) value *= share;
  return error;
}

TrialError common_error(const TrialImage& image, const TrialImage& again, const TrialImage& one, const TrialImage& two,
                        const std::vector<double>& mean) {
  const auto square = [&](std::size_t i) {
    return (static_cast<double>(image.radiance[i]) - one.radiance[i]) *
           (static_cast<double>(again.radiance[i]) - two.radiance[i]);
  };
  // The factors are e + n1 and e + n2, n Gaussian of variance s^2; d = n1 - n2: the product's variance is 2 e^2 s^2 +
  // s^4, and the means of product d^2 and of d^4 / 4 are 2 e^2 s^2 - 2 s^4 and 3 s^4.
  const auto noise = [&](std::size_t i) {
    const double d = (static_cast<double>(image.radiance[i]) - one.radiance[i]) -
                     (static_cast<double>(again.radiance[i]) - two.radiance[i]);
    return d * d * (square(i) + 0.25 * d * d);
  };
  return errors_of(image, mean, square, noise);
}

TrialError error_against(const TrialImage& image, const TrialImage& one, const TrialImage& two,
                         const std::vector<double>& mean) {
  return common_error(image, image, one, two, mean);
}

TrialError error_from(const TrialImage& image, const TrialImage& truth, const std::vector<double>& mean) {
  return error_against(image, truth, truth, mean);
}

TrialError error_between(const TrialImage& one, const TrialImage& two, const std::vector<double>& mean) {
  const auto square = [&](std::size_t i) {
    const double difference = static_cast<double>(one.radiance[i]) - two.radiance[i];
    return 0.5 * difference * difference;
  };
  // q = d^2 / 2 of Gaussian draws: q^2 is 3 (E q)^2 in the mean, of which the variance is two thirds.
  return errors_of(one, mean, square, [&](std::size_t i) { return 2.0 / 3 * square(i) * square(i); });
}

TrialError error_between_pairs(const TrialImage& one, const TrialImage& one_again, const TrialImage& two,
                               const TrialImage& two_again, const std::vector<double>& mean) {
  const auto square_of = [](const TrialImage& a, const TrialImage& b, std::size_t i) {
    const double difference = static_cast<double>(a.radiance[i]) - b.radiance[i];
    return 0.5 * difference * difference;
  };
  const auto square = [&](std::size_t i) {
    return 0.5 * (square_of(one, one_again, i) + square_of(two, two_again, i));
  };
  // As in error_between, of the mean of two.
  return errors_of(one, mean, square, [&](std::size_t i) {
    const double first = square_of(one, one_again, i), second = square_of(two, two_again, i);
    return (first * first + second * second) / 6;
  });
}

TrialError common_spread(const TrialImage& one, const TrialImage& one_again, const TrialImage& two,
                         const TrialImage& two_again, const std::vector<double>& mean) {
  const auto square = [&](std::size_t i) {
    return 0.5 * (static_cast<double>(one.radiance[i]) - two.radiance[i]) *
           (static_cast<double>(one_again.radiance[i]) - two_again.radiance[i]);
  };
  // The factors are e + n1 and e + n2, all Gaussian, of variances u and v; q half their product, d = n1 - n2. The means
  // of q^2, q d^2 and d^4 are (3 u^2 + 2 u v + v^2) / 4, u v - v^2 and 12 v^2; the variance of q is (2 u^2 + 2 u v +
  // v^2) / 4 = 2/3 q^2 + q d^2 / 6 + d^4 / 48 in the mean.
  const auto noise = [&](std::size_t i) {
    const double d = (static_cast<double>(one.radiance[i]) - two.radiance[i]) -
                     (static_cast<double>(one_again.radiance[i]) - two_again.radiance[i]);
    const double q = square(i), d2 = d * d;
    return 2.0 / 3 * q * q + q * d2 / 6 + d2 * d2 / 48;
  };
  return errors_of(one, mean, square, noise);
}

}  // namespace raycube::planner
