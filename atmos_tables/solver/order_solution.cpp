#include "atmos_tables/solver/order_solution.h"

#include <cmath>
#include <numbers>

#include "atmos_tables/solver/exp_differences.h"
#include "atmos_tables/solver/legendre.h"

namespace raycube::atmos::solver {

using Eigen::Index;
using Eigen::VectorXd;

ParityBasis parity_basis(int order, int streams, double cosine) {
  const std::vector<double> value = normalized_legendre(order, streams, cosine);
  ParityBasis basis{VectorXd::Zero(streams / 2), VectorXd::Zero(streams / 2)};
  for (std::size_t i = 0; i < value.size(); ++i)
    (i % 2 == 0 ? basis.even : basis.odd)(static_cast<Index>(i / 2)) = value[i];
  return basis;
}

InnerFlux inner_flux(const ScaledColumn& column, const OrderSolution& first, std::size_t layer, double u) {
  const auto count = static_cast<Index>(column.nodes.cosine.size()), at = static_cast<Index>(layer);
  const Eigen::Map<const VectorXd> mu(column.nodes.cosine.data(), count), weight(column.nodes.weight.data(), count);
  const VectorXd flux_root = (weight.array() * mu.array()).sqrt();
  const double depth = column.layers[layer].depth;
  InnerFlux flux;
  for (std::size_t c = 0; c < 2; ++c) {
    VectorXd sigma(count), delta(count);
    for (Index j = 0; j < count; ++j) {
      const double k = first.k(j, at);
      // cosh(k t)/cosh(k d/2) and sinh(k t)/(k cosh(k d/2)) with t = u - d/2, by falling exponentials only.
      double even = 1, odd = u - 0.5 * depth;
      if (k * depth >= kLinearMode) {
        const double from_top = std::exp(-k * u), from_bottom = std::exp(-k * (depth - u));
        const double norm = 1 + first.decay(j, at);
        even = (from_top + from_bottom) / norm;
        odd = (from_bottom - from_top) / (k * norm);
      }
      sigma(j) = first.even[c](j, at) * even + first.odd[c](j, at) * odd;
      delta(j) = first.even[c](j, at) * k * k * odd + first.odd[c](j, at) * even;
      if (c == 0 && first.has_beam()) {
        const double slope = column.beam[layer].slope, fade = std::exp(-slope * u);
        const double difference = u * exp_difference(k * u, slope * u);  // (e^-ku - e^-slope u)/(slope - k)
        const double source = first.beam_source(j, at);
        sigma(j) -= source * difference;
        delta(j) += source * (k * difference - fade) + first.beam_odd(j, at) * fade;
      }
      if (c == 0 && first.emits()) {
        const LinearPlanck& planck = column.emission[layer];
        sigma(j) += first.thermal(j, at) * (planck.top + planck.slope * u);
        delta(j) += first.thermal(j, at) * planck.slope;
      }
    }
    const double sum = flux_root.dot(first.x.middleCols(at * count, count) * sigma);
    const double difference = flux_root.dot(first.z.middleCols(at * count, count) * delta);
    flux.up[c] = std::numbers::pi * (sum + difference);
    flux.down[c] = std::numbers::pi * (sum - difference);
  }
  return flux;
}

}  // namespace raycube::atmos::solver
