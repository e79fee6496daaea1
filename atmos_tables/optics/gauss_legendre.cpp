#include "atmos_tables/optics/gauss_legendre.h"

#include <cmath>
#include <numbers>

namespace raycube::atmos {

GaussRule gauss_legendre_rule(std::size_t nodes) {
  GaussRule rule{std::vector<double>(nodes), std::vector<double>(nodes)};
  const double n = static_cast<double>(nodes);
  for (std::size_t i = 0; i < (nodes + 1) / 2; ++i) {
    const bool middle = 2 * i + 1 == nodes;
    const double estimate = std::cos(std::numbers::pi * (static_cast<double>(i) + 0.75) / (n + 0.5));
    double x = middle ? 0 : estimate * (1 - (n - 1) / (8 * n * n * n));
    double slope = 1;
    for (int step = 0; step < 100; ++step) {
      double before = 1, here = x;  // P_0, P_1
      for (std::size_t k = 2; k <= nodes; ++k) {
        const double order = static_cast<double>(k), next = ((2 * order - 1) * x * here - (order - 1) * before) / order;
        before = here, here = next;
      }
      slope = n * (before - x * here) / ((1 - x) * (1 + x));
      const double change = here / slope;
      if (!middle) x -= change;
      if (middle || std::abs(change) <= 2e-16) break;
    }
    const double weight = 2 / ((1 - x) * (1 + x) * slope * slope);
    rule.node[i] = -x, rule.node[nodes - 1 - i] = x;
    rule.weight[i] = rule.weight[nodes - 1 - i] = weight;
  }
  return rule;
}

std::vector<double> legendre_moments(const GaussRule& rule, const std::vector<double>& value, std::size_t last) {
  std::vector<double> out(last + 1, 0.0);
  for (std::size_t i = 0; i < rule.node.size(); ++i) {
    const double x = rule.node[i], term = 0.5 * rule.weight[i] * value[i];
    double before = 0, here = 1;
    for (std::size_t k = 0; k <= last; ++k) {
      out[k] += term * here;
      const double order = static_cast<double>(k), next = ((2 * order + 1) * x * here - order * before) / (order + 1);
      before = here, here = next;
    }
  }
  return out;
}

double legendre_series(const std::vector<double>& moments, double cosine) {
  double sum = 0, before = 0, here = 1;
  for (std::size_t k = 0; k < moments.size(); ++k) {
    const double order = static_cast<double>(k);
    sum += (2 * order + 1) * moments[k] * here;
    const double next = ((2 * order + 1) * cosine * here - order * before) / (order + 1);
    before = here, here = next;
  }
  return sum;
}

}  // namespace raycube::atmos
