#include "atmos_tables/solver/user_radiance.h"

#include <cmath>

#include "atmos_tables/solver/legendre.h"
#include "atmos_tables/solver/path_integrals.h"

namespace raycube::atmos::solver {
namespace {

using Eigen::VectorXd;

/// Weights that turn modal amplitudes into the source function: J = even . sigma + odd . delta (odd signed by
/// the direction).
struct SourceRow {
  VectorXd even, odd;
};

SourceRow source_row(const LayerMode& mode, const ScaledLayer& layer, const OrderBasis& basis,
                     const VectorXd& ratio, bool up) {
  VectorXd even_weight = VectorXd::Zero(basis.node.rows()), odd_weight = even_weight;
  for (Eigen::Index i = 0; i < even_weight.size(); ++i) {
    const auto degree = static_cast<std::size_t>(basis.order + i);
    const double term =
        0.5 * layer.albedo * (2 * static_cast<double>(degree) + 1) * layer.moment[degree] * basis.beam(i);
    (i % 2 == 0 ? even_weight : odd_weight)(i) = term;
  }
  const VectorXd even = (basis.node.transpose() * even_weight).cwiseProduct(ratio);
  const VectorXd odd = (basis.node.transpose() * odd_weight).cwiseProduct(ratio);
  return {mode.x.transpose() * even, (up ? 1.0 : -1.0) * (mode.z.transpose() * odd)};
}

/// Light of the particular solution and of the emission itself.
double own_light(const LayerMode& mode, const ScaledLayer& layer, const SourceRow& row, const Sight& sight) {
  double light = 0;
  if (mode.beam_source.size() > 0) {
    const double fade = sight_falling(sight, mode.beam_slope);
    for (Eigen::Index j = 0; j < mode.k.size(); ++j) {
      const double source = mode.beam_source(j), k = mode.k(j);
      light += source * (k * row.odd(j) - row.even(j)) * sight_difference(sight, k, mode.beam_slope);
      light += row.odd(j) * (mode.beam_odd(j) - source) * fade;
    }
  }
  if (mode.thermal.size() > 0) {
    const double constant = sight_constant(sight);
    const double planck = mode.planck_top * constant + mode.planck_slope * sight_linear(sight);
    light += (row.even.dot(mode.thermal) + 1 - layer.albedo) * planck +
             row.odd.dot(mode.thermal) * mode.planck_slope * constant;
  }
  return light;
}

/// Light of the homogeneous solution, one number per case.
std::array<double, 2> diffuse_light(const OrderSolution& solution, std::size_t index, const SourceRow& row,
                                    const Sight& sight) {
  const LayerMode& mode = solution.layers[index];
  std::array<double, 2> light{};
  for (Eigen::Index j = 0; j < mode.k.size(); ++j) {
    const double k = mode.k(j);
    const bool linear = k * mode.depth < kLinearMode;
    // Linear modes: constant and slope about the layer's middle; others: falling from the top and from the
    // bottom.
    const double first = linear ? sight_constant(sight) : sight_falling(sight, k);
    const double second = linear ? sight_linear(sight) - 0.5 * mode.depth * first : sight_rising(sight, k);
    const double norm = 1 + std::exp(-k * mode.depth);
    for (std::size_t c = 0; c < static_cast<std::size_t>(solution.cases); ++c) {
      const double even = solution.amplitudes[c][index].even(j), odd = solution.amplitudes[c][index].odd(j);
      if (linear) {
        light[c] +=
            row.even(j) * (even * first + odd * second) + row.odd(j) * (odd * first + k * k * even * second);
      } else {
        const double falling = (even - odd / k) / norm * first, rising = (even + odd / k) / norm * second;
        light[c] += row.even(j) * (falling + rising) + row.odd(j) * k * (rising - falling);
      }
    }
  }
  return light;
}

}  // namespace

std::array<double, 2> order_radiance(const OrderSolution& solution, const std::vector<ScaledLayer>& scaled,
                                     const HalfRange& nodes, int streams, double cosine, bool up,
                                     const Place& place, double top_radiance) {
  const bool first_order = solution.order == 0;
  std::array<double, 2> radiance{!up && first_order ? top_radiance : 0.0, up && first_order ? 1.0 : 0.0};
  const std::size_t count = scaled.size();
  if (count == 0) return radiance;
  const auto size = static_cast<Eigen::Index>(nodes.cosine.size());
  const Eigen::Map<const VectorXd> mu(nodes.cosine.data(), size), weight(nodes.weight.data(), size);
  const VectorXd ratio = (weight.array() / mu.array()).sqrt();
  const OrderBasis basis = order_basis(solution.order, streams, nodes, cosine);
  // From the far end of the line of sight towards the observer.
  const std::size_t steps = up ? count - place.layer : place.layer + 1;
  for (std::size_t step = 0; step < steps; ++step) {
    const std::size_t i = up ? count - 1 - step : step;
    const double edge = up ? 0.0 : scaled[i].depth;
    const Sight sight{cosine, up, scaled[i].depth, i == place.layer ? place.u : edge};
    const double fade = std::exp(-sight.seen_depth() / cosine);
    const SourceRow row = source_row(solution.layers[i], scaled[i], basis, ratio, up);
    const std::array<double, 2> light = diffuse_light(solution, i, row, sight);
    radiance[0] = radiance[0] * fade + light[0] + own_light(solution.layers[i], scaled[i], row, sight);
    radiance[1] = radiance[1] * fade + light[1];
  }
  return radiance;
}

}  // namespace raycube::atmos::solver
