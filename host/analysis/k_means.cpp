#include "host/analysis/k_means.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "host/analysis/dense_sums.h"
#include "host/analysis/eigen_structure.h"
#include "host/analysis/moments.h"
#include "host/base/error.h"
#include "host/base/parallel.h"
#include "scene_compiler/counter_random.h"

namespace raycube::analysis {
namespace {

using base::Error;
using base::Fault;

using Centers = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-10;   ///< of squared distances: bounds are wider by this, so that it decides nothing
constexpr std::size_t kSketched = 8;  ///< directions in which a pixel is known in short
constexpr std::size_t kSomePixels = 20000;
constexpr std::uint16_t kNone = 0xffff;

constexpr std::size_t kBlockBytes = 1 << 18;  ///< of a cube's floats that are looked at together
constexpr std::size_t kGapBytes = 1 << 14;    ///< between pixels that are asked for: shorter ones are read too

/// A cube that is gone through again and again. Where its numbers are used as they lie in the file, only those pixels
/// are read that are asked for, and what lies between them.
class Rounds {
 public:
  Rounds(const Cube& cube, const Pass& pass) : cube_(cube), pass_(pass) {
    counts_.resize(cube.pixels());
    for_each_part(cube, pass, [&](std::size_t, const Pixels& pixels) {
      const auto first = static_cast<std::ptrdiff_t>(pixels.first_line * pixels.samples);
      std::copy(pixels.counts.begin(), pixels.counts.end(), counts_.begin() + first);
    });
  }

  /// work(part, number of the pixel, its values, floats or doubles) for each that counts and is asked for. What a pixel
  /// is asked for by must not hang on the work done for another.
  template <class Asks, class Work>
  void each(const Asks& asks, const Work& work) const {
    if (!cube_.plain_floats()) {
      for_each_part(cube_, pass_, [&](std::size_t part, const Pixels& pixels) {
        const auto first = static_cast<std::size_t>(pixels.first_line * pixels.samples);
        for (std::size_t p = 0; p < pixels.count(); ++p)
          if (pixels.counts[p] && asks(part, first + p)) work(part, first + p, pixels.at(p));
      });
      return;
    }
    const std::vector<PartRange> parts = parts_of(cube_);
    const auto samples = static_cast<std::size_t>(cube_.samples());
    const std::size_t block = std::max<std::size_t>(1, kBlockBytes / (sizeof(float) * cube_.bands()));
    base::for_each_index(parts.size(), pass_.threads, [&](std::size_t part) {
      const std::size_t end = static_cast<std::size_t>(parts[part].end_line) * samples;
      for (std::size_t p = static_cast<std::size_t>(parts[part].first_line) * samples; p < end; p += block) {
        base::throw_if_interrupted();
        each_of_block(part, p, std::min(p + block, end), asks, work);
      }
    });
  }
  template <class Work>
  void each(const Work& work) const {
    each([](std::size_t, std::size_t) { return true; }, work);
  }
  const Cube& cube() const { return cube_; }

 private:
  /// Pixels `first` to `end`, read in runs that no long gap parts.
  template <class Asks, class Work>
  void each_of_block(std::size_t part, std::size_t first, std::size_t end, const Asks& asks, const Work& work) const {
    thread_local std::vector<std::size_t> asked;
    thread_local std::vector<float> value;
    asked.clear();
    for (std::size_t p = first; p < end; ++p)
      if (counts_[p] && asks(part, p)) asked.push_back(p);
    const std::size_t bands = cube_.bands(), gap = 1 + kGapBytes / (sizeof(float) * bands);
    for (std::size_t i = 0, next = 0; i < asked.size(); i = next) {
      for (next = i + 1; next < asked.size() && asked[next] - asked[next - 1] <= gap;) ++next;
      const std::size_t count = asked[next - 1] - asked[i] + 1;
      value.resize(std::max(value.size(), count * bands));
      cube_.read_floats(asked[i], count, value.data());
      for (std::size_t j = i; j < next; ++j) work(part, asked[j], value.data() + (asked[j] - asked[i]) * bands);
    }
  }

  const Cube& cube_;
  const Pass& pass_;
  std::vector<std::uint8_t> counts_;
};

/// Sums of the pixels of each class, part by part, in the order of pixels.
struct ClassSums {
  ClassSums(std::size_t classes, std::size_t bands)
      : sum(Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(classes), static_cast<Eigen::Index>(bands))),
        count(classes, 0) {}
  template <class Number>
  void add(std::size_t k, const Number* value, double sign) {
    add_signed(value, sign, static_cast<std::size_t>(sum.cols()), sum.row(static_cast<Eigen::Index>(k)).data());
    count[k] += sign > 0 ? 1 : -1;
  }
  Centers sum;
  std::vector<std::int64_t> count;
};

/// Number of the nearest centre, the first of those that are as near.
template <class Number>
std::size_t nearest(const Centers& center, const Number* value) {
  std::size_t out = 0;
  double least = kInfinite;
  for (Eigen::Index k = 0; k < center.rows(); ++k) {
    const double apart = squared_distance(value, center.row(k).data(), static_cast<std::size_t>(center.cols()));
    if (apart < least) least = apart, out = static_cast<std::size_t>(k);
  }
  return out;
}

/// Mean and covariance of some pixels, evenly over the image.
Moments some_moments(const Rounds& rounds) {
  const std::size_t step = std::max<std::size_t>(1, rounds.cube().pixels() / kSomePixels);
  std::vector<Moments> part(kMostParts, Moments(rounds.cube().bands()));
  rounds.each([&](std::size_t, std::size_t pixel) { return pixel % step == 0; },
              [&](std::size_t number, std::size_t, const auto* value) {
                const std::vector<double> numbers(value, value + rounds.cube().bands());
                part[number].add(numbers.data(), 1);
              });
  Moments out(rounds.cube().bands());
  for (const Moments& one : part) out.merge(one);
  return out;
}

/// Each pixel in short: its coordinates along the first principal directions of some pixels, and how far it is from
/// the space of these. Any directions would do; these leave little.
class Sketch {
 public:
  explicit Sketch(const Rounds& rounds) {
    const Moments some = some_moments(rounds);
    const std::size_t bands = rounds.cube().bands();
    count_ = std::min(kSketched, bands);
    mean_ = some.mean();
    along_ = eigen_structure(some.covariance()).vectors.leftCols(static_cast<Eigen::Index>(count_));
    pixel_.resize(rounds.cube().pixels() * (count_ + 2));
    rounds.each([&](std::size_t, std::size_t pixel, const auto* value) {
      thread_local Eigen::VectorXd numbers;
      numbers.resize(static_cast<Eigen::Index>(bands));
      for (std::size_t b = 0; b < bands; ++b)
        numbers[static_cast<Eigen::Index>(b)] = static_cast<double>(value[b]) - mean_[static_cast<Eigen::Index>(b)];
      put(numbers, pixel_.data() + pixel * (count_ + 2));
    });
  }

  /// To be asked about these centres.
  void look_at(const Centers& center) {
    center_.resize(static_cast<std::size_t>(center.rows()) * (count_ + 2));
    for (Eigen::Index k = 0; k < center.rows(); ++k)
      put(center.row(k).transpose() - mean_, center_.data() + static_cast<std::size_t>(k) * (count_ + 2));
  }

  /// Number of the nearest centre; kNone: what is known in short does not say.
  std::uint16_t nearest_of(std::size_t pixel) const {
    const std::size_t size = count_ + 2, centers = center_.size() / size;
    const double* const x = pixel_.data() + pixel * size;
    double least_upper = kInfinite, least_lower = kInfinite, next_lower = kInfinite;
    std::size_t upper_of = 0, lower_of = 0;
    for (std::size_t k = 0; k < centers; ++k) {
      const double* const c = center_.data() + k * size;
      double apart = x[count_] * x[count_] + c[count_] * c[count_];
      for (std::size_t j = 0; j < count_; ++j) apart += (x[j] - c[j]) * (x[j] - c[j]);
      // Across the directions |x|^2 + |c|^2 - 2 x c, of which only the sizes are known; and both have roundings.
      const double open = 2 * x[count_] * c[count_] + kRounding * (x[count_ + 1] + c[count_ + 1]);
      if (apart + open < least_upper) least_upper = apart + open, upper_of = k;
      if (apart - open < least_lower)
        next_lower = least_lower, least_lower = apart - open, lower_of = k;
      else
        next_lower = std::min(next_lower, apart - open);
    }
    return upper_of == lower_of && least_upper < next_lower ? static_cast<std::uint16_t>(upper_of) : kNone;
  }

 private:
  void put(const Eigen::VectorXd& from_mean, double* to) const {
    const Eigen::VectorXd along = along_.transpose() * from_mean;
    std::copy(along.data(), along.data() + along.size(), to);
    const double whole = from_mean.squaredNorm();
    to[count_] = std::sqrt(std::max(0.0, whole - along.squaredNorm())), to[count_ + 1] = whole;
  }

  std::size_t count_ = 0;
  Eigen::VectorXd mean_;
  Eigen::MatrixXd along_;
  std::vector<double> pixel_, center_;  ///< coordinates, distance from their space, |x - mean|^2
};

/// Mean and sum of squares about it, band by band.
struct BandSpread {
  explicit BandSpread(std::size_t bands)
      : mean(Eigen::ArrayXd::Zero(static_cast<Eigen::Index>(bands))), squares(mean) {}
  template <class Number>
  void add(const Number* value) {
    const double part = 1 / static_cast<double>(++count);
    for (Eigen::Index b = 0; b < mean.size(); ++b) {
      const double off = static_cast<double>(value[b]) - mean[b];
      mean[b] += part * off, squares[b] += (1 - part) * off * off;
    }
  }
  void merge(const BandSpread& other) {
    if (other.count == 0) return;
    const double here = static_cast<double>(count), there = static_cast<double>(other.count);
    const Eigen::ArrayXd way = other.mean - mean;
    squares += other.squares + here * there / (here + there) * way.square();
    mean += there / (here + there) * way, count += other.count;
  }
  std::uint64_t count = 0;
  Eigen::ArrayXd mean, squares;
};

/// Centres along the mean.
Centers spread_centers(const Rounds& rounds, int classes) {
  std::vector<BandSpread> part(kMostParts, BandSpread(rounds.cube().bands()));
  rounds.each([&](std::size_t number, std::size_t, const auto* value) { part[number].add(value); });
  BandSpread all(rounds.cube().bands());
  for (const BandSpread& one : part) all.merge(one);
  const Eigen::ArrayXd deviation = (all.squares / std::max(1.0, static_cast<double>(all.count) - 1)).sqrt();
  if (classes > 1 && !(deviation.maxCoeff() > 0))
    throw Error(Fault::input, rounds.cube().path() + ": all pixels are alike; they are one class");
  Centers out(classes, all.mean.size());
  for (int k = 0; k < classes; ++k)
    out.row(k) = (all.mean + deviation * (classes > 1 ? 2.0 * k / (classes - 1) - 1 : 0.0)).matrix();
  return out;
}

/// Pixels by their squared distances: of all, the one whose exponential draw over that weight is least (Efraimidis &
/// Spirakis 2006), so that the order of pixels says nothing.
Centers drawn_centers(const Rounds& rounds, const KMeansOptions& options) {
  const Cube& cube = rounds.cube();
  Centers out(options.classes, static_cast<Eigen::Index>(cube.bands()));
  std::vector<double> weight(cube.pixels(), 1.0);
  struct Drawn {
    double key = kInfinite;
    std::vector<double> value;
  };
  for (int k = 0; k < options.classes; ++k) {
    std::vector<Drawn> part(kMostParts);
    rounds.each([&](std::size_t number, std::size_t pixel, const auto* value) {
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
  Lloyd(const Rounds& rounds, Centers start)
      : rounds_(rounds),
        sketch_(rounds),
        center_(std::move(start)),
        bands_(rounds.cube().bands()),
        class_(rounds.cube().pixels(), kNone),
        part_(kMostParts, ClassSums(static_cast<std::size_t>(center_.rows()), bands_)) {}

  /// One round; pixels that changed.
  std::uint64_t round() {
    sketch_.look_at(center_);
    std::vector<std::uint64_t> changed(kMostParts, 0);
    rounds_.each([&](std::size_t, std::size_t pixel) { return told(pixel) == kNone || told(pixel) != class_[pixel]; },
                 [&](std::size_t part, std::size_t pixel, const auto* value) {
                   const std::uint16_t in_short = told(pixel);
                   const std::size_t found = in_short != kNone ? in_short : nearest(center_, value);
                   if (class_[pixel] == found) return;
                   if (class_[pixel] != kNone) part_[part].add(class_[pixel], value, -1);
                   class_[pixel] = static_cast<std::uint16_t>(found);
                   part_[part].add(found, value, 1), ++changed[part];
                 });
    move();
    return std::accumulate(changed.begin(), changed.end(), std::uint64_t{0});
  }

  std::vector<std::uint64_t> count() const {
    std::vector<std::uint64_t> out(static_cast<std::size_t>(center_.rows()), 0);
    for (const ClassSums& one : part_)
      for (std::size_t k = 0; k < out.size(); ++k) out[k] += static_cast<std::uint64_t>(one.count[k]);
    return out;
  }
  std::uint64_t pixels() const {
    const std::vector<std::uint64_t> of = count();
    return std::accumulate(of.begin(), of.end(), std::uint64_t{0});
  }
  const std::vector<std::uint16_t>& classes() const { return class_; }

  /// Means of the classes as they are, summed anew, so that nothing is left of what came and went; and the sum of
  /// squares about them.
  Centers means(double& squares) {
    for (ClassSums& one : part_) one = ClassSums(static_cast<std::size_t>(center_.rows()), bands_);
    std::vector<double> part(kMostParts, 0.0);
    rounds_.each([&](std::size_t number, std::size_t pixel, const auto* value) {
      part_[number].add(class_[pixel], value, 1);
      part[number] += squared_distance(value, center_.row(class_[pixel]).data(), bands_);
    });
    squares = std::accumulate(part.begin(), part.end(), 0.0);
    move();
    return center_;
  }

 private:
  std::uint16_t told(std::size_t pixel) const { return sketch_.nearest_of(pixel); }

  /// Centres to the means of their pixels.
  void move() {
    ClassSums all(static_cast<std::size_t>(center_.rows()), bands_);
    for (const ClassSums& one : part_) {
      all.sum += one.sum;
      for (std::size_t k = 0; k < all.count.size(); ++k) all.count[k] += one.count[k];
    }
    for (Eigen::Index k = 0; k < center_.rows(); ++k)
      if (const std::int64_t n = all.count[static_cast<std::size_t>(k)]; n > 0)
        center_.row(k) = all.sum.row(k) / static_cast<double>(n);
  }

  const Rounds& rounds_;
  Sketch sketch_;
  Centers center_;
  std::size_t bands_;
  std::vector<std::uint16_t> class_;
  std::vector<ClassSums> part_;
};

}  // namespace

KMeans k_means(const Cube& cube, const KMeansOptions& options, const Pass& pass) {
  const Rounds rounds(cube, pass);
  Lloyd lloyd(rounds,
              options.start == "plusplus" ? drawn_centers(rounds, options) : spread_centers(rounds, options.classes));
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
  for (const std::uint16_t k : lloyd.classes())
    out.number.push_back(k == kNone ? 0 : static_cast<std::uint16_t>(k + 1));
  return out;
}

}  // namespace raycube::analysis
