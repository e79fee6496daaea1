#include "atmos_tables/gas/exponential_sum.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace raycube::atmos {

namespace {

/// min |A x - b| with x >= 0: active sets of Lawson & Hanson on the normal equations, which are small here (at most 30 columns).
Eigen::VectorXd non_negative_least_squares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const Eigen::Index n = a.cols();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<bool> free(static_cast<std::size_t>(n), false);
  const double tolerance = 1e-12 * (a.transpose() * b).cwiseAbs().maxCoeff();
  for (Eigen::Index round = 0; round < 3 * n; ++round) {
    const Eigen::VectorXd gradient = a.transpose() * (b - a * x);
    Eigen::Index enter = -1;
    for (Eigen::Index j = 0; j < n; ++j)
      if (!free[static_cast<std::size_t>(j)] && gradient(j) > tolerance && (enter < 0 || gradient(j) > gradient(enter))) enter = j;
    if (enter < 0) break;
    free[static_cast<std::size_t>(enter)] = true;
    for (;;) {
      std::vector<Eigen::Index> columns;
      for (Eigen::Index j = 0; j < n; ++j)
        if (free[static_cast<std::size_t>(j)]) columns.push_back(j);
      if (columns.empty()) break;
      const Eigen::VectorXd z = a(Eigen::all, columns).householderQr().solve(b);
      if (z.minCoeff() > 0) {
        x.setZero();
        for (std::size_t k = 0; k < columns.size(); ++k) x(columns[k]) = z(static_cast<Eigen::Index>(k));
        break;
      }
      // Back along the way to the first column that would turn negative; that one leaves.
      double step = 1;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        const double target = z(static_cast<Eigen::Index>(k)), now = x(columns[k]);
        if (target <= 0) step = std::min(step, now / (now - target));
      }
      if (!(step >= 0)) step = 0;
      for (std::size_t k = 0; k < columns.size(); ++k) {
        double& now = x(columns[k]);
        now += step * (z(static_cast<Eigen::Index>(k)) - now);
        if (now <= 1e-15) now = 0, free[static_cast<std::size_t>(columns[k])] = false;
      }
    }
  }
  return x;
}

class Fit {
 public:
  Fit(const std::vector<double>& amount, const std::vector<double>& transmittance, const std::vector<double>& importance)
      : amount_(Eigen::Map<const Eigen::ArrayXd>(amount.data(), size(amount))),
        importance_(Eigen::Map<const Eigen::ArrayXd>(importance.data(), size(importance))) {
    target_.resize(size(amount) + 1);
    target_.head(size(amount)) = Eigen::Map<const Eigen::ArrayXd>(transmittance.data(), size(amount)) * importance_;
    target_(size(amount)) = kSumWeight;
  }

  /// Weights for given rates; `residual` of the best fit.
  Eigen::VectorXd weights(const Eigen::VectorXd& log_rate, Eigen::VectorXd* residual = nullptr) const {
    Eigen::MatrixXd a(target_.size(), log_rate.size());
    for (Eigen::Index j = 0; j < log_rate.size(); ++j) {
      a.col(j).head(amount_.size()) = (-std::exp(log_rate(j)) * amount_).exp() * importance_;
      a(amount_.size(), j) = kSumWeight;
    }
    const Eigen::VectorXd x = non_negative_least_squares(a, target_);
    if (residual) *residual = a * x - target_;
    return x;
  }

  double cost(const Eigen::VectorXd& log_rate) const {
    Eigen::VectorXd residual;
    weights(log_rate, &residual);
    return residual.squaredNorm();
  }

  /// Levenberg-Marquardt on the rates, differences for the slopes.
  void polish(Eigen::VectorXd& log_rate) const {
    double damping = 1e-3;
    Eigen::VectorXd residual;
    weights(log_rate, &residual);
    for (int round = 0; round < 25; ++round) {
      Eigen::MatrixXd slope(residual.size(), log_rate.size());
      for (Eigen::Index j = 0; j < log_rate.size(); ++j) {
        constexpr double h = 1e-4;
        Eigen::VectorXd moved = log_rate, there;
        moved(j) += h;
        weights(moved, &there);
        slope.col(j) = (there - residual) / h;
      }
      const Eigen::MatrixXd normal = slope.transpose() * slope;
      bool better = false;
      for (int attempt = 0; attempt < 6 && !better; ++attempt, damping *= 4) {
        Eigen::MatrixXd damped = normal;
        damped.diagonal() += damping * (normal.diagonal().array() + 1e-12).matrix();
        const Eigen::VectorXd step = damped.ldlt().solve(-(slope.transpose() * residual)).cwiseMax(-1.0).cwiseMin(1.0);
        const Eigen::VectorXd trial = log_rate + step;
        Eigen::VectorXd there;
        weights(trial, &there);
        if (!(there.squaredNorm() < residual.squaredNorm())) continue;
        const bool done = there.squaredNorm() > 0.9999 * residual.squaredNorm();
        log_rate = trial, residual = there, better = true, damping *= 0.05;
        if (done) return;
      }
      if (!better) return;
    }
  }

  double longest() const { return amount_.maxCoeff(); }
  double shortest() const { return amount_.minCoeff(); }

 private:
  static constexpr double kSumWeight = 100;  ///< holds the sum of weights at 1; what is left is normalised away
  static Eigen::Index size(const std::vector<double>& values) { return static_cast<Eigen::Index>(values.size()); }
  Eigen::ArrayXd amount_, importance_;
  Eigen::VectorXd target_;
};

struct Term {
  double weight, log_rate;
};

}  // namespace

double ExponentialSum::at(double amount) const {
  double sum = 0;
  for (std::size_t j = 0; j < weight.size(); ++j) sum += weight[j] * std::exp(-rate[j] * amount);
  return sum;
}

ExponentialSum fit_exponential_sum(const std::vector<double>& amount, const std::vector<double>& transmittance,
                                   const std::vector<double>& importance, std::size_t terms) {
  const Fit fit(amount, transmittance, importance);
  constexpr Eigen::Index grid = 28;
  const double low = std::log(1e-4 / fit.longest()), high = std::log(10 / fit.shortest());
  const Eigen::VectorXd rates = Eigen::VectorXd::LinSpaced(grid, low, high);
  const Eigen::VectorXd first = fit.weights(rates);
  std::vector<Term> found;
  for (Eigen::Index j = 0; j < grid; ++j)
    if (first(j) > 0) found.push_back({first(j), rates(j)});
  const auto logs = [](const std::vector<Term>& list) {
    Eigen::VectorXd out(static_cast<Eigen::Index>(list.size()));
    for (std::size_t j = 0; j < list.size(); ++j) out(static_cast<Eigen::Index>(j)) = list[j].log_rate;
    return out;
  };
  while (found.size() > terms) {
    std::vector<Term> best;
    double best_cost = 0;
    for (std::size_t j = 0; j + 1 < found.size(); ++j) {
      std::vector<Term> merged = found;
      const double sum = found[j].weight + found[j + 1].weight;
      merged[j] = {sum, (found[j].weight * found[j].log_rate + found[j + 1].weight * found[j + 1].log_rate) / sum};
      merged.erase(merged.begin() + static_cast<std::ptrdiff_t>(j) + 1);
      const double cost = fit.cost(logs(merged));
      if (best.empty() || cost < best_cost) best = merged, best_cost = cost;
    }
    found = best;
  }
  Eigen::VectorXd log_rate = logs(found);
  fit.polish(log_rate);
  const Eigen::VectorXd weight = fit.weights(log_rate);
  std::vector<Term> out;
  for (Eigen::Index j = 0; j < weight.size(); ++j)
    if (weight(j) > 0) out.push_back({weight(j) / weight.sum(), log_rate(j)});
  std::sort(out.begin(), out.end(), [](const Term& a, const Term& b) { return a.log_rate > b.log_rate; });
  ExponentialSum sum;
  for (const Term& term : out) sum.weight.push_back(term.weight), sum.rate.push_back(std::exp(term.log_rate));
  return sum;
}

}  // namespace raycube::atmos
