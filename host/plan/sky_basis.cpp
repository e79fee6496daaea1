#include "host/plan/sky_basis.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/plan/quadrature.h"

namespace raycube::plan {

Cell find_cell(const std::vector<double>& nodes, double at) {
  if (nodes.size() < 2 || at <= nodes.front()) return {0, 0};
  if (at >= nodes.back()) return {nodes.size() - 2, 1};
  const auto i = static_cast<std::size_t>(std::upper_bound(nodes.begin(), nodes.end(), at) - nodes.begin()) - 1;
  return {i, (at - nodes[i]) / (nodes[i + 1] - nodes[i])};
}

std::array<double, 4> sky_value(const SkyBasis& basis, double sun_azimuth_rad, double x, double y, double z) {
  if (z < 0 || basis.empty()) return {0, 0, 0, 0};
  const double horizontal = std::hypot(x, y);
  const Cell zenith = find_cell(basis.zenith_rad, std::atan2(horizontal, z));
  const double relative = horizontal > 0 ? std::remainder(std::atan2(x, y) - sun_azimuth_rad, 2 * std::numbers::pi) : 0;
  const Cell azimuth = find_cell(basis.azimuth_rad, std::abs(relative));
  const std::size_t row = basis.azimuth_rad.size(), i = zenith.index * row + azimuth.index;
  std::array<double, 4> out;
  for (std::size_t m = 0; m < 4; ++m) {
    const double a = (1 - azimuth.fraction) * basis.value[i][m] + azimuth.fraction * basis.value[i + 1][m];
    const double b = (1 - azimuth.fraction) * basis.value[i + row][m] + azimuth.fraction * basis.value[i + row + 1][m];
    out[m] = (1 - zenith.fraction) * a + zenith.fraction * b;
  }
  return out;
}

namespace {

/// Integrals of the nodes' hat functions against density(zenith) sin(zenith) over both sides of the sun's vertical
/// plane.
template <class Density>
std::vector<double> hat_weights(const SkyBasis& basis, Density density) {
  static const auto rule = gauss_legendre(8);
  const auto& t = basis.zenith_rad;
  const auto& f = basis.azimuth_rad;
  std::vector<double> zenith(t.size(), 0.0), azimuth(f.size(), 0.0);
  for (std::size_t i = 0; i + 1 < t.size(); ++i)
    for (const auto& [node, weight] : rule) {
      const double s = 0.5 * (1 + node), at = t[i] + s * (t[i + 1] - t[i]);
      const double w = 0.5 * weight * (t[i + 1] - t[i]) * std::sin(at) * density(at);
      zenith[i] += w * (1 - s);
      zenith[i + 1] += w * s;
    }
  for (std::size_t j = 0; j + 1 < f.size(); ++j) {  // both sides of the sun's vertical plane: factor 2
    azimuth[j] += f[j + 1] - f[j];
    azimuth[j + 1] += f[j + 1] - f[j];
  }
  std::vector<double> q(basis.nodes());
  for (std::size_t i = 0; i < t.size(); ++i)
    for (std::size_t j = 0; j < f.size(); ++j) q[i * f.size() + j] = zenith[i] * azimuth[j];
  return q;
}

}  // namespace

std::vector<double> cosine_weights(const SkyBasis& basis) {
  return hat_weights(basis, [](double zenith) { return std::cos(zenith); });
}

std::vector<double> solid_angle_weights(const SkyBasis& basis) {
  return hat_weights(basis, [](double) { return 1.0; });
}

}  // namespace raycube::plan
