#include "host/lidar/gaussian_fit.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

namespace raycube::lidar {

namespace {

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }
double normal_pdf(double z) { return std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI); }

/// Bins of which the model expects next to nothing still have a variance of so many counts: one stray photo-electron asks for no echo of its own.
constexpr double kLeastCounts = 0.3;

struct Window {
  const std::vector<double>& data;
  std::size_t first, last;
};

double model_at(const std::vector<GaussianEcho>& echoes, double bin) {
  double sum = 0;
  for (const GaussianEcho& echo : echoes) sum += gaussian_bin(echo, bin);
  return sum;
}

double chi_squared(const Window& w, const Eigen::VectorXd& weight, const std::vector<GaussianEcho>& echoes) {
  double sum = 0;
  for (std::size_t i = w.first; i < w.last; ++i) {
    const double r = w.data[i] - model_at(echoes, static_cast<double>(i));
    sum += weight[static_cast<Eigen::Index>(i - w.first)] * r * r;
  }
  return sum;
}

/// One damped solution for fixed weights, until chi^2 falls by less than `enough` in a step.
double descend(const Window& w, const Eigen::VectorXd& weight, double enough, std::vector<GaussianEcho>& echoes) {
  const auto parameters = static_cast<Eigen::Index>(3 * echoes.size());
  Eigen::MatrixXd normal(parameters, parameters);
  Eigen::VectorXd gradient(parameters), row(parameters);
  double chi = chi_squared(w, weight, echoes), damping = 1e-3;
  for (int step = 0; step < 60; ++step) {
    normal.setZero(), gradient.setZero();
    for (std::size_t i = w.first; i < w.last; ++i) {
      double residual = w.data[i];
      for (std::size_t k = 0; k < echoes.size(); ++k) {
        const GaussianEcho& e = echoes[k];
        const double z0 = (static_cast<double>(i) - e.position) / e.sigma, z1 = z0 + 1 / e.sigma;
        const auto at = static_cast<Eigen::Index>(3 * k);
        if (z0 > 9 || z1 < -9) {
          row[at] = row[at + 1] = row[at + 2] = 0;
          continue;
        }
        const double share = z0 > 0 ? normal_cdf(-z0) - normal_cdf(-z1) : normal_cdf(z1) - normal_cdf(z0);
        const double p0 = normal_pdf(z0), p1 = normal_pdf(z1);
        row[at] = share, row[at + 1] = -e.area / e.sigma * (p1 - p0), row[at + 2] = -e.area * (z1 * p1 - z0 * p0);
        residual -= e.area * share;
      }
      const double v = weight[static_cast<Eigen::Index>(i - w.first)];
      normal.noalias() += v * row * row.transpose();
      gradient.noalias() += v * residual * row;
    }
    bool better = false;
    for (int attempt = 0; attempt < 12 && !better; ++attempt) {
      Eigen::MatrixXd damped = normal;
      for (Eigen::Index j = 0; j < parameters; ++j) damped(j, j) += damping * std::max(normal(j, j), 1e-300);
      const Eigen::VectorXd change = damped.ldlt().solve(gradient);
      std::vector<GaussianEcho> trial = echoes;
      bool sane = change.allFinite();
      for (std::size_t k = 0; k < trial.size() && sane; ++k) {
        const auto at = static_cast<Eigen::Index>(3 * k);
        trial[k].area += change[at], trial[k].position += change[at + 1], trial[k].sigma *= std::exp(std::clamp(change[at + 2], -1.0, 1.0));
        sane = trial[k].area > 0 && trial[k].sigma > 0.02 && trial[k].sigma < static_cast<double>(w.last - w.first) &&
               trial[k].position > static_cast<double>(w.first) && trial[k].position < static_cast<double>(w.last);
      }
      const double trial_chi = sane ? chi_squared(w, weight, trial) : chi;
      if (sane && trial_chi <= chi) {
        better = true;
        const bool stands = chi - trial_chi <= enough;
        chi = trial_chi, echoes = std::move(trial), damping = std::max(damping * 0.1, 1e-12);
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
  if (z0 > 9 || z1 < -9) return 0;
  return echo.area * (z0 > 0 ? normal_cdf(-z0) - normal_cdf(-z1) : normal_cdf(z1) - normal_cdf(z0));
}

double fit_gaussians(const std::vector<double>& data, std::size_t first, std::size_t last, double floor, double slope, std::vector<GaussianEcho>& echoes) {
  const Window w{data, first, last};
  Eigen::VectorXd weight(static_cast<Eigen::Index>(last - first));
  double enough = 1e-4;  // a hundredth of a standard deviation
  // Without noise every bin counts alike, as if known to 1 % of the highest.
  if (!(floor > 0) && !(slope > 0)) {
    for (std::size_t i = first; i < last; ++i) floor = std::max(floor, 0.01 * std::abs(data[i]));
    floor = std::max(floor, 1e-30), enough = 1e-12;
  }
  double chi = 0;
  for (int pass = 0; pass < 3; ++pass) {
    for (std::size_t i = first; i < last; ++i)
      weight[static_cast<Eigen::Index>(i - first)] = 1 / (floor * floor + slope * std::max(0.0, model_at(echoes, static_cast<double>(i))) + kLeastCounts * slope);
    chi = descend(w, weight, enough, echoes);
    if (!(slope > 0)) break;
  }
  return chi;
}

}  // namespace raycube::lidar
