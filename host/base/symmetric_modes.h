// Eigenvalues and eigenvectors of symmetric matrices.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>

namespace raycube::base {

/// Eigenvalues, rising, and eigenvectors of a symmetric matrix of any size, of which the lower triangle is read. Each
/// type of matrix that Eigen solves takes some six seconds to compile, so they all share this one: of 2, 4 and 8 rows
/// it gives the very bits of types with that many, in 1.0 to 1.5 times their time.
class SymmetricModes {
 public:
  void compute(const Eigen::Ref<const Eigen::MatrixXd>& symmetric);
  const Eigen::MatrixXd& eigenvectors() const { return solver_.eigenvectors(); }
  const Eigen::VectorXd& eigenvalues() const { return solver_.eigenvalues(); }

 private:
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver_;
};

}  // namespace raycube::base
