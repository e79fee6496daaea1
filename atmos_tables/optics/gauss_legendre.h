// Gauss-Legendre rules of any order, for phase functions with narrow peaks (thousands of nodes).
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::atmos {

struct GaussRule {
  std::vector<double> node, weight;  ///< ascending nodes in (-1, 1), symmetric to the last bit; weights sum to 2
};

/// Newton's iteration on P_n from Tricomi's estimate; n >= 1. Exact for polynomials up to degree 2n - 1.
GaussRule gauss_legendre_rule(std::size_t nodes);

/// moments[k] = 1/2 sum_i weight_i value_i P_k(node_i), k = 0..last: Legendre moments of a function known at the nodes.
std::vector<double> legendre_moments(const GaussRule& rule, const std::vector<double>& value, std::size_t last);

/// sum_k (2k + 1) moments[k] P_k(cosine): the function that moments describe.
double legendre_series(const std::vector<double>& moments, double cosine);

}  // namespace raycube::atmos
