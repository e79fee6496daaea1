#include "host/planner/trial_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "kernels/sampling/sampler.h"

namespace raycube::planner {

namespace {

constexpr rc_u32 kTrialDimension = 43;  ///< of the hash: no sampler uses it
constexpr rc_u32 kDrawDimension = 46;   ///< of the hash, for the draws
constexpr double kDarkShare = 1e-4;     ///< DESIGN 5a: darker bands are judged against this share of the brightest

/// Mean over pixels of something with its variance, runs as the units: pixels side by side are not independent.
struct PixelMean {
  double average = 0, variance = 0;
};

/// Sums over runs, of which each counts by how it came to be drawn.
class RunSums {
 public:
  explicit RunSums(const TrialImage& image) : image_(image) {
    for (std::size_t r = 0; r < image.run_end.size(); ++r) draws_ += draw(r).times;
    pixels_per_run_ =
        image.pixels_per_run > 0
            ? image.pixels_per_run
            : static_cast<double>(image.pixels()) / static_cast<double>(std::max<std::size_t>(1, image.run_end.size()));
  }

  Draw draw(std::size_t run) const { return image_.draw.empty() ? Draw{} : image_.draw[run]; }
  double weight(std::size_t pixel) const {
    return image_.weight.empty() ? 1 : static_cast<double>(image_.weight[pixel]);
  }

  /// `square(pixel)` on average over what pixels weigh; `noise(pixel)`: variance of the square by the random points of
  /// the renders, for images that no draw of pixels makes uncertain.
  template <class Square, class Noise>
  PixelMean mean(Square square, Noise noise) const {
    const std::size_t runs = image_.run_end.size();
    std::vector<double> run(runs), counted(runs);
    double noise_sum = 0, all_weight = 0, weights = 0, sum = 0;
    std::size_t p = 0;
    for (std::size_t r = 0; r < runs; ++r) {
      for (; p < image_.run_end[r]; ++p) {
        const double w = weight(p);
        run[r] += w * square(p), counted[r] += w, all_weight += w;
        if (image_.whole) noise_sum += w * w * noise(p);
      }
      run[r] /= draw(r).share * pixels_per_run_, counted[r] /= draw(r).share * pixels_per_run_;
      sum += draw(r).times * run[r], weights += draw(r).times * counted[r];
    }
    PixelMean out;
    if (image_.weight.empty()) weights = draws_;
    if (!(weights > 0)) return out;
    out.average = sum / weights;
    const double of_weight = draws_ / weights * (draws_ / weights);
    if (image_.whole)
      out.variance = std::max(0.0, noise_sum) / (all_weight * all_weight);
    else if (draws_ > 1)
      out.variance = of_weight * spread(run, counted, out.average, false) / (draws_ - 1);
    // The runs drawn from are themselves but a part of the image.
    if (image_.drawn_from > 1)
      out.variance += of_weight * image_.left_out * spread(run, counted, out.average, true) / (image_.drawn_from - 1);
    return out;
  }

 private:
  /// Variance of a run over those drawn, or evenly over those drawn from; where pixels have weights of what a run has
  /// beyond the average of its weight.
  double spread(const std::vector<double>& run, const std::vector<double>& counted, double average, bool even) const {
    double squares = 0;
    for (std::size_t r = 0; r < run.size(); ++r) {
      const double beyond = image_.weight.empty() ? run[r] : run[r] - average * counted[r];
      squares += draw(r).times * beyond * beyond * (even ? draw(r).share : 1);
    }
    return std::max(0.0, squares / draws_ - (image_.weight.empty() ? average * average : 0));
  }

  const TrialImage& image_;
  double draws_ = 0, pixels_per_run_ = 0;
};

/// A figure of pixels' errors over their rms, and how much larger it may well be.
struct Tail {
  double ratio = 1, bound = 1;
};

constexpr double kQuantile = 0.99;
constexpr std::size_t kTailPixels = 16;  ///< at least, of the largest errors that the worst is extrapolated from

struct SeenError {
  double size = 0, weight = 0;
};

/// The size that errors of this share of all the weight do not exceed; sorted from the largest.
double size_at(const std::vector<SeenError>& seen, double all, double share) {
  double above = 0;
  for (const SeenError& each : seen)
    if ((above += each.weight) > (1 - share) * all * (1 + 1e-12)) return each.size;
  return seen.empty() ? 0 : seen.back().size;
}

/// The largest of `pixels` errors whose largest are seen: past the k-th as far as exponential excesses over it reach,
/// whose mean is that of those above it. The second is for a mean one standard error larger.
std::array<double, 2> extrapolated(const std::vector<SeenError>& seen, double all, double pixels) {
  const std::size_t k = std::min(seen.size() - 1, std::max(kTailPixels, seen.size() / 100));
  if (k == 0) return {seen[0].size, seen[0].size};
  const double from = seen[k].size;
  double above = 0, excess = 0;
  for (std::size_t i = 0; i < k; ++i) above += seen[i].weight, excess += seen[i].weight * (seen[i].size - from);
  const double reach = excess / above * std::log(std::max(1.0, above / all * pixels));
  return {std::max(seen[0].size, from + reach),
          std::max(seen[0].size, from + reach * (1 + 1 / std::sqrt(static_cast<double>(k))))};
}

/// Of the errors whose squares `seen_square(pixel, draw)` are, each pixel's of so many draws.
template <class SeenSquare>
Tail tail_of(const TrialImage& image, const RunSums& sums, int draws, SeenSquare seen_square) {
  std::vector<SeenError> seen;
  double all = 0, squares = 0, counted = 0;
  std::size_t p = 0;
  for (std::size_t r = 0; r < image.run_end.size(); ++r)
    for (; p < image.run_end[r]; ++p) {
      const double weight = sums.weight(p) * sums.draw(r).times / sums.draw(r).share;
      if (!(weight > 0)) continue;
      ++counted;
      for (int draw = 0; draw < draws; ++draw) {
        const double square = seen_square(p, draw);
        seen.push_back({std::sqrt(square), weight});
        all += weight, squares += weight * square;
      }
    }
  if (!(squares > 0)) return {};
  std::sort(seen.begin(), seen.end(), [](const SeenError& a, const SeenError& b) { return a.size > b.size; });
  const double rms = std::sqrt(squares / all);
  if (image.figure == scene::ErrorFigure::p99) {
    // What share lies above is known by the weights of those that do; of an image that is tried whole it is seen.
    const double size = size_at(seen, all, kQuantile);
    double squares_above = 0;
    for (const SeenError& each : seen)
      if (each.size >= size) squares_above += each.weight * each.weight;
    const double deviation = image.whole ? 0 : std::sqrt(draws * squares_above) / all;
    return {size / rms, size_at(seen, all, std::min(1.0, kQuantile + deviation)) / rms};
  }
  if (image.whole) return {seen[0].size / rms, seen[0].size / rms};
  const double runs = image.drawn_from > 0 ? image.drawn_from : static_cast<double>(image.run_end.size());
  const double tried = static_cast<double>(std::max<std::size_t>(1, image.pixels()));
  const double pixels = runs * (image.pixels_per_run > 0 ? image.pixels_per_run : tried / runs) /
                        std::max(1e-9, 1 - image.left_out) * counted / tried;
  const auto [largest, bound] = extrapolated(seen, all, pixels);
  return {largest / rms, bound / rms};
}

/// The image's figure in the worst and in every band, over the judged mean: of a mean over pixels of `square(value)`
/// with its `noise`, and for figures other than the rms of what is seen of single pixels, `seen_square(value, draw)`.
template <class Square, class Noise, class SeenSquare>
TrialError errors_of(const TrialImage& image, const std::vector<double>& mean, Square square, Noise noise, int draws,
                     SeenSquare seen_square) {
  TrialError out;
  const RunSums sums(image);
  for (std::size_t b = 0; b < image.bands; ++b) {
    const auto value = [&](std::size_t pixel) { return pixel * image.bands + b; };
    const PixelMean found =
        sums.mean([&](std::size_t p) { return square(value(p)); }, [&](std::size_t p) { return noise(value(p)); });
    const double deviation = std::sqrt(found.variance);
    const double here = found.average / (mean[b] * mean[b]), bound = here + deviation / (mean[b] * mean[b]);
    Tail tail;
    if (image.figure != scene::ErrorFigure::rms)
      tail = tail_of(image, sums, draws, [&](std::size_t p, int draw) { return seen_square(value(p), draw); });
    out.bands.estimate.push_back(tail.ratio * std::sqrt(std::max(0.0, here)));
    out.bands.bound.push_back(tail.bound * std::sqrt(std::max(0.0, bound)));
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
      sum += (one.weight.empty() ? 1 : static_cast<double>(one.weight[i / one.bands])) *
             std::pow((static_cast<double>(one.radiance[i]) - two.radiance[i]) / mean[i % one.bands], 2);
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
  if (image.weight.empty()) {
    for (std::size_t i = 0; i < image.radiance.size(); ++i) sums[i % image.bands] += image.radiance[i];
    return judged_means(std::move(sums), static_cast<double>(std::max<std::size_t>(1, image.pixels())));
  }
  double pixels = 0;
  for (const float weight : image.weight) pixels += weight;
  for (std::size_t i = 0; i < image.radiance.size(); ++i)
    sums[i % image.bands] += static_cast<double>(image.weight[i / image.bands]) * image.radiance[i];
  return judged_means(std::move(sums), pixels);
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
  return errors_of(image, mean, square, noise, 1, [&](std::size_t i, int) {
    const double seen = 0.5 * ((static_cast<double>(image.radiance[i]) - one.radiance[i]) +
                               (static_cast<double>(again.radiance[i]) - two.radiance[i]));
    return seen * seen;
  });
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
  return errors_of(
      one, mean, square, [&](std::size_t i) { return 2.0 / 3 * square(i) * square(i); }, 1,
      [&](std::size_t i, int) { return square(i); });
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
  return errors_of(
      one, mean, square,
      [&](std::size_t i) {
        const double first = square_of(one, one_again, i), second = square_of(two, two_again, i);
        return (first * first + second * second) / 6;
      },
      2,
      [&](std::size_t i, int draw) { return draw == 0 ? square_of(one, one_again, i) : square_of(two, two_again, i); });
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
  // Of single pixels the means under both draws of what tells them apart differ by e and half as much of the rest.
  return errors_of(one, mean, square, noise, 1, [&](std::size_t i, int) {
    const double difference = 0.5 * ((static_cast<double>(one.radiance[i]) - two.radiance[i]) +
                                     (static_cast<double>(one_again.radiance[i]) - two_again.radiance[i]));
    return 0.5 * difference * difference;
  });
}

}  // namespace raycube::planner
