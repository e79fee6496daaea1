#include "host/analysis/moments.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "host/analysis/dense_sums.h"
#include "host/base/error.h"
#include "host/base/symmetric_modes.h"

namespace raycube::analysis {
namespace {

constexpr double kWorstCondition = 1e12;  ///< of bands with variance 1: an inverse then has four digits

}  // namespace

Moments::Moments(std::size_t bands)
    : mean_(Eigen::VectorXd::Zero(static_cast<Eigen::Index>(bands))), square_(padded(bands) * padded(bands), 0.0) {}

void Moments::add(const double* pixels, std::size_t count) {
  const std::size_t n = bands(), stride = padded(n);
  block_.assign(kPixelsAtOnce * stride, 0.0);
  for (std::size_t first = 0; first < count; first += kPixelsAtOnce) {
    const std::size_t many = std::min(kPixelsAtOnce, count - first);
    Eigen::VectorXd mean = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(n));
    for (std::size_t p = 0; p < many; ++p)
      mean += Eigen::Map<const Eigen::VectorXd>(pixels + (first + p) * n, mean.size());
    mean /= static_cast<double>(many);
    for (std::size_t p = 0; p < many; ++p)
      for (std::size_t b = 0; b < n; ++b)
        block_[p * stride + b] = pixels[(first + p) * n + b] - mean[static_cast<Eigen::Index>(b)];
    if (count_ > 0) {  // as one more row: the way between the two means, by how many there are on each side
      const double before = static_cast<double>(count_), here = static_cast<double>(many);
      const Eigen::VectorXd row = std::sqrt(before * here / (before + here)) * (mean - mean_);
      std::vector<double> last(stride, 0.0);
      std::copy(row.data(), row.data() + row.size(), last.begin());
      add_squares(last.data(), 1, stride, square_.data());
    }
    add_squares(block_.data(), many, stride, square_.data());
    count_ += many;
    mean_ += (static_cast<double>(many) / static_cast<double>(count_)) * (mean - mean_);
  }
}

void Moments::merge(const Moments& other) {
  if (other.count_ == 0) return;
  const double here = static_cast<double>(count_), there = static_cast<double>(other.count_);
  const std::size_t stride = padded(bands());
  const Eigen::VectorXd way = other.mean_ - mean_;
  std::vector<double> row(stride, 0.0);
  for (std::size_t b = 0; b < bands(); ++b)
    row[b] = std::sqrt(here * there / (here + there)) * way[static_cast<Eigen::Index>(b)];
  for (std::size_t i = 0; i < square_.size(); ++i) square_[i] += other.square_[i];
  if (count_ > 0) add_squares(row.data(), 1, stride, square_.data());
  mean_ += there / (here + there) * way;
  count_ += other.count_;
}

Eigen::MatrixXd Moments::covariance() const {
  const auto n = static_cast<Eigen::Index>(bands());
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(n, n);
  if (count_ < 2) return out;
  const std::size_t stride = padded(bands());
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = i; j < n; ++j)
      out(i, j) = out(j, i) =
          square_[static_cast<std::size_t>(i) * stride + static_cast<std::size_t>(j)] / static_cast<double>(count_ - 1);
  return out;
}

Eigen::MatrixXd Moments::correlation() const {
  const double n = static_cast<double>(count_);
  return (n - 1) / n * covariance() + mean_ * mean_.transpose();
}

Moments moments_of(const Cube& cube, const Pass& pass, const Chooses& chooses) {
  std::vector<Moments> part(parts_of(cube).size(), Moments(cube.bands()));
  for_each_part(cube, pass, [&](std::size_t number, const Pixels& pixels) {
    const bool all = !chooses && std::all_of(pixels.counts.begin(), pixels.counts.end(), [](auto c) { return c; });
    if (all) return part[number].add(pixels.value.data(), pixels.count());
    std::vector<double> taken;
    for (std::size_t p = 0; p < pixels.count(); ++p) {
      const std::int64_t line = pixels.first_line + static_cast<std::int64_t>(p) / pixels.samples,
                         sample = static_cast<std::int64_t>(p) % pixels.samples;
      if (!pixels.counts[p] || (chooses && !chooses(line, sample))) continue;
      taken.insert(taken.end(), pixels.at(p), pixels.at(p) + pixels.bands);
    }
    part[number].add(taken.data(), taken.size() / std::max<std::size_t>(pixels.bands, 1));
  });
  Moments out(cube.bands());
  for (const Moments& one : part) out.merge(one);
  return out;
}

Inverse invert(const Eigen::MatrixXd& symmetric, const std::string& what) {
  const Eigen::Index n = symmetric.rows();
  const auto refuse = [&](const std::string& why) {
    throw base::Error(
        base::Fault::input,
        fmt::format(
            "{}: its {} x {} matrix cannot be inverted ({}): fewer pixels than bands, or bands that are constant "
            "or repeat each other; choose fewer bands (--bands, --wavelengths), or --shrink",
            what, n, n, why));
  };
  if (!(symmetric.diagonal().minCoeff() > 0)) refuse("a band's variance is 0");
  // Of bands of variance 1, so that units say nothing.
  const Eigen::VectorXd scale = symmetric.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd even = scale.asDiagonal() * symmetric * scale.asDiagonal();
  base::SymmetricModes modes;
  modes.compute(even);
  const double least = modes.eigenvalues()[0], most = modes.eigenvalues()[n - 1];
  const Eigen::LLT<Eigen::MatrixXd> cholesky(even);
  if (!(least > 0) || most > kWorstCondition * least || cholesky.info() != Eigen::Success)
    refuse(fmt::format("eigenvalues from {:.3g} to {:.3g} of bands with variance 1", least, most));
  const Eigen::MatrixXd lower =
      Eigen::MatrixXd(cholesky.matrixL().solve(Eigen::MatrixXd::Identity(n, n))) * scale.asDiagonal();
  Inverse out;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) out.lower.push_back(j <= i ? lower(i, j) : 0.0);
  out.whole = lower.transpose() * lower;
  const Eigen::MatrixXd factor = cholesky.matrixL();
  for (Eigen::Index i = 0; i < n; ++i) out.log_determinant += 2 * std::log(factor(i, i) / scale[i]);
  return out;
}

}  // namespace raycube::analysis
