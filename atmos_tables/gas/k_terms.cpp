#include <algorithm>
#include <cmath>
#include <string>

#include "atmos_tables/gas/exponential_sum.h"
#include "atmos_tables/gas/layer_gases.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

constexpr std::size_t kFactors = 12;
constexpr double kRatio = 2.5, kLeastPower = -6;
constexpr double kClearDepth = 1e-12, kWeakDepth = 1e-4;
constexpr std::size_t kMostThinner = 12;
constexpr double kThinDepth = 0.03;

}  // namespace

template <class Column>
std::vector<double> LayerGases::layer_shares(double low, double high, Column&& amount_of_depth) const {
  // Fractions of the column above and below each level between layers, from the depths of the two partial columns.
  std::vector<double> above(layers_ + 1, 1.0), below(layers_ + 1, 1.0), path(layers_, 0.0);
  above[layers_] = below[0] = 0;
  for (std::size_t level = 1; level < layers_; ++level) {
    path[level - 1] = 1;
    below[level] = std::clamp(amount_of_depth(mean_line_depth(low, high, path)), below[level - 1], 1.0);
  }
  std::fill(path.begin(), path.end(), 0.0);
  for (std::size_t level = layers_ - 1; level > 0; --level) {
    path[level] = 1;
    above[level] = std::clamp(amount_of_depth(mean_line_depth(low, high, path)), above[level + 1], 1.0);
  }
  // Where they do not join to 1, the smaller one is the better known: near the top the column above, near the ground
  // that below.
  std::vector<double> share(layers_);
  double before = 0;
  for (std::size_t layer = layers_; layer-- > 0;) {
    const double fraction = above[layer] * (2 - above[layer] - below[layer]);
    share[layer] = std::max(fraction - before, 0.0);
    before = std::max(before, fraction);
  }
  return share;
}

LayerGases::KTerms LayerGases::k_terms(double low, double high, std::size_t terms) const {
  if (terms < 1 || terms > 5)
    throw base::Error(base::Fault::bug, "gases: " + std::to_string(terms) + " k-terms asked for; 1 to 5 can be had");
  // Twelve factors around the column itself, and more below where even they are deep: high partial columns live there.
  std::vector<double> amount, depth;
  for (std::size_t k = 0; k < kFactors; ++k) {
    amount.push_back(std::pow(kRatio, kLeastPower + static_cast<double>(k)));
    depth.push_back(mean_line_depth(low, high, std::vector<double>(layers_, amount.back())));
  }
  for (std::size_t k = 0; k < kMostThinner && depth.front() > kThinDepth; ++k) {
    amount.insert(amount.begin(), amount.front() / kRatio);
    depth.insert(depth.begin(), mean_line_depth(low, high, std::vector<double>(layers_, amount.front())));
  }
  KTerms out;
  const double vertical = mean_line_depth(low, high, std::vector<double>(layers_, 1.0));
  if (!(vertical > kClearDepth)) {
    out.weight = {1}, out.layer_depth = {std::vector<double>(layers_, 0.0)};
    return out;
  }
  // The amount whose depth is given: a straight line in logarithms between the factors, and beyond.
  const auto amount_of_depth = [&](double wanted) {
    if (!(wanted > 0)) return 0.0;
    const std::size_t k = std::clamp<std::size_t>(
        static_cast<std::size_t>(std::upper_bound(depth.begin(), depth.end(), wanted) - depth.begin()), 1,
        depth.size() - 1);
    const double step = std::log(depth[k] / depth[k - 1]);
    if (!(step > 1e-6)) return amount[k - 1];  // only the clear part of the bin still transmits
    return amount[k - 1] * std::exp(std::log(kRatio) * std::min(std::log(wanted / depth[k - 1]) / step, 1.0));
  };
  std::vector<double> share = layer_shares(low, high, amount_of_depth);

  ExponentialSum sum;
  std::vector<double> transmittance, importance;
  for (std::size_t k = 0; k < depth.size(); ++k) {
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
  for (std::size_t k = 0; k < depth.size(); ++k) squares += std::pow(sum.at(amount[k]) - transmittance[k], 2);
  out.fit_rms = std::sqrt(squares / static_cast<double>(depth.size()));
  out.weight = sum.weight;
  for (double rate : sum.rate) {
    out.layer_depth.push_back(share);
    for (double& value : out.layer_depth.back()) value *= rate;
  }
  return out;
}

}  // namespace raycube::atmos
