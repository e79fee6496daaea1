// Definition of solve_with_nodes; only the sources that instantiate it include this.
#pragma once

#include <algorithm>
#include <vector>

#include "atmos_tables/solver/layer_solver.h"
#include "atmos_tables/solver/order_solver.h"

namespace raycube::atmos::solver {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Light of both cases at the nodes; one column per case.
template <int N, int C>
using Light = Eigen::Matrix<double, N, C>;

/// What lies below a level: up = reflect down + source; and across the layer under it, to the next level:
/// down = carry^T down' + gain. reflect is symmetric.
template <int N, int C>
struct Below {
  Square<N> reflect, carry;
  Light<N, C> source, gain;
};

OrderSolution empty_solution(const ScaledColumn& column, int order) {
  const auto layers = static_cast<Index>(column.layers.size()), count = static_cast<Index>(column.streams / 2);
  OrderSolution solution;
  solution.order = order;
  solution.cases = order == 0 ? 2 : 1;
  solution.k.resize(count, layers);
  solution.decay.resize(count, layers);
  const Index lit = column.beam_flux > 0 ? layers : 0;
  for (MatrixXd* matrix : {&solution.beam_source, &solution.beam_odd, &solution.beam_pair}) matrix->resize(count, lit);
  solution.row_even.resize(count, count * layers);
  solution.row_odd.resize(count, count * layers);
  solution.scatters.resize(column.layers.size());
  for (int c = 0; c < solution.cases; ++c) {
    solution.even[static_cast<std::size_t>(c)].resize(count, layers);
    solution.odd[static_cast<std::size_t>(c)].resize(count, layers);
  }
  if (order > 0) return solution;
  solution.thermal.resize(count, column.emission.empty() ? 0 : layers);
  solution.x.resize(count, count * layers);
  solution.z.resize(count, count * layers);
  for (std::size_t c = 0; c < 2; ++c) solution.up[c].resize(count, layers + 1), solution.down[c] = solution.up[c];
  return solution;
}

template <int N, int C>
void add_layers(const std::vector<LayerWork<N>>& layers, std::vector<Below<N, C>>& below) {
  const Index count = below.back().reflect.rows();
  constexpr int kRows = N == Eigen::Dynamic ? Eigen::Dynamic : 2 * N + C;
  Eigen::Matrix<double, kRows, N> augmented(2 * count + C, count);
  Square<N> product(count, count), added(count, count);
  Light<N, C> lit(count, C);
  for (std::size_t i = layers.size(); i-- > 0;) {
    const LayerWork<N>& layer = layers[i];
    const Below<N, C>& under = below[i + 1];
    Below<N, C>& here = below[i];
    if (layer.scatters) {
      // Light that bounces between the layer and what lies below: (1 - R R') X = (T, lit).
      multiply<N>(under.reflect, layer.reflect, product);
      augmented.topRows(count) = -product;
      augmented.diagonal().array() += 1;
      lit = layer.reflect.lazyProduct(under.source);
      lit.col(0) += layer.down;
      augmented.middleRows(count, count) = layer.transmit;
      augmented.bottomRows(C) = lit.transpose();
      solve_augmented<N, N + C>(augmented);
      here.carry = augmented.middleRows(count, count);
      here.gain = augmented.bottomRows(C).transpose();
      multiply<N>(under.reflect, layer.transmit, product);
      multiply<N>(here.carry, product, added);
      // Symmetric but for rounding, which must not grow from layer to layer.
      here.reflect = layer.reflect + 0.5 * (added + added.transpose());
    } else {
      here.carry = layer.transmit;
      here.gain.setZero(count, C);
      here.gain.col(0) = layer.down;
      here.reflect = layer.transmit.diagonal().asDiagonal() * under.reflect * layer.transmit.diagonal().asDiagonal();
    }
    lit = under.source;
    lit.noalias() += under.reflect.lazyProduct(here.gain);
    here.source = layer.transmit.lazyProduct(lit);
    here.source.col(0) += layer.up;
  }
}

/// N: nodes, or Eigen::Dynamic. C: cases.
template <int N, int C>
OrderSolution solve_sized(const ScaledColumn& column, int order) {
  OrderSolution solution = empty_solution(column, order);
  const std::size_t layers = column.layers.size();
  const auto count = static_cast<Index>(column.streams / 2);
  const OrderBasis<N> basis(column, order);
  LayerSolver<N> solver(column, basis);
  std::vector<LayerWork<N>> work(layers);
  for (std::size_t i = 0; i < layers; ++i) solver.solve(i, solution, work[i]);

  std::vector<Below<N, C>> below(layers + 1);
  below[layers].reflect.setZero(count, count);
  below[layers].source.setZero(count, C);
  Light<N, C> down(count, C), up(count, C), next(count, C), sum(count, C), difference(count, C);
  down.setZero(), sum.setZero(), difference.setZero();
  if (order == 0) {
    down.col(0) = basis.flux_root * column.top_radiance;
    below[layers].source.col(C - 1) = basis.flux_root;
  }
  add_layers<N, C>(work, below);
  const Nodes<N> inverse_root = basis.flux_root.cwiseInverse();
  for (std::size_t i = 0; i <= layers; ++i) {
    up = below[i].source;
    up.noalias() += below[i].reflect.lazyProduct(down);
    solution.largest_radiance =
        std::max({solution.largest_radiance, inverse_root.cwiseProduct(up.col(0)).cwiseAbs().maxCoeff(),
                  inverse_root.cwiseProduct(down.col(0)).cwiseAbs().maxCoeff()});
    const auto level = static_cast<Index>(i);
    if (order == 0)
      for (Index c = 0; c < C; ++c) {
        solution.up[static_cast<std::size_t>(c)].col(level) = up.col(c);
        solution.down[static_cast<std::size_t>(c)].col(level) = down.col(c);
      }
    // Amplitudes of the layer above this level: half of what comes from its two faces, each.
    if (i > 0) {
      const LayerWork<N>& layer = work[i - 1];
      sum += up + down;
      difference += up - down;
      for (Index c = 0; c < C; ++c) {
        auto even = solution.even[static_cast<std::size_t>(c)].col(level - 1);
        auto odd = solution.odd[static_cast<std::size_t>(c)].col(level - 1);
        even = 0.5 * layer.z.transpose().lazyProduct(sum.col(c));
        odd = 0.5 * layer.x.transpose().lazyProduct(difference.col(c));
        if (c == 0) even -= layer.own_sigma, odd -= layer.own_delta;
      }
    }
    sum = up + down;
    difference = up - down;
    if (i == layers) break;
    next = below[i].gain;
    next.noalias() += below[i].carry.transpose().lazyProduct(down);
    down = next;
  }
  return solution;
}

}  // namespace

/// N: nodes of a hemisphere, or Eigen::Dynamic.
template <int N>
OrderSolution solve_with_nodes(const ScaledColumn& column, int order) {
  return order == 0 ? solve_sized<N, 2>(column, order) : solve_sized<N, 1>(column, order);
}

}  // namespace raycube::atmos::solver
