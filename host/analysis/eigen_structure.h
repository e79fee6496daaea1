// Eigenstructure of a cube's covariance, and how two cubes' compare.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace raycube::analysis {

struct EigenStructure {
  Eigen::VectorXd values;   ///< falling; what rounding makes negative is 0
  Eigen::MatrixXd vectors;  ///< columns, of length 1; the entry of largest size is positive
};

/// Of a symmetric matrix.
EigenStructure eigen_structure(const Eigen::MatrixXd& covariance);

/// |v_i . w_i| of the first `count` eigenvectors of two.
std::vector<double> alignments(const EigenStructure& a, const EigenStructure& b, std::size_t count);

/// Principal angles, deg, rising, between the spaces of the first `count` eigenvectors of two: Bjorck & Golub,
/// "Numerical methods for computing angles between linear subspaces", Math. Comp. 27 (1973): from cosines where they
/// are large, from sines where they are small, so that small angles are told to rounding.
std::vector<double> principal_angles_deg(const EigenStructure& a, const EigenStructure& b, std::size_t count);

}  // namespace raycube::analysis
