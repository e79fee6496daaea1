// Products and factors of the little square matrices of the discrete-ordinate equations. Eigen sends sizes
// from 8 up, and every triangular solve, through its blocked kernels, whose packing costs more than the
// arithmetic here. N: size known when compiled; Eigen::Dynamic falls back on Eigen itself.
#pragma once

#include <Eigen/Dense>
#include <cmath>

namespace raycube::atmos::solver {

template <int N>
using Square = Eigen::Matrix<double, N, N>;
template <int N>
using Nodes = Eigen::Matrix<double, N, 1>;

/// out = a b; out is neither a nor b.
template <int N>
void multiply(const Square<N>& a, const Square<N>& b, Square<N>& out) {
  if constexpr (N == Eigen::Dynamic) {
    out.noalias() = a * b;
  } else {
    for (int j = 0; j < N; ++j) {
      Nodes<N> column = a.col(0) * b(0, j);
      for (int k = 1; k < N; ++k) column += a.col(k) * b(k, j);
      out.col(j) = column;
    }
  }
}

/// Inverse of a symmetric positive definite matrix, in place.
template <int N>
void invert_positive(Square<N>& matrix) {
  if constexpr (N == Eigen::Dynamic) {
    const Eigen::LLT<Square<N>> factor(matrix);
    matrix.setIdentity();
    factor.solveInPlace(matrix);
  } else {
    // Gauss-Jordan; a positive definite matrix needs no pivoting.
    for (int p = 0; p < N; ++p) {
      Nodes<N> pivot = matrix.col(p);
      const double inverse = 1 / pivot(p);
      pivot(p) = 0;
      for (int j = 0; j < N; ++j) {
        const double factor = matrix(p, j) * inverse;
        matrix.col(j) -= pivot * factor;
        matrix(p, j) = factor;
      }
      matrix.col(p) = -pivot * inverse;
      matrix(p, p) = inverse;
    }
  }
}

/// L with L L^T = matrix and its inverse. False: the matrix is not positive definite.
template <int N>
bool triangular_root(const Square<N>& matrix, Square<N>& root, Square<N>& inverse) {
  const auto count = matrix.rows();
  if constexpr (N == Eigen::Dynamic) {
    const Eigen::LLT<Square<N>> factor(matrix);
    if (factor.info() != Eigen::Success) return false;
    root = factor.matrixL();
    inverse.setIdentity(count, count);
    factor.matrixL().solveInPlace(inverse);
  } else {
    Nodes<N> diagonal;
    for (int j = 0; j < N; ++j) {
      Nodes<N> column = matrix.col(j);
      for (int k = 0; k < j; ++k) column -= root.col(k) * root(j, k);
      if (!(column(j) > 0)) return false;
      diagonal(j) = 1 / std::sqrt(column(j));
      root.col(j) = column * diagonal(j);
      for (int i = 0; i < j; ++i) root(i, j) = 0;
    }
    for (int j = 0; j < N; ++j) {
      Nodes<N> column = Nodes<N>::Zero();
      column(j) = 1;
      for (int k = j; k < N; ++k) {
        const double value = column(k) * diagonal(k);
        column -= root.col(k) * value;  // leaves what rounding makes at k: overwritten below
        column(k) = value;
      }
      inverse.col(j) = column;
    }
  }
  return true;
}

/// Solves A X = B. `augmented` holds A^T in its first N rows and B^T in the R rows below, and is spent; the
/// answer X^T comes in those R rows. Partial pivoting.
template <int N, int R>
void solve_augmented(Eigen::Matrix<double, N == Eigen::Dynamic ? Eigen::Dynamic : N + R, N>& augmented) {
  if constexpr (N == Eigen::Dynamic) {
    const auto count = augmented.cols();
    const Eigen::PartialPivLU<Square<N>> factor(augmented.topRows(count).transpose());
    const Square<N> answer = factor.solve(augmented.bottomRows(augmented.rows() - count).transpose());
    augmented.bottomRows(augmented.rows() - count) = answer.transpose();
  } else {
    for (int p = 0; p < N; ++p) {
      int best = p;
      for (int i = p + 1; i < N; ++i)
        if (std::abs(augmented(p, i)) > std::abs(augmented(p, best))) best = i;
      if (best != p) augmented.col(best).swap(augmented.col(p));
      const Eigen::Matrix<double, N + R, 1> pivot = augmented.col(p) * (1 / augmented(p, p));
      for (int i = 0; i < N; ++i)
        if (i != p) augmented.col(i) -= pivot * augmented(p, i);
      augmented.col(p) = pivot;
    }
  }
}

}  // namespace raycube::atmos::solver
