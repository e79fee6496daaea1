#include "host/lidar/gaussian_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

namespace raycube::lidar {

namespace {

/// Bins of which the model expects next to nothing still have a variance of so many counts: one stray photo-electron
/// asks for no echo of its own.
constexpr double kLeastCounts = 0.3;
/// Past so many sigma an echo sends nothing: 1e-19 of it.
constexpr double kReach = 9;

struct Window {
  const std::vector<double>& data;
  std::size_t first, last;
  std::size_t size() const { return last - first; }
};

/// What a unit Gaussian leaves beyond z on z's own side, without cancellation; and its density.
double tail(double z) { return 0.5 * std::erfc(std::abs(z) / std::numbers::sqrt2); }
double density(double z) { return std::exp(-0.5 * z * z) * (0.5 * std::numbers::inv_sqrtpi * std::numbers::sqrt2); }

double share_between(double z0, double tail0, double z1, double tail1) {
  if (z0 > 0) return tail0 - tail1;
  return z1 < 0 ? tail1 - tail0 : 1 - tail0 - tail1;
}

/// Expected counts of a window's bins, and how they change with each echo's three parameters: area, position, log
/// sigma.
class Model {
 public:
  Model(const Window& window, std::size_t echoes)
      : window_(window), expected_(window.size()), slope_(3 * echoes * window.size()), from_(echoes), to_(echoes) {}

  /// Neighbouring bins share an edge, and with it one tail and one density.
  void evaluate(const std::vector<GaussianEcho>& echoes) {
    std::fill(expected_.begin(), expected_.end(), 0.0);
    for (std::size_t k = 0; k < echoes.size(); ++k) {
      const GaussianEcho& e = echoes[k];
      const auto bin_at = [&](double z, double round) {
        return static_cast<std::size_t>(
            std::clamp(std::floor(e.position + z * e.sigma) + round - static_cast<double>(window_.first), 0.0,
                       static_cast<double>(window_.size())));
      };
      from_[k] = bin_at(-kReach, 0), to_[k] = bin_at(kReach, 1);
      double *by_area = slope(k, 0), *by_position = slope(k, 1), *by_width = slope(k, 2);
      double z0 = (static_cast<double>(window_.first + from_[k]) - e.position) / e.sigma, tail0 = tail(z0),
             density0 = density(z0);
      for (std::size_t i = from_[k]; i < to_[k]; ++i) {
        const double z1 = (static_cast<double>(window_.first + i + 1) - e.position) / e.sigma, tail1 = tail(z1),
                     density1 = density(z1);
        by_area[i] = share_between(z0, tail0, z1, tail1);
        by_position[i] = -e.area / e.sigma * (density1 - density0);
        by_width[i] = -e.area * (z1 * density1 - z0 * density0);
        expected_[i] += e.area * by_area[i];
        z0 = z1, tail0 = tail1, density0 = density1;
      }
    }
  }

  double expected(std::size_t i) const { return expected_[i]; }
  void swap(Model& other) {
    expected_.swap(other.expected_), slope_.swap(other.slope_), from_.swap(other.from_), to_.swap(other.to_);
  }

  double chi_squared(const std::vector<double>& weight) const {
    double sum = 0;
    for (std::size_t i = 0; i < expected_.size(); ++i) {
      const double r = window_.data[window_.first + i] - expected_[i];
      sum += weight[i] * r * r;
    }
    return sum;
  }

  void normal_equations(const std::vector<double>& weight, Eigen::MatrixXd& normal, Eigen::VectorXd& gradient) const {
    for (std::size_t k = 0; k < from_.size(); ++k)
      for (int p = 0; p < 3; ++p) {
        const auto row = static_cast<Eigen::Index>(3 * k) + p;
        const double* a = slope(k, p);
        double sum = 0;
        for (std::size_t i = from_[k]; i < to_[k]; ++i)
          sum += weight[i] * (window_.data[window_.first + i] - expected_[i]) * a[i];
        gradient[row] = sum;
        for (std::size_t other = 0; other <= k; ++other)
          for (int q = 0; q < (other < k ? 3 : p + 1); ++q) {
            const double* b = slope(other, q);
            const std::size_t begin = std::max(from_[k], from_[other]), end = std::min(to_[k], to_[other]);
            double product = 0;
            for (std::size_t i = begin; i < end; ++i) product += weight[i] * a[i] * b[i];
            const auto column = static_cast<Eigen::Index>(3 * other) + q;
            normal(row, column) = normal(column, row) = product;
          }
      }
  }

 private:
  double* slope(std::size_t echo, int parameter) {
    return slope_.data() + (3 * echo + static_cast<std::size_t>(parameter)) * window_.size();
  }
  const double* slope(std::size_t echo, int parameter) const {
    return slope_.data() + (3 * echo + static_cast<std::size_t>(parameter)) * window_.size();
  }

  const Window& window_;
  std::vector<double> expected_, slope_;  ///< [bin]; [echo][parameter][bin]
  std::vector<std::size_t> from_, to_;    ///< bins that an echo reaches
};

/// One damped solution for fixed weights, until chi^2 falls by less than `enough` in a step. `model` holds the echoes'
/// values on entry and return.
double descend(const Window& w, const std::vector<double>& weight, double enough, std::vector<GaussianEcho>& echoes,
               Model& model) {
  const auto parameters = static_cast<Eigen::Index>(3 * echoes.size());
  Eigen::MatrixXd normal(parameters, parameters), damped(parameters, parameters);
  Eigen::VectorXd gradient(parameters);
  Model trial_model = model;
  std::vector<GaussianEcho> trial;
  double chi = model.chi_squared(weight), damping = 1e-3;
  for (int step = 0; step < 60; ++step) {
    model.normal_equations(weight, normal, gradient);
    bool better = false;
    for (int attempt = 0; attempt < 12 && !better; ++attempt) {
      damped = normal;
      for (Eigen::Index j = 0; j < parameters; ++j) damped(j, j) += damping * std::max(normal(j, j), 1e-300);
      const Eigen::VectorXd change = damped.ldlt().solve(gradient);
      trial = echoes;
      bool sane = change.allFinite();
      for (std::size_t k = 0; k < trial.size() && sane; ++k) {
        const auto at = static_cast<Eigen::Index>(3 * k);
        trial[k].area += change[at], trial[k].position += change[at + 1],
            trial[k].sigma *= std::exp(std::clamp(change[at + 2], -1.0, 1.0));
        sane = trial[k].area > 0 && trial[k].sigma > 0.02 && trial[k].sigma < static_cast<double>(w.size()) &&
               trial[k].position > static_cast<double>(w.first) && trial[k].position < static_cast<double>(w.last);
      }
      if (sane) trial_model.evaluate(trial);
      const double trial_chi = sane ? trial_model.chi_squared(weight) : chi;
      if (sane && trial_chi <= chi) {
        better = true;
        const bool stands = chi - trial_chi <= enough;
        chi = trial_chi, damping = std::max(damping * 0.1, 1e-12);
        std::swap(echoes, trial), model.swap(trial_model);
        if (stands) return chi;
      } else {
        damping *= 10;
      }
    }
    if (!better) break;
  }
  return chi;
}

}  // namespace

double gaussian_bin(const GaussianEcho& echo, double bin) {
  const double z0 = (bin - echo.position) / echo.sigma, z1 = z0 + 1 / echo.sigma;
  if (z0 > kReach || z1 < -kReach) return 0;
  return echo.area * share_between(z0, tail(z0), z1, tail(z1));
}

double fit_gaussians(const std::vector<double>& data, std::size_t first, std::size_t last, double floor, double slope,
                     std::vector<GaussianEcho>& echoes) {
  const Window w{data, first, last};
  std::vector<double> weight(w.size());
  double enough = 1e-4;  // a hundredth of a standard deviation
  // Without noise every bin counts alike, as if known to 1 % of the highest.
  if (!(floor > 0) && !(slope > 0)) {
    for (std::size_t i = first; i < last; ++i) floor = std::max(floor, 0.01 * std::abs(data[i]));
    floor = std::max(floor, 1e-30), enough = 1e-12;
  }
  Model model(w, echoes.size());
  model.evaluate(echoes);
  double chi = 0;
  for (int pass = 0; pass < 3; ++pass) {
    for (std::size_t i = 0; i < w.size(); ++i)
      weight[i] = 1 / (floor * floor + slope * std::max(0.0, model.expected(i)) + kLeastCounts * slope);
    chi = descend(w, weight, enough, echoes, model);
    if (!(slope > 0)) break;
  }
  return chi;
}

}  // namespace raycube::lidar
