// One layer, one azimuth order: the discrete-ordinate equations (order_solution.h) solved exactly, without a
// growing exponential and without a singular point. N: nodes of a hemisphere, or Eigen::Dynamic; fixed
// numbers keep all matrices off the heap.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/solver/exp_differences.h"
#include "atmos_tables/solver/order_solution.h"
#include "atmos_tables/solver/small_dense.h"
#include "host/base/symmetric_modes.h"

namespace raycube::atmos::solver {

/// What all layers share in one order.
template <int N>
struct OrderBasis {
  int order = 0;
  Square<N> even, odd;  ///< rows: degrees of one parity; columns: nodes; times sqrt(w/mu)
  Square<N> even_transposed, odd_transposed;
  Nodes<N> beam_even, beam_odd;    ///< at the beam's cosine
  Nodes<N> inverse_mu, flux_root;  ///< 1/mu, sqrt(w mu)

  OrderBasis(const ScaledColumn& column, int of_order) : order(of_order) {
    const auto count = static_cast<Eigen::Index>(column.nodes.cosine.size());
    even.resize(count, count), odd.resize(count, count);
    inverse_mu.resize(count), flux_root.resize(count);
    for (Eigen::Index i = 0; i < count; ++i) {
      const double mu = column.nodes.cosine[static_cast<std::size_t>(i)],
                   weight = column.nodes.weight[static_cast<std::size_t>(i)];
      const ParityBasis node = parity_basis(order, column.streams, mu);
      even.col(i) = std::sqrt(weight / mu) * node.even;
      odd.col(i) = std::sqrt(weight / mu) * node.odd;
      inverse_mu(i) = 1 / mu;
      flux_root(i) = std::sqrt(weight * mu);
    }
    const ParityBasis beam = parity_basis(order, column.streams, column.beam_cosine);
    beam_even = beam.even, beam_odd = beam.odd;
    even_transposed = even.transpose(), odd_transposed = odd.transpose();
  }
};

/// A layer while its order is being solved.
template <int N>
struct LayerWork {
  bool scatters = false;
  Square<N> x, z;
  Square<N> reflect, transmit;    ///< of sqrt(w mu) I, same from both sides; reflect is symmetric
  Nodes<N> up, down;              ///< what leaves top and bottom when its own sources alone light it
  Nodes<N> own_sigma, own_delta;  ///< particular solution, mean of top and bottom
};

/// L with E+ = L L^T, and L^-1. Rounding, or moments no positive phase function has, can leave E+ indefinite:
/// then its eigenvalues are floored so that the solution stays finite.
template <int N>
void symmetric_root(const Square<N>& symmetric, Square<N>& root, Square<N>& inverse) {
  if (triangular_root<N>(symmetric, root, inverse)) return;
  base::SymmetricModes modes;
  modes.compute(symmetric);
  const double floor = 1e-12 * modes.eigenvalues().cwiseAbs().maxCoeff();
  const Nodes<N> value = modes.eigenvalues().cwiseMax(floor).cwiseSqrt();
  const Square<N> vectors = modes.eigenvectors();
  root = vectors * value.asDiagonal();
  inverse = value.cwiseInverse().asDiagonal() * vectors.transpose();
}

template <int N>
class LayerSolver {
 public:
  LayerSolver(const ScaledColumn& column, const OrderBasis<N>& basis) : column_(column), basis_(basis) {}

  /// Fills column i of `solution` (all but the amplitudes) and `work`.
  void solve(std::size_t layer, OrderSolution& solution, LayerWork<N>& work) {
    const ScaledLayer& scaled = column_.layers[layer];
    const auto i = static_cast<Eigen::Index>(layer), count = basis_.inverse_mu.size();
    weigh(scaled);
    work.scatters = !weight_even_.isZero(0) || !weight_odd_.isZero(0);
    solution.scatters[layer] = work.scatters ? 1 : 0;
    if (work.scatters)
      find_modes(work, basis_.order == 0 && scaled.albedo >= 1);
    else
      take_bare_modes(work);
    find_operators(work, scaled.depth);
    solution.k.col(i) = k_;
    solution.decay.col(i) = decay_;
    // Half the scattering of the column's sources into any direction, by mode and degree.
    transposed_ = work.x.transpose();
    multiply<N>(transposed_, basis_.even_transposed, row_even_);
    row_even_ *= (0.5 * weight_even_).asDiagonal();
    transposed_ = work.z.transpose();
    multiply<N>(transposed_, basis_.odd_transposed, row_odd_);
    row_odd_ *= (0.5 * weight_odd_).asDiagonal();
    solution.row_even.middleCols(i * count, count) = row_even_;
    solution.row_odd.middleCols(i * count, count) = row_odd_;
    if (basis_.order == 0) {
      solution.x.middleCols(i * count, count) = work.x;
      solution.z.middleCols(i * count, count) = work.z;
    }
    sigma_top_.setZero(count), delta_top_.setZero(count);
    sigma_bottom_.setZero(count), delta_bottom_.setZero(count);
    if (solution.has_beam()) light_by_beam(layer, solution);
    if (solution.emits()) emit(layer, solution, work);
    leave(work);
  }

 private:
  /// omega (2l+1) chi_l, by parity.
  void weigh(const ScaledLayer& scaled) {
    const Eigen::Index count = basis_.inverse_mu.size();
    weight_even_.setZero(count), weight_odd_.setZero(count);
    for (int degree = basis_.order; degree < column_.streams; ++degree) {
      const int at = degree - basis_.order;
      (at % 2 == 0 ? weight_even_ : weight_odd_)(at / 2) =
          scaled.albedo * (2.0 * degree + 1) * scaled.moment[static_cast<std::size_t>(degree)];
    }
  }

  void find_modes(LayerWork<N>& work, bool conservative) {
    scaled_ = basis_.even_transposed * (-weight_even_).asDiagonal();
    multiply<N>(scaled_, basis_.even, even_);
    even_.diagonal() += basis_.inverse_mu;
    scaled_ = basis_.odd_transposed * (-weight_odd_).asDiagonal();
    multiply<N>(scaled_, basis_.odd, odd_);
    odd_.diagonal() += basis_.inverse_mu;
    symmetric_root<N>(odd_, root_, inverse_root_);
    multiply<N>(even_, root_, scaled_);
    transposed_ = root_.transpose();
    multiply<N>(transposed_, scaled_, product_);
    modes_.compute(product_);
    vectors_ = modes_.eigenvectors();
    // Conservative scattering keeps energy: one eigenvalue is 0, and rounding (1e-16 of the largest,
    // 1/mu_1^2) must not say otherwise.
    k_ = modes_.eigenvalues().cwiseMax(0.0).cwiseSqrt();
    if (conservative) k_(0) = 0;
    multiply<N>(root_, vectors_, work.x);
    transposed_ = inverse_root_.transpose();
    multiply<N>(transposed_, vectors_, work.z);  // X^-T = L^-T Y
  }

  /// Without scattering every node is a mode: k = 1/mu.
  void take_bare_modes(LayerWork<N>& work) {
    k_ = basis_.inverse_mu;
    work.x = k_.cwiseSqrt().asDiagonal();
    work.z = k_.cwiseInverse().cwiseSqrt().asDiagonal();
  }

  /// reflect + transmit = (1-G)(1+G)^-1 and reflect - transmit = (H-1)(H+1)^-1, G = Z k tanh(k d/2) Z^T, H =
  /// X tanh(k d/2)/k X^T: the responses to equal and to opposite light on the two faces. Both are
  /// contractions, at every depth.
  void find_operators(LayerWork<N>& work, double depth) {
    const Eigen::Index count = k_.size();
    decay_.resize(count), even_gain_.resize(count), odd_gain_.resize(count);
    for (Eigen::Index j = 0; j < count; ++j) {
      const double fallen = -std::expm1(-k_(j) * depth), tanh_half = fallen / (2 - fallen);
      decay_(j) = std::exp(-k_(j) * depth);
      even_gain_(j) = k_(j) * tanh_half;
      odd_gain_(j) = 0.5 * k_(j) * depth < 1e-8 ? 0.5 * depth : tanh_half / k_(j);
    }
    if (!work.scatters) {
      work.reflect.setZero(count, count);
      work.transmit = decay_.asDiagonal();
      return;
    }
    scaled_ = work.z * even_gain_.asDiagonal();
    transposed_ = work.z.transpose();
    multiply<N>(scaled_, transposed_, even_);
    even_.diagonal().array() += 1;
    scaled_ = work.x * odd_gain_.asDiagonal();
    transposed_ = work.x.transpose();
    multiply<N>(scaled_, transposed_, odd_);
    odd_.diagonal().array() += 1;
    invert_positive<N>(even_);
    invert_positive<N>(odd_);
    work.reflect = even_ - odd_;
    work.transmit = even_ + odd_;
    work.transmit.diagonal().array() -= 1;
  }

  void light_by_beam(std::size_t layer, OrderSolution& solution) {
    const auto i = static_cast<Eigen::Index>(layer);
    const BeamLayer& beam = column_.beam[layer];
    const double depth = column_.layers[layer].depth, azimuth_factor = basis_.order == 0 ? 1 : 2;
    const double strength = column_.beam_flux * azimuth_factor / (4 * std::numbers::pi) * beam.top;
    // The beam travels down: Lambda_l^m(-mu0) = (-1)^(l+m) Lambda_l^m(mu0), so the odd terms change sign.
    even_gain_.noalias() = row_even_.lazyProduct(basis_.beam_even);
    odd_gain_.noalias() = row_odd_.lazyProduct(basis_.beam_odd);
    const double fade = std::exp(-beam.slope * depth);
    for (Eigen::Index j = 0; j < k_.size(); ++j) {
      const double pair = exp_difference(k_(j) * depth, beam.slope * depth);
      const double odd = -4 * strength * odd_gain_(j);
      const double source = (beam.slope * odd - 4 * strength * even_gain_(j)) / (k_(j) + beam.slope);
      solution.beam_odd(j, i) = odd;
      solution.beam_source(j, i) = source;
      solution.beam_pair(j, i) = pair;
      delta_top_(j) += odd - source;
      sigma_bottom_(j) -= source * depth * pair;
      delta_bottom_(j) += source * (k_(j) * depth * pair - fade) + odd * fade;
    }
  }

  /// Radiance equal to B in every direction solves the equations for any albedo; a slope adds d = 2 B' E+^-1
  /// sqrt(w mu).
  void emit(std::size_t layer, OrderSolution& solution, const LayerWork<N>& work) {
    const LinearPlanck& planck = column_.emission[layer];
    even_gain_.noalias() = work.z.transpose().lazyProduct(basis_.flux_root);
    even_gain_ *= 2;
    solution.thermal.col(static_cast<Eigen::Index>(layer)) = even_gain_;
    sigma_top_ += even_gain_ * planck.top;
    sigma_bottom_ += even_gain_ * (planck.top + planck.slope * column_.layers[layer].depth);
    delta_top_ += even_gain_ * planck.slope;
    delta_bottom_ += even_gain_ * planck.slope;
  }

  /// What leaves the layer: the homogeneous solution takes away the light that the particular one lets in.
  void leave(LayerWork<N>& work) {
    work.own_sigma = 0.5 * (sigma_top_ + sigma_bottom_);
    work.own_delta = 0.5 * (delta_top_ + delta_bottom_);
    sum_.noalias() = work.x.lazyProduct(sigma_top_);
    difference_.noalias() = work.z.lazyProduct(delta_top_);
    work.up = 0.5 * (sum_ + difference_);
    in_top_ = 0.5 * (sum_ - difference_);
    sum_.noalias() = work.x.lazyProduct(sigma_bottom_);
    difference_.noalias() = work.z.lazyProduct(delta_bottom_);
    work.down = 0.5 * (sum_ - difference_);
    in_bottom_ = 0.5 * (sum_ + difference_);
    work.up.noalias() -= work.reflect.lazyProduct(in_top_);
    work.up.noalias() -= work.transmit.lazyProduct(in_bottom_);
    work.down.noalias() -= work.transmit.lazyProduct(in_top_);
    work.down.noalias() -= work.reflect.lazyProduct(in_bottom_);
  }

  const ScaledColumn& column_;
  const OrderBasis<N>& basis_;
  Nodes<N> weight_even_, weight_odd_, k_, decay_, even_gain_, odd_gain_;
  Nodes<N> sigma_top_, sigma_bottom_, delta_top_, delta_bottom_, sum_, difference_, in_top_, in_bottom_;
  Square<N> scaled_, transposed_, even_, odd_, root_, inverse_root_, product_, vectors_, row_even_, row_odd_;
  base::SymmetricModes modes_;
};

}  // namespace raycube::atmos::solver
