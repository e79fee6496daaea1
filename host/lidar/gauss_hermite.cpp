#include "host/lidar/gauss_hermite.h"

#include <cmath>
#include <string>

#include <Eigen/Eigenvalues>

#include "host/base/error.h"

namespace raycube::lidar {

HermiteRule gauss_hermite(int n) {
  if (n < 1 || n > 200)
    throw base::Error(base::Fault::input, "a line is averaged over 1 to 200 nodes, not " + std::to_string(n));
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(n), beside(n > 1 ? n - 1 : 0);
  for (int k = 1; k < n; ++k) beside[k - 1] = std::sqrt(static_cast<double>(k));
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
  HermiteRule rule;
  rule.x.assign(static_cast<std::size_t>(n), 0.0);
  rule.w.assign(static_cast<std::size_t>(n), 0.0);
  double total = 0;
  for (int i = 0; i < (n + 1) / 2; ++i) {
    const bool middle = 2 * i + 1 == n;
    double x = middle ? 0 : solver.eigenvalues()[n - 1 - i], weight = 0;
    for (int step = 0; step < 3; ++step) {
      // Orthonormal polynomials h_k: sqrt(k+1) h_{k+1} = x h_k - sqrt(k) h_{k-1}; h_n' = sqrt(n) h_{n-1}; weight = 1 /
      // sum h_k^2.
      double before = 0, here = 1, sum = 0;
      for (int k = 0; k < n; ++k) {
        sum += here * here;
        const double next = (x * here - std::sqrt(static_cast<double>(k)) * before) / std::sqrt(k + 1.0);
        before = here, here = next;
      }
      weight = 1 / sum;
      if (!middle) x -= here / (std::sqrt(static_cast<double>(n)) * before);
    }
    const auto low = static_cast<std::size_t>(i), high = static_cast<std::size_t>(n - 1 - i);
    rule.x[low] = -x, rule.x[high] = x;
    rule.w[low] = rule.w[high] = weight;
    total += middle ? weight : 2 * weight;
  }
  for (double& w : rule.w) w /= total;
  return rule;
}

}  // namespace raycube::lidar
