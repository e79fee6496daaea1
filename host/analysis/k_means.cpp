#include "host/analysis/k_means.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "host/analysis/dense_sums.h"
#include "host/base/error.h"
#include "host/base/parallel.h"
#include "host/products/cube_statistics.h"
#include "scene_compiler/counter_random.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-12;  ///< of a distance: bounds are wider by this, so that rounding decides nothing
constexpr std::uint16_t kNone = 0xffff;

/// A cube that is gone through again and again: kept as floats where that fits and loses nothing.
class Rounds {
 public:
  Rounds(const Cube& cube, std::uint64_t memory_bytes, const Pass& pass) : cube_(cube), pass_(pass) {
    keeps_ = cube.header().data_type == 4 && cube.header().data_gain.empty() && cube.header().data_offset.empty() &&
             !cube.header().reflectance_scale_factor && cube.pixels() * cube.bands() * sizeof(float) <= memory_bytes;
    if (!keeps_) return;
    kept_.resize(cube.pixels() * cube.bands()), counts_.resize(cube.pixels());
    for_each_part(cube, pass, [&](std::size_t, const Pixels& pixels) {
      const auto first = static_cast<std::size_t>(pixels.first_line * pixels.samples);
      std::copy(pixels.counts.begin(), pixels.counts.end(), counts_.begin() + static_cast<std::ptrdiff_t>(first));
      float* const to = kept_.data() + first * pixels.bands;
      for (std::size_t i = 0; i < pixels.value.size(); ++i) to[i] = static_cast<float>(pixels.value[i]);
    });
  }

  /// work(part, number of the pixel, its values) for each that counts. skips(pixel): it need not be read.
  template <class Skips, class Work>
  void each(const Skips& skips, const Work& work) const {
    if (!keeps_) {
      for_each_part(cube_, pass_, [&](std::size_t part, const Pixels& pixels) {
        const auto first = static_cast<std::size_t>(pixels.first_line * pixels.samples);
        for (std::size_t p = 0; p < pixels.count(); ++p)
          if (pixels.counts[p] && !skips(first + p)) work(part, first + p, pixels.at(p));
      });
      return;
    }
    const std::vector<PartRange> parts = parts_of(cube_);
    base::for_each_index(parts.size(), pass_.threads, [&](std::size_t part) {
      const std::size_t bands = cube_.bands();
      std::vector<double> value(bands);
      const auto samples = static_cast<std::size_t>(cube_.samples());
      for (auto line = parts[part].first_line; line < parts[part].end_line; ++line) {
        const auto first = static_cast<std::size_t>(line) * samples;
        for (std::size_t p = first; p < first + samples; ++p) {
          if (!counts_[p] || skips(p)) continue;
          const float* const from = kept_.data() + p * bands;
          for (std::size_t b = 0; b < bands; ++b) value[b] = static_cast<double>(from[b]);
          work(part, p, value.data());
        }
      }
    });
  }

 private:
  const Cube& cube_;
  const Pass& pass_;
  bool keeps_ = false;
  std::vector<float> kept_;
  std::vector<std::uint8_t> counts_;
};

/// Sums of the pixels of each class, part by part, in the order of pixels.
struct ClassSums {
  ClassSums(std::size_t classes, std::size_t bands)
      : sum(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(classes), static_cast<Eigen::Index>(bands))),
        count(classes, 0) {}
  void add(std::size_t k, const double* value, double sign) {
    sum.row(static_cast<Eigen::Index>(k)) += sign * Eigen::Map<const Eigen::RowVectorXd>(value, sum.cols());
    count[k] += sign > 0 ? 1 : -1;
  }
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> sum;
  std::vector<std::int64_t> count;
};

using Centers = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Two nearest centres of a pixel: the nearest one's number, both distances.
struct Nearest {
  std::size_t number = 0;
  double near = kInfinite, next = kInfinite;
};
Nearest nearest(const Centers& center, const double* value) {
  Nearest out;
  const auto bands = static_cast<std::size_t>(center.cols());
  for (Eigen::Index k = 0; k < center.rows(); ++k) {
    const double apart = std::sqrt(squared_distance(value, center.row(k).data(), bands));
    if (apart < out.near)
      out.next = out.near, out.near = apart, out.number = static_cast<std::size_t>(k);
    else
      out.next = std::min(out.next, apart);
  }
  return out;
}

/// Centres along the mean.
Centers spread_centers(const Cube& cube, int classes, const Pass& pass) {
  std::vector<std::vector<products::BandStatistics>> part(parts_of(cube).size(),
                                                          std::vector<products::BandStatistics>(cube.bands()));
  for_each_part(cube, pass, [&](std::size_t number, const Pixels& pixels) {
    for (std::size_t p = 0; p < pixels.count(); ++p)
      for (std::size_t b = 0; pixels.counts[p] && b < pixels.bands; ++b) part[number][b].add(pixels.at(p)[b]);
  });
  Centers out(classes, static_cast<Eigen::Index>(cube.bands()));
  for (std::size_t b = 0; b < cube.bands(); ++b) {
    products::BandStatistics all;
    for (const auto& one : part) all.merge(one[b]);
    for (int k = 0; k < classes; ++k)
      out(k, static_cast<Eigen::Index>(b)) =
          all.mean + all.standard_deviation() * (classes > 1 ? 2.0 * k / (classes - 1) - 1 : 0.0);
  }
  return out;
}

/// Pixels by their squared distances: of all, the one whose exponential draw over that weight is least (Efraimidis &
/// Spirakis 2006), so that the order of pixels says nothing.
Centers drawn_centers(const Rounds& rounds, const Cube& cube, const KMeansOptions& options) {
  Centers out(options.classes, static_cast<Eigen::Index>(cube.bands()));
  std::vector<double> weight(cube.pixels(), 1.0);
  const auto never = [](std::size_t) { return false; };
  struct Drawn {
    double key = kInfinite;
    std::vector<double> value;
  };
  for (int k = 0; k < options.classes; ++k) {
    std::vector<Drawn> part(kMostParts);
    rounds.each(never, [&](std::size_t number, std::size_t pixel, const double* value) {
      if (k > 0) {
        const double apart = squared_distance(value, out.row(k - 1).data(), cube.bands());
        weight[pixel] = k == 1 ? apart : std::min(weight[pixel], apart);
      }
      const double u = scene::counter_uniform(options.seed, 0x6b6d65616e73, pixel, static_cast<std::uint64_t>(k));
      const double key = weight[pixel] > 0 ? -std::log1p(-u) / weight[pixel] : kInfinite;
      if (key < part[number].key) part[number] = {key, {value, value + cube.bands()}};
    });
    const auto least = std::min_element(part.begin(), part.end(), [](auto& a, auto& b) { return a.key < b.key; });
    if (least->value.empty())
      throw Error(Fault::input, fmt::format("{}: has only {} different pixels, which cannot be {} classes", cube.path(),
                                            k, options.classes));
    out.row(k) = Eigen::Map<const Eigen::RowVectorXd>(least->value.data(), out.cols());
  }
  return out;
}

/// Lloyd's rounds.
class Lloyd {
 public:
  Lloyd(const Cube& cube, const Rounds& rounds, Centers start)
      : rounds_(rounds),
        center_(std::move(start)),
        bands_(cube.bands()),
        class_(cube.pixels(), kNone),
        near_(cube.pixels(), 0.0),
        next_(cube.pixels(), 0.0),
        part_(kMostParts, ClassSums(static_cast<std::size_t>(center_.rows()), bands_)) {}

  /// One round; pixels that changed.
  std::uint64_t round() {
    half_gap();
    std::vector<std::uint64_t> changed(kMostParts, 0);
    // A pixel's own centre is at most near_ away, all others at least next_, or as far as half their gap tells.
    const auto stays = [&](std::size_t pixel) {
      return class_[pixel] != kNone && near_[pixel] * (1 + kRounding) < std::max(next_[pixel], gap_[class_[pixel]]);
    };
    rounds_.each(stays, [&](std::size_t part, std::size_t pixel, const double* value) {
      const Nearest found = nearest(center_, value);
      near_[pixel] = found.near, next_[pixel] = found.next;
      if (class_[pixel] == found.number) return;
      if (class_[pixel] != kNone) part_[part].add(class_[pixel], value, -1);
      class_[pixel] = static_cast<std::uint16_t>(found.number);
      part_[part].add(found.number, value, 1), ++changed[part];
    });
    move();
    return std::accumulate(changed.begin(), changed.end(), std::uint64_t{0});
  }

  std::uint64_t pixels() const {
    std::uint64_t out = 0;
    for (const std::uint64_t n : count()) out += n;
    return out;
  }
  std::vector<std::uint64_t> count() const {
    std::vector<std::uint64_t> out(static_cast<std::size_t>(center_.rows()), 0);
    for (const ClassSums& one : part_)
      for (std::size_t k = 0; k < out.size(); ++k) out[k] += static_cast<std::uint64_t>(one.count[k]);
    return out;
  }

  /// Means of the classes as they are, summed anew, so that nothing is left of what came and went.
  Centers means(double& squares) {
    for (ClassSums& one : part_) one = ClassSums(static_cast<std::size_t>(center_.rows()), bands_);
    std::vector<double> part(kMostParts, 0.0);
    rounds_.each([](std::size_t) { return false; },
                 [&](std::size_t number, std::size_t pixel, const double* value) {
                   part_[number].add(class_[pixel], value, 1);
                   part[number] += squared_distance(value, center_.row(class_[pixel]).data(), bands_);
                 });
    squares = std::accumulate(part.begin(), part.end(), 0.0);
    move();
    return center_;
  }

 private:
  /// Half the distance from each centre to the nearest other.
  void half_gap() {
    gap_.assign(static_cast<std::size_t>(center_.rows()), kInfinite);
    for (Eigen::Index a = 0; a < center_.rows(); ++a)
      for (Eigen::Index b = 0; b < center_.rows(); ++b)
        if (a != b)
          gap_[static_cast<std::size_t>(a)] =
              std::min(gap_[static_cast<std::size_t>(a)], 0.5 * (center_.row(a) - center_.row(b)).norm());
  }

  /// Centres to the means of their pixels; bounds by how far they went.
  void move() {
    ClassSums all(static_cast<std::size_t>(center_.rows()), bands_);
    for (const ClassSums& one : part_) {
      all.sum += one.sum;
      for (std::size_t k = 0; k < all.count.size(); ++k) all.count[k] += one.count[k];
    }
    std::vector<double> way(all.count.size(), 0.0);
    for (std::size_t k = 0; k < way.size(); ++k) {
      if (all.count[k] == 0) continue;
      const auto row = static_cast<Eigen::Index>(k);
      const Eigen::RowVectorXd mean = all.sum.row(row) / static_cast<double>(all.count[k]);
      way[k] = (mean - center_.row(row)).norm(), center_.row(row) = mean;
    }
    const double most = *std::max_element(way.begin(), way.end());
    for (std::size_t p = 0; p < class_.size(); ++p) {
      if (class_[p] == kNone) continue;
      near_[p] += way[class_[p]], next_[p] -= most;
    }
  }

  const Rounds& rounds_;
  Centers center_;
  std::size_t bands_;
  std::vector<std::uint16_t> class_;
  std::vector<double> near_, next_;  ///< at most so far from its own centre, at least so far from all others
  std::vector<double> gap_;
  std::vector<ClassSums> part_;
};

}  // namespace

KMeans k_means(const Cube& cube, const KMeansOptions& options, const Pass& pass) {
  const Rounds rounds(cube, options.memory_bytes, pass);
  Lloyd lloyd(
      cube, rounds,
      options.start == "plusplus" ? drawn_centers(rounds, cube, options) : spread_centers(cube, options.classes, pass));
  KMeans out;
  while (out.rounds < options.most_rounds) {
    const std::uint64_t changed = lloyd.round();
    ++out.rounds;
    const std::uint64_t pixels = lloyd.pixels();
    if (pixels < static_cast<std::uint64_t>(options.classes))
      throw Error(Fault::input,
                  fmt::format("{}: {} pixels cannot be {} classes", cube.path(), pixels, options.classes));
    out.changed = static_cast<double>(changed) / static_cast<double>(pixels);
    if (out.changed <= options.least_change) break;
  }
  double squares = 0;
  out.center = lloyd.means(squares);
  out.count = lloyd.count();
  out.rms_apart = std::sqrt(squares / static_cast<double>(lloyd.pixels()));
  return out;
}

void nearest_center(const KMeans& classes, const Pixels& pixels, std::vector<double>& out) {
  const Centers center = classes.center;
  out.assign(pixels.count(), 0.0);
  for (std::size_t p = 0; p < pixels.count(); ++p)
    if (pixels.counts[p]) out[p] = static_cast<double>(nearest(center, pixels.at(p)).number + 1);
}

}  // namespace raycube::analysis
