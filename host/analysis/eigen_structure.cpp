#include "host/analysis/eigen_structure.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/symmetric_modes.h"

namespace raycube::analysis {

EigenStructure eigen_structure(const Eigen::MatrixXd& covariance) {
  base::SymmetricModes modes;
  modes.compute(covariance);
  EigenStructure out{modes.eigenvalues().reverse().cwiseMax(0.0), modes.eigenvectors().rowwise().reverse()};
  for (Eigen::Index k = 0; k < out.vectors.cols(); ++k) {
    Eigen::Index largest = 0;
    out.vectors.col(k).cwiseAbs().maxCoeff(&largest);
    if (out.vectors(largest, k) < 0) out.vectors.col(k) *= -1;
  }
  return out;
}

std::vector<double> alignments(const EigenStructure& a, const EigenStructure& b, std::size_t count) {
  std::vector<double> out;
  for (Eigen::Index k = 0; k < static_cast<Eigen::Index>(count); ++k)
    out.push_back(std::abs(a.vectors.col(k).dot(b.vectors.col(k))));
  return out;
}

std::vector<double> principal_angles_deg(const EigenStructure& a, const EigenStructure& b, std::size_t count) {
  const auto n = static_cast<Eigen::Index>(count);
  const Eigen::MatrixXd left = a.vectors.leftCols(n), right = b.vectors.leftCols(n), product = left.transpose() * right,
                        rest = right - left * product;
  // Singular values by the squares' eigenvalues: of the sines too, which are small where the cosines say nothing.
  base::SymmetricModes cosines, sines;
  cosines.compute(product.transpose() * product);
  sines.compute(rest.transpose() * rest);
  std::vector<double> out;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double cosine = std::sqrt(std::clamp(cosines.eigenvalues()[n - 1 - k], 0.0, 1.0)),
                 sine = std::sqrt(std::clamp(sines.eigenvalues()[k], 0.0, 1.0));
    out.push_back((cosine > std::numbers::sqrt2 / 2 ? std::asin(sine) : std::acos(cosine)) * 180 / std::numbers::pi);
  }
  return out;
}

}  // namespace raycube::analysis
