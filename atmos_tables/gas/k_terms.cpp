#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "atmos_tables/gas/exponential_sum.h"
#include "atmos_tables/gas/layer_gases.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

constexpr std::size_t kFactors = 12;
constexpr double kRatio = 2.5, kLeastPower = -6;
constexpr double kWeakDepth = 1e-4;

}  // namespace

template <class Column>
std::vector<double> LayerGases::layer_shares(double low, double high, Column&& amount_of_depth) const {
  std::vector<double> share(layers_, 0.0);
  for (const bool from_ground : {true, false}) {
    std::vector<double> path(layers_, 0.0);
    double before = 0;
    for (std::size_t k = 0; k < layers_; ++k) {
      const std::size_t layer = from_ground ? k : layers_ - 1 - k;
      path[layer] = 1;
      const double amount = k + 1 == layers_ ? 1 : amount_of_depth(mean_line_depth(low, high, path));
      share[layer] += 0.5 * std::max(amount - before, 0.0);
      before = std::max(amount, before);
    }
  }
  return share;
}

LayerGases::KTerms LayerGases::k_terms(double low, double high, std::size_t terms) const {
  if (terms < 1 || terms > 5)
    throw base::Error(base::Fault::bug, "gases: " + std::to_string(terms) + " k-terms asked for; 1 to 5 can be had");
  std::vector<double> amount, depth;
  for (std::size_t k = 0; k < kFactors; ++k) {
    amount.push_back(std::pow(kRatio, kLeastPower + static_cast<double>(k)));
    depth.push_back(mean_line_depth(low, high, std::vector<double>(layers_, amount.back())));
  }
  KTerms out;
  const double vertical = mean_line_depth(low, high, std::vector<double>(layers_, 1.0));
  if (!(vertical > 0)) {
    out.weight = {1}, out.layer_depth = {std::vector<double>(layers_, 0.0)};
    return out;
  }
  // The amount whose depth is given: a straight line in logarithms between the factors, and beyond.
  const auto amount_of_depth = [&](double wanted) {
    if (!(wanted > 0)) return 0.0;
    const std::size_t k = std::clamp<std::size_t>(
        static_cast<std::size_t>(std::upper_bound(depth.begin(), depth.end(), wanted) - depth.begin()), 1, kFactors - 1);
    const double slope = std::log(kRatio) / std::log(depth[k] / depth[k - 1]);
    return amount[k - 1] * std::exp(slope * std::log(wanted / depth[k - 1]));
  };
  std::vector<double> share = layer_shares(low, high, amount_of_depth);

  ExponentialSum sum;
  std::vector<double> transmittance, importance;
  for (std::size_t k = 0; k < kFactors; ++k) {
    transmittance.push_back(std::exp(-depth[k]));
    // Paths through the whole column, once or twice and slant, count most; far factors hold the ends.
    const double decades = std::log10(amount[k]);
    importance.push_back(std::exp(-decades * decades / 2) + 0.05);
  }
  if (vertical < kWeakDepth) {
    sum.weight = {1}, sum.rate = {vertical};
  } else {
    sum = fit_exponential_sum(amount, transmittance, importance, terms);
  }
  double squares = 0;
  for (std::size_t k = 0; k < kFactors; ++k) squares += std::pow(sum.at(amount[k]) - transmittance[k], 2);
  out.fit_rms = std::sqrt(squares / kFactors);
  out.weight = sum.weight;
  for (double rate : sum.rate) {
    out.layer_depth.push_back(share);
    for (double& value : out.layer_depth.back()) value *= rate;
  }
  return out;
}

}  // namespace raycube::atmos
