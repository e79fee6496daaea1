#include "atmos_tables/gas/exponential_sum.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "host/base/error.h"

namespace raycube::atmos {

namespace {

constexpr Eigen::Index kMaxAmounts = 32, kMaxTerms = 20;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxAmounts + 1, 1>;
using Terms = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxTerms, 1>;
using Design = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxAmounts + 1, kMaxTerms>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxTerms, kMaxTerms>;

/// min |A x - b| with x >= 0: active sets of Lawson & Hanson (1974).
Terms non_negative_least_squares(const Design& a, const Rows& b) {
  const Eigen::Index n = a.cols();
  // All columns free first: with the few terms of a polished fit that is the answer.
  Terms x = n <= 5 ? Terms(a.householderQr().solve(b)) : Terms(Terms::Zero(n));
  if (n <= 5 && x.minCoeff() >= 0) return x;
  x = Terms::Zero(n);
  std::array<Eigen::Index, kMaxTerms> free{};
  Eigen::Index count = 0;
  const double tolerance = 1e-12 * (a.transpose() * b).cwiseAbs().maxCoeff();
  for (Eigen::Index round = 0; round < 3 * n; ++round) {
    const Terms gradient = a.transpose() * (b - a * x);
    Eigen::Index enter = -1;
    for (Eigen::Index j = 0; j < n; ++j)
      if (std::find(free.begin(), free.begin() + count, j) == free.begin() + count && gradient(j) > tolerance &&
          (enter < 0 || gradient(j) > gradient(enter)))
        enter = j;
    if (enter < 0) break;
    free[static_cast<std::size_t>(count++)] = enter;
    while (count > 0) {
      Design of_free(a.rows(), count);
      for (Eigen::Index k = 0; k < count; ++k) of_free.col(k) = a.col(free[static_cast<std::size_t>(k)]);
      const Terms z = of_free.householderQr().solve(b);
      // Back along the way to the first column that would turn negative; that one leaves.
      double step = 1;
      for (Eigen::Index k = 0; k < count; ++k) {
        const double now = x(free[static_cast<std::size_t>(k)]);
        if (z(k) <= 0) step = std::min(step, now > 0 ? now / (now - z(k)) : 0.0);
      }
      Eigen::Index kept = 0;
      for (Eigen::Index k = 0; k < count; ++k) {
        const Eigen::Index column = free[static_cast<std::size_t>(k)];
        x(column) += step * (z(k) - x(column));
        if (x(column) > 1e-15)
          free[static_cast<std::size_t>(kept++)] = column;
        else
          x(column) = 0;
      }
      const bool whole_step = kept == count;
      count = kept;
      if (whole_step) break;
    }
  }
  return x;
}

class Fit {
 public:
  Fit(const std::vector<double>& amount, const std::vector<double>& transmittance,
      const std::vector<double>& importance)
      : amount_(Eigen::Map<const Eigen::VectorXd>(amount.data(), size(amount))),
        importance_(Eigen::Map<const Eigen::VectorXd>(importance.data(), size(importance))),
        target_(size(amount) + 1) {
    target_.head(size(amount)) =
        Eigen::Map<const Eigen::VectorXd>(transmittance.data(), size(amount)).cwiseProduct(importance_);
    target_(size(amount)) = kSumWeight;
  }

  /// Weights for given rates, and the residuals they leave.
  Terms weights(const Terms& log_rate, Rows& residual) const {
    Design a(target_.size(), log_rate.size());
    for (Eigen::Index j = 0; j < log_rate.size(); ++j) {
      a.col(j).head(amount_.size()) = (-std::exp(log_rate(j)) * amount_.array()).exp() * importance_.array();
      a(amount_.size(), j) = kSumWeight;
    }
    const Terms x = non_negative_least_squares(a, target_);
    residual = a * x - target_;
    return x;
  }

  double cost(const Terms& log_rate) const {
    Rows residual;
    weights(log_rate, residual);
    return residual.squaredNorm();
  }

  /// Levenberg-Marquardt on the rates, differences for the slopes. Stops where a step gains less than 0.1 % of the
  /// residual.
  void polish(Terms& log_rate) const {
    double damping = 1e-3;
    Rows residual, there;
    weights(log_rate, residual);
    for (int round = 0; round < 15; ++round) {
      Design slope(residual.size(), log_rate.size());
      for (Eigen::Index j = 0; j < log_rate.size(); ++j) {
        constexpr double h = 1e-4;
        Terms moved = log_rate;
        moved(j) += h;
        weights(moved, there);
        slope.col(j) = (there - residual) / h;
      }
      const Square normal = slope.transpose() * slope;
      const Terms downhill = -(slope.transpose() * residual);
      bool better = false;
      for (int attempt = 0; attempt < 4 && !better; ++attempt, damping *= 10) {
        Square damped = normal;
        damped.diagonal() += damping * normal.diagonal() + Terms::Constant(log_rate.size(), 1e-14);
        const Terms trial = log_rate + damped.ldlt().solve(downhill).cwiseMax(-1.0).cwiseMin(1.0);
        weights(trial, there);
        if (!(there.squaredNorm() < residual.squaredNorm())) continue;
        const bool done = there.norm() > 0.999 * residual.norm();
        log_rate = trial, residual = there, better = true, damping *= 1e-2;
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
  Rows amount_, importance_, target_;
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
  if (amount.empty() || amount.size() > kMaxAmounts || transmittance.size() != amount.size() ||
      importance.size() != amount.size() || terms < 1 || terms > kMaxTerms)
    throw base::Error(base::Fault::bug, "exponential sum: " + std::to_string(amount.size()) + " amounts, " +
                                            std::to_string(terms) +
                                            " terms; give 1 to 32 amounts with as many values, and 1 to 20 terms");
  const Fit fit(amount, transmittance, importance);
  constexpr Eigen::Index grid = kMaxTerms;
  const double low = std::log(1e-4 / fit.longest()), high = std::log(10 / fit.shortest());
  const Terms rates = Terms::LinSpaced(grid, low, high);
  Rows residual;
  const Terms first = fit.weights(rates, residual);
  std::vector<Term> found;
  for (Eigen::Index j = 0; j < grid; ++j)
    if (first(j) > 0) found.push_back({first(j), rates(j)});
  const auto logs = [](const std::vector<Term>& list) {
    Terms out(static_cast<Eigen::Index>(list.size()));
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
  Terms log_rate = logs(found);
  fit.polish(log_rate);
  const Terms weight = fit.weights(log_rate, residual);
  std::vector<Term> out;
  for (Eigen::Index j = 0; j < weight.size(); ++j)
    if (weight(j) > 0) out.push_back({weight(j) / weight.sum(), log_rate(j)});
  std::sort(out.begin(), out.end(), [](const Term& a, const Term& b) { return a.log_rate > b.log_rate; });
  ExponentialSum sum;
  for (const Term& term : out) sum.weight.push_back(term.weight), sum.rate.push_back(std::exp(term.log_rate));
  return sum;
}

}  // namespace raycube::atmos
