#include "host/lidar/gaussian_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <string>

#include "host/base/error.h"
#include "host/base/wide.h"
#include "host/lidar/normal_edges.h"

namespace raycube::lidar {

namespace {

/// Bins of which the model expects next to nothing still have a variance of so many counts: one stray photo-electron
/// asks for no echo of its own.
constexpr double kLeastCounts = 0.3;
/// Past so many sigma an echo sends nothing: 4e-11 of it.
constexpr double kReach = 6.5;
constexpr double kNoiseless = 1e-12;  ///< fall of chi^2 that ends a fit of data without noise
constexpr std::size_t kLanes = 4;     ///< bins that are summed side by side

typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double)), aligned(8), may_alias));

inline __attribute__((always_inline)) double sum_of(const Lanes& lanes) {
  return (lanes[0] + lanes[1]) + (lanes[2] + lanes[3]);
}

inline __attribute__((always_inline)) double share_between(double z0, double tail0, double z1, double tail1) {
  return z0 > 0 ? tail0 - tail1 : z1 < 0 ? tail1 - tail0 : 1 - tail0 - tail1;
}

/// Adds an echo to the bins' expected values and writes its three slopes. Neighbouring bins share an edge, and with it
/// one tail and one density; z: of the first bin's left edge.
RAYCUBE_WIDE void add_echo(const GaussianEcho& e, double z, std::size_t bins, const double* tail, const double* density,
                           double* expected, double* by_area, double* by_position, double* by_width) {
  const double step = 1 / e.sigma, area = e.area, height = e.area / e.sigma;
  for (std::size_t i = 0; i < bins; ++i) {
    const double at = static_cast<double>(static_cast<std::int32_t>(i));
    const double z0 = z + at * step, z1 = z + (at + 1) * step;
    const double share = share_between(z0, tail[i], z1, tail[i + 1]);
    by_area[i] = share;
    by_position[i] = height * (density[i] - density[i + 1]);
    by_width[i] = area * (z0 * density[i] - z1 * density[i + 1]);
    expected[i] += area * share;
  }
}

/// Sums over bins of weight times each of three rows times each of three others. Rows are `stride` apart.
RAYCUBE_WIDE void products(const double* a, const double* b, const double* weight, std::size_t stride,
                           std::size_t begin, std::size_t end, double* out) {
  Lanes sum[9] = {};
  for (std::size_t i = begin; i < end; i += kLanes) {
    const Lanes w = *reinterpret_cast<const Lanes*>(weight + i);
    for (std::size_t p = 0; p < 3; ++p) {
      const Lanes weighted = w * *reinterpret_cast<const Lanes*>(a + p * stride + i);
      for (std::size_t q = 0; q < 3; ++q)
        sum[3 * p + q] += weighted * *reinterpret_cast<const Lanes*>(b + q * stride + i);
    }
  }
  for (std::size_t k = 0; k < 9; ++k) out[k] = sum_of(sum[k]);
}

/// Sums over bins of each of three rows times one.
RAYCUBE_WIDE void moments(const double* rows, const double* one, std::size_t stride, std::size_t begin, std::size_t end,
                          double* out) {
  Lanes sum[3] = {};
  for (std::size_t i = begin; i < end; i += kLanes)
    for (std::size_t p = 0; p < 3; ++p)
      sum[p] += *reinterpret_cast<const Lanes*>(rows + p * stride + i) * *reinterpret_cast<const Lanes*>(one + i);
  for (std::size_t k = 0; k < 3; ++k) out[k] = sum_of(sum[k]);
}

RAYCUBE_WIDE double weighted_squares(const double* data, const double* expected, const double* weight,
                                     std::size_t padded) {
  Lanes sum = {};
  for (std::size_t i = 0; i < padded; i += kLanes) {
    const Lanes left = *reinterpret_cast<const Lanes*>(data + i) - *reinterpret_cast<const Lanes*>(expected + i);
    sum += *reinterpret_cast<const Lanes*>(weight + i) * left * left;
  }
  return sum_of(sum);
}

/// Numbers in a row of so many, whole lanes.
constexpr std::size_t row_of(std::size_t parameters) { return (parameters + kLanes - 1) / kLanes * kLanes; }

/// x of A x = b for a symmetric A of n rows, `stride` apart, of which the upper half is read, by Cholesky's factors;
/// false: A is not positive. Rows are whole lanes; what stands left of the diagonal and right of column n is not read,
/// but is written. Eigen's of sizes that are known only now take three times as long (bench/RESULTS.md).
RAYCUBE_WIDE bool solve(double* a, double* x, std::size_t n, std::size_t stride) {
  for (std::size_t j = 0; j < n; ++j) {
    double* const row = a + j * stride;
    if (!(row[j] > 0)) return false;
    const double over = 1 / row[j];
    for (std::size_t i = j + 1; i < n; ++i) {
      const double factor = row[i] * over;
      double* const lower = a + i * stride;
      for (std::size_t k = i / kLanes * kLanes; k < stride; k += kLanes)
        *reinterpret_cast<Lanes*>(lower + k) -= factor * *reinterpret_cast<const Lanes*>(row + k);
      x[i] -= factor * x[j];
    }
  }
  for (std::size_t j = n; j-- > 0;) {
    double sum = x[j];
    for (std::size_t i = j + 1; i < n; ++i) sum -= a[j * stride + i] * x[i];
    x[j] = sum / a[j * stride + j];
  }
  return true;
}

/// The same for three rows.
bool solve_three(const double* a, std::size_t stride, double* x) {
  const double p = a[0], q = a[1], r = a[2], s = a[stride + 1], t = a[stride + 2], u = a[2 * stride + 2];
  const double first = s * u - t * t, second = r * t - q * u, third = q * t - r * s;
  const double determinant = p * first + q * second + r * third, minor = p * s - q * q;
  if (!(p > 0) || !(minor > 0) || !(determinant > 0)) return false;
  const double over = 1 / determinant, x0 = x[0], x1 = x[1], x2 = x[2];
  x[0] = over * (first * x0 + second * x1 + third * x2);
  x[1] = over * (second * x0 + (p * u - r * r) * x1 + (q * r - p * t) * x2);
  x[2] = over * (third * x0 + (q * r - p * t) * x1 + minor * x2);
  return true;
}

}  // namespace

void EchoModel::prepare(std::size_t first, std::size_t bins, std::size_t echoes) {
  first_ = first, bins_ = bins, padded_ = (bins + kLanes - 1) / kLanes * kLanes;
  expected_.assign(padded_, 0.0);
  slope_.assign(3 * echoes * padded_, 0.0);
  reach_.assign(echoes, {0, 0});
  tail_.resize(bins + 1), density_.resize(bins + 1);
}

void EchoModel::evaluate(std::span<const GaussianEcho> echoes) {
  std::fill(expected_.begin(), expected_.end(), 0.0);
  for (std::size_t k = 0; k < echoes.size(); ++k) {
    const GaussianEcho& e = echoes[k];
    const auto bin_at = [&](double z, double round) {
      return static_cast<std::size_t>(std::clamp(
          std::floor(e.position + z * e.sigma) + round - static_cast<double>(first_), 0.0, static_cast<double>(bins_)));
    };
    const std::size_t from = bin_at(-kReach, 0), to = bin_at(kReach, 1);
    double* const rows = slope_.data() + 3 * k * padded_;
    for (std::size_t p = 0; p < 3; ++p)
      std::fill(rows + p * padded_ + reach_[k][0], rows + p * padded_ + reach_[k][1], 0.0);
    reach_[k] = {from, to};
    const double z = (static_cast<double>(first_ + from) - e.position) / e.sigma;
    normal_edges(z, 1 / e.sigma, to - from + 1, tail_.data(), density_.data());
    add_echo(e, z, to - from, tail_.data(), density_.data(), expected_.data() + from, rows + from,
             rows + padded_ + from, rows + 2 * padded_ + from);
  }
}

double gaussian_bin(const GaussianEcho& echo, double bin) {
  const double z0 = (bin - echo.position) / echo.sigma, z1 = z0 + 1 / echo.sigma;
  if (z0 > kReach || z1 < -kReach) return 0;
  const auto tail = [](double z) { return 0.5 * std::erfc(std::abs(z) / std::numbers::sqrt2); };
  return echo.area * share_between(z0, tail(z0), z1, tail(z1));
}

double GaussianFit::chi_squared(const EchoModel& model) const {
  return weighted_squares(data_.data(), model.expected(), weight_.data(), model.padded());
}

void GaussianFit::normal_equations(std::size_t echoes) {
  for (std::size_t i = 0; i < weight_.size(); ++i) weighted_[i] = weight_[i] * (data_[i] - model_.expected()[i]);
  const std::size_t row = row_of(3 * echoes), stride = model_.padded();
  const auto whole = [&](std::size_t bin) { return (bin + kLanes - 1) / kLanes * kLanes; };
  for (std::size_t k = 0; k < echoes; ++k) {
    const auto [from, to] = model_.reach(k);
    moments(model_.slopes(k), weighted_.data(), stride, from / kLanes * kLanes, whole(to), gradient_.data() + 3 * k);
    for (std::size_t other = 0; other <= k; ++other) {
      const std::size_t begin = std::max(from, model_.reach(other)[0]) / kLanes * kLanes,
                        end = whole(std::min(to, model_.reach(other)[1]));
      double product[9];
      products(model_.slopes(k), model_.slopes(other), weight_.data(), stride, begin, std::max(begin, end), product);
      for (std::size_t p = 0; p < 3; ++p)
        for (std::size_t q = 0; q < 3; ++q) normal_[(3 * other + q) * row + 3 * k + p] = product[3 * p + q];
    }
  }
}

/// Where a damped step leads: trial_; whether that is within bounds.
bool GaussianFit::step(double damping, const std::vector<GaussianEcho>& from) {
  const std::size_t parameters = 3 * from.size(), stride = row_of(parameters);
  std::copy_n(normal_.begin(), parameters * stride, damped_.begin());
  std::copy_n(gradient_.begin(), parameters, change_.begin());
  for (std::size_t j = 0; j < parameters; ++j)
    damped_[j * stride + j] += damping * std::max(damped_[j * stride + j], 1e-300);
  if (!(from.size() == 1 ? solve_three(damped_.data(), stride, change_.data())
                         : solve(damped_.data(), change_.data(), parameters, stride)))
    return false;
  trial_ = from;
  for (std::size_t k = 0; k < trial_.size(); ++k) {
    const double* const change = change_.data() + 3 * k;
    GaussianEcho& e = trial_[k];
    e.area += change[0], e.position += change[1], e.sigma *= std::exp(std::clamp(change[2], -1.0, 1.0));
    if (!(e.area > 0 && e.sigma > 0.02 && e.sigma < static_cast<double>(last_ - first_) &&
          e.position > static_cast<double>(first_) && e.position < static_cast<double>(last_)))
      return false;
  }
  return true;
}

/// By how much chi^2 falls on the step, were the model straight.
double GaussianFit::promised(std::size_t echoes) const {
  return std::inner_product(change_.begin(), change_.begin() + static_cast<std::ptrdiff_t>(3 * echoes),
                            gradient_.begin(), 0.0);
}

/// One damped solution for fixed weights, until chi^2 falls by less than `enough` in a step, or would. model_ holds the
/// echoes' values on entry and return.
double GaussianFit::descend(double enough, std::vector<GaussianEcho>& echoes) {
  double chi = chi_squared(model_);
  for (int round = 0; round < 60; ++round) {
    normal_equations(echoes.size());
    bool better = false;
    for (int attempt = 0; attempt < 12 && !better; ++attempt) {
      const bool sane = step(damping_, echoes);
      if (sane && promised(echoes.size()) <= enough) return chi;
      if (sane) trial_model_.evaluate(trial_);
      const double trial_chi = sane ? chi_squared(trial_model_) : chi;
      if (sane && trial_chi <= chi) {
        better = true;
        const bool stands = chi - trial_chi <= enough;
        chi = trial_chi, damping_ = std::max(damping_ * 0.1, 1e-12);
        std::swap(echoes, trial_), std::swap(model_, trial_model_);
        if (stands) return chi;
      } else {
        damping_ *= 10;
      }
    }
    if (!better) break;
  }
  return chi;
}

void GaussianFit::begin(std::span<const double> data, std::size_t first, std::size_t last) {
  first_ = first, last_ = last;
  const std::size_t bins = last - first, padded = (bins + kLanes - 1) / kLanes * kLanes;
  data_.assign(padded, 0.0), weight_.assign(padded, 0.0), weighted_.assign(padded, 0.0);
  std::copy_n(data.begin() + static_cast<std::ptrdiff_t>(first), bins, data_.begin());
}

void GaussianFit::model(const std::vector<GaussianEcho>& echoes) {
  if (echoes.empty() || echoes.size() > kMostEchoes)
    throw base::Error(base::Fault::bug, "a fit of " + std::to_string(echoes.size()) + " echoes");
  model_.prepare(first_, last_ - first_, echoes.size()), trial_model_.prepare(first_, last_ - first_, echoes.size());
  model_.evaluate(echoes);
  damping_ = 1e-3;
}

/// By the model as it is. Without noise every bin counts alike, as if known to 1 % of the highest.
void GaussianFit::weigh(double floor, double slope) {
  const std::size_t bins = last_ - first_;
  if (!(floor > 0) && !(slope > 0)) {
    for (std::size_t i = 0; i < bins; ++i) floor = std::max(floor, 0.01 * std::abs(data_[i]));
    floor = std::max(floor, 1e-30);
  }
  for (std::size_t i = 0; i < bins; ++i)
    weight_[i] = 1 / (floor * floor + slope * std::max(0.0, model_.expected()[i]) + kLeastCounts * slope);
}

double GaussianFit::roughly(std::span<const double> data, std::size_t first, std::size_t last, double floor,
                            double slope, std::vector<GaussianEcho>& echoes) {
  begin(data, first, last);
  model(echoes);
  weigh(floor, slope);
  double chi = descend(slope > 0 ? 3 : floor > 0 ? 0.5 : kNoiseless, echoes);
  if (slope > 0) {
    weigh(floor, slope);
    chi = descend(0.5, echoes);
  }
  solved_ = echoes;
  return chi;
}

double GaussianFit::again(std::vector<GaussianEcho>& echoes) {
  model(echoes);
  const double chi = descend(3, echoes);
  solved_ = echoes;
  return chi;
}

double GaussianFit::weigh_anew(double floor, double slope) {
  weigh(floor, slope);
  return chi_squared(model_);
}

double GaussianFit::finish(double floor, double slope, std::vector<GaussianEcho>& echoes) {
  if (echoes != solved_) model(echoes);
  weigh(floor, slope);
  return descend(floor > 0 || slope > 0 ? 1e-3 : kNoiseless, echoes);
}

}  // namespace raycube::lidar
