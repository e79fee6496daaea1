// Integrals of smooth pieces, for closed forms that have none.
#pragma once

#include <cmath>

#include "atmos_tables/optics/gauss_legendre.h"

namespace raycube::lidar {

/// 64 Gauss-Legendre nodes.
inline const atmos::GaussRule& rule_64() {
  static const atmos::GaussRule rule = atmos::gauss_legendre_rule(64);
  return rule;
}

/// Integral of f over lo..hi by 64 Gauss-Legendre nodes on each of `pieces` equal parts.
template <class F>
double integrate(F&& f, double lo, double hi, int pieces = 1) {
  const atmos::GaussRule& rule = rule_64();
  const double half = 0.5 * (hi - lo) / pieces;
  double sum = 0;
  for (int p = 0; p < pieces; ++p) {
    const double middle = lo + (2 * p + 1) * half;
    for (std::size_t i = 0; i < rule.node.size(); ++i) sum += rule.weight[i] * f(middle + half * rule.node[i]);
  }
  return sum * half;
}

/// The same for one piece whose ends are branch points (a power such as 1/2 or 3/2 of the distance to an end): with
/// x = middle + half sin(pi t / 2) such powers become smooth.
template <class F>
double integrate_branch_ends(F&& f, double lo, double hi) {
  const double middle = 0.5 * (lo + hi), half = 0.5 * (hi - lo), quarter_turn = 0.5 * M_PI;
  return half * quarter_turn *
         integrate([&](double t) { return std::cos(quarter_turn * t) * f(middle + half * std::sin(quarter_turn * t)); },
                   -1, 1);
}

}  // namespace raycube::lidar
