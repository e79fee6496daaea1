#include "atmos_tables/solver/user_radiance.h"

#include <algorithm>
#include <cmath>

#include "atmos_tables/solver/exp_differences.h"
#include "atmos_tables/solver/path_integrals.h"

namespace raycube::atmos::solver {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;

/// Legendre functions of all rays; rows: rays, columns: degrees of one parity. Odd ones carry the sign of the
/// light's travel.
struct RayBasis {
  MatrixXd even, odd;
};

RayBasis ray_basis(const Rays& rays, int order, int streams) {
  const auto count = static_cast<Index>(rays.cosine.size());
  RayBasis basis{MatrixXd(count, streams / 2), MatrixXd(count, streams / 2)};
  for (Index r = 0; r < count; ++r) {
    const ParityBasis one = parity_basis(order, streams, rays.cosine[static_cast<std::size_t>(r)]);
    basis.even.row(r) = one.even.transpose();
    basis.odd.row(r) = (rays.up ? 1.0 : -1.0) * one.odd.transpose();
  }
  return basis;
}

/// A homogeneous mode that is not linear, as light that falls off from the layer's top and from its bottom.
struct ModePair {
  double falling = 0, rising = 0;
};
ModePair mode_pair(const OrderSolution& solution, std::size_t c, Index layer, Index j) {
  const double even = solution.even[c](j, layer), odd = solution.odd[c](j, layer) / solution.k(j, layer);
  const double norm = 1 + solution.decay(j, layer);
  return {(even - odd) / norm, (even + odd) / norm};
}

class LayerLight {
 public:
  LayerLight(const ScaledColumn& column, const OrderSolution& solution, const Rays& rays)
      : column_(column), solution_(solution), rays_(rays), basis_(ray_basis(rays, solution.order, column.streams)) {
    const auto count = static_cast<Index>(rays.cosine.size()), nodes = solution.k.rows();
    even_.resize(count, nodes);
    odd_.resize(count, nodes);
    own_.resize(count);
    from_ground_.resize(count);
    towards_.resize(count);
    along_.resize(count);
  }

  const ArrayXd& own() const { return own_; }
  const ArrayXd& from_ground() const { return from_ground_; }

  /// Weights of the modes in a layer, for all rays: rows of the source function.
  void enter(std::size_t layer) {
    const Index nodes = solution_.k.rows(), i = static_cast<Index>(layer);
    entered_ = solution_.scatters[layer] != 0;
    if (!entered_) return;
    if (solution_.has_beam()) beam_decay_ = std::exp(-column_.beam[layer].slope * column_.layers[layer].depth);
    even_.noalias() = basis_.even * solution_.row_even.middleCols(i * nodes, nodes).transpose();
    odd_.noalias() = basis_.odd * solution_.row_odd.middleCols(i * nodes, nodes).transpose();
  }

  /// Light of the whole layer.
  void cross(std::size_t layer) {
    own_.setZero();
    from_ground_.setZero();
    const auto i = static_cast<Index>(layer);
    for (Index j = 0; entered_ && j < solution_.k.rows(); ++j) {
      const bool linear = solution_.k(j, i) * column_.layers[layer].depth < kLinearMode;
      pair_with_rays(layer, j);
      if (linear)
        cross_linear(layer, j);
      else
        cross_mode(layer, j);
      if (solution_.has_beam()) cross_beam(layer, j);
    }
    if (!solution_.emits()) return;
    const LinearPlanck& planck = column_.emission[layer];
    const double bare = 1 - column_.layers[layer].albedo;
    for (Index r = 0; r < own_.size(); ++r) {
      const double constant = rays_.constant(r, i);
      const double even = entered_ ? even_.row(r).dot(solution_.thermal.col(i)) : 0.0;
      const double odd = entered_ ? odd_.row(r).dot(solution_.thermal.col(i)) : 0.0;
      own_(r) +=
          (even + bare) * (planck.top * constant + planck.slope * rays_.linear(r, i)) + odd * planck.slope * constant;
    }
  }

  /// Light of the part of a layer that ray r sees: own, from the ground.
  std::array<double, 2> look(std::size_t layer, Index r, const Sight& sight) const {
    std::array<double, 2> light{};
    const auto i = static_cast<Index>(layer);
    for (Index j = 0; entered_ && j < solution_.k.rows(); ++j) {
      const double k = solution_.k(j, i), even = even_(r, j), odd = odd_(r, j);
      const bool linear = k * sight.depth < kLinearMode;
      for (std::size_t c = 0; c < static_cast<std::size_t>(solution_.cases); ++c) {
        if (linear) {
          const double first = sight_constant(sight), second = sight_linear(sight) - 0.5 * sight.depth * first;
          const double a = solution_.even[c](j, i), b = solution_.odd[c](j, i);
          light[c] += even * (a * first + b * second) + odd * (b * first + k * k * a * second);
        } else {
          const ModePair pair = mode_pair(solution_, c, i, j);
          light[c] += (even - k * odd) * pair.falling * sight_falling(sight, k) +
                      (even + k * odd) * pair.rising * sight_rising(sight, k);
        }
      }
      if (solution_.has_beam()) {
        const double slope = column_.beam[layer].slope, source = solution_.beam_source(j, i);
        light[0] += source * (k * odd - even) * sight_difference(sight, k, slope) +
                    odd * (solution_.beam_odd(j, i) - source) * sight_falling(sight, slope);
      }
    }
    if (solution_.emits()) {
      const LinearPlanck& planck = column_.emission[layer];
      const double constant = sight_constant(sight);
      const double even = entered_ ? even_.row(r).dot(solution_.thermal.col(i)) : 0.0;
      const double odd = entered_ ? odd_.row(r).dot(solution_.thermal.col(i)) : 0.0;
      light[0] +=
          (even + 1 - column_.layers[layer].albedo) * (planck.top * constant + planck.slope * sight_linear(sight)) +
          odd * planck.slope * constant;
    }
    return light;
  }

 private:
  /// Constant and slope about the layer's middle.
  void cross_linear(std::size_t layer, Index j) {
    const auto i = static_cast<Index>(layer);
    const double k2 = solution_.k(j, i) * solution_.k(j, i), half = 0.5 * column_.layers[layer].depth;
    for (std::size_t c = 0; c < static_cast<std::size_t>(solution_.cases); ++c) {
      const double a = solution_.even[c](j, i), b = solution_.odd[c](j, i);
      ArrayXd& light = c == 0 ? own_ : from_ground_;
      for (Index r = 0; r < light.size(); ++r) {
        const double first = rays_.constant(r, i), second = rays_.linear(r, i) - half * first;
        light(r) += even_(r, j) * (a * first + b * second) + odd_(r, j) * (b * first + k2 * a * second);
      }
    }
  }

  /// Differences of the mode's and the rays' exponentials: integrals of what falls off towards the observer
  /// and of what falls off along the light, over the slant depth.
  void pair_with_rays(std::size_t layer, Index j) {
    const auto i = static_cast<Index>(layer);
    const double decay = solution_.decay(j, i), rate = solution_.k(j, i) * column_.layers[layer].depth;
    const double* slant = &rays_.slant(0, i);
    const double* fade = &rays_.fade(0, i);
    for (Index r = 0; r < own_.size(); ++r) {
      towards_(r) = exp_pair(0, rate + slant[r], 1, decay * fade[r]);
      along_(r) = exp_pair(rate, slant[r], decay, fade[r]);
    }
  }

  /// Falling from the top and from the bottom.
  void cross_mode(std::size_t layer, Index j) {
    const auto i = static_cast<Index>(layer);
    const double k = solution_.k(j, i);
    const ArrayXd& falling = rays_.up ? towards_ : along_;
    const ArrayXd& rising = rays_.up ? along_ : towards_;
    const ModePair own = mode_pair(solution_, 0, i, j);
    const auto even = even_.col(j).array(), odd = odd_.col(j).array();
    const auto slant = rays_.slant.col(i).array();
    own_ += slant * ((even - k * odd) * falling * own.falling + (even + k * odd) * rising * own.rising);
    if (solution_.cases == 1) return;
    const ModePair lit = mode_pair(solution_, 1, i, j);
    from_ground_ += slant * ((even - k * odd) * falling * lit.falling + (even + k * odd) * rising * lit.rising);
  }

  void cross_beam(std::size_t layer, Index j) {
    const auto i = static_cast<Index>(layer);
    const double source = solution_.beam_source(j, i), rest = solution_.beam_odd(j, i) - source;
    const double k = solution_.k(j, i), depth = column_.layers[layer].depth, rate = k * depth;
    const double slope = column_.beam[layer].slope * depth, decay = solution_.decay(j, i);
    const double beam_decay = beam_decay_, pair = solution_.beam_pair(j, i);
    for (Index r = 0; r < own_.size(); ++r) {
      const double y = rays_.slant(r, i), fade = rays_.fade(r, i), beam = rays_.beam(r, i);
      const double difference = rays_.up
                                    ? exp_triple({0, rate + y, slope + y}, {1, decay * fade, beam_decay * fade},
                                                 towards_(r), beam, fade * pair)
                                    : exp_triple({rate, slope, y}, {decay, beam_decay, fade}, pair, along_(r), beam);
      own_(r) += y * (source * (k * odd_(r, j) - even_(r, j)) * depth * difference + odd_(r, j) * rest * beam);
    }
  }

  const ScaledColumn& column_;
  const OrderSolution& solution_;
  const Rays& rays_;
  RayBasis basis_;
  MatrixXd even_, odd_;  ///< rays x modes
  ArrayXd own_, from_ground_, towards_, along_;
  double beam_decay_ = 0;
  bool entered_ = false;
};

}  // namespace

OrderRadiance order_radiance(const ScaledColumn& column, const OrderSolution& solution, const Rays& rays,
                             const std::vector<Place>& places) {
  const auto count = static_cast<Index>(rays.cosine.size()), asked = static_cast<Index>(places.size());
  const bool first = solution.order == 0;
  OrderRadiance out{MatrixXd::Zero(count, asked), MatrixXd::Zero(count, first ? asked : 0)};
  ArrayXd own = ArrayXd::Constant(count, first && !rays.up ? column.top_radiance : 0.0);
  ArrayXd from_ground = ArrayXd::Constant(count, first && rays.up ? 1.0 : 0.0);
  LayerLight light(column, solution, rays);
  travel(
      column, rays.up, places,
      [&](std::size_t p) {
        out.own.col(static_cast<Index>(p)) = own;
        if (first) out.from_ground.col(static_cast<Index>(p)) = from_ground;
      },
      [&](std::size_t p, std::size_t i) {
        light.enter(i);
        for (Index r = 0; r < count; ++r) {
          const Sight sight{rays.cosine[static_cast<std::size_t>(r)], rays.up, column.layers[i].depth, places[p].u};
          const double fade = std::exp(-sight.seen_depth() / sight.cosine);
          const std::array<double, 2> part = light.look(i, r, sight);
          out.own(r, static_cast<Index>(p)) = own(r) * fade + part[0];
          if (first) out.from_ground(r, static_cast<Index>(p)) = from_ground(r) * fade + part[1];
        }
      },
      [&](std::size_t i) {
        light.enter(i);
        light.cross(i);
        own = own * rays.fade.col(static_cast<Index>(i)).array() + light.own();
        if (first) from_ground = from_ground * rays.fade.col(static_cast<Index>(i)).array() + light.from_ground();
      });
  return out;
}

}  // namespace raycube::atmos::solver
