#include "atmos_tables/solver/beam_path.h"

#include <algorithm>
#include <cmath>

namespace raycube::atmos::solver {
namespace {

constexpr double kSlopeMin = 1e-6;

/// Slant depth from space to `level`. Chord of a shell seen from radius r at zenith angle Z: difference of
/// sqrt(R^2 - r^2 sin^2 Z).
double slant_depth(const Column& column, const std::vector<double>& depth, std::size_t level) {
  const double sine2 = (1 - column.beam.cosine) * (1 + column.beam.cosine);
  const auto radius = [&column](std::size_t i) { return column.planet_radius_m + column.level_height_m[i]; };
  const double impact2 = radius(level) * radius(level) * sine2;
  double slant = 0;
  for (std::size_t j = 0; j < level; ++j) {
    const double outer = std::sqrt(radius(j) * radius(j) - impact2);
    const double inner = std::sqrt(std::max(0.0, radius(j + 1) * radius(j + 1) - impact2));
    slant += depth[j] * (radius(j) + radius(j + 1)) /
             (outer + inner);  // chord / thickness without a difference of like numbers
  }
  return slant;
}

}  // namespace

std::vector<BeamLayer> beam_through_layers(const Column& column, const std::vector<double>& depth) {
  std::vector<BeamLayer> beam(depth.size());
  if (column.level_height_m.empty()) {
    const double slope = 1 / std::max(column.beam.cosine, 1e-9);
    double above = 0;
    for (std::size_t i = 0; i < depth.size(); ++i) {
      beam[i] = {std::exp(-above * slope), slope};
      above += depth[i];
    }
    return beam;
  }
  double at_top = 0;
  for (std::size_t i = 0; i < depth.size(); ++i) {
    const double at_bottom = slant_depth(column, depth, i + 1);
    const double slope = depth[i] > 0 ? (at_bottom - at_top) / depth[i] : 1.0;
    // The floor keeps slope + eigenvalue away from 0, the one point where the particular solution has no
    // limit (layer_modes).
    if (slope < kSlopeMin)
      beam[i] = {0.5 * (std::exp(-at_top) + std::exp(-at_bottom)), kSlopeMin};
    else
      beam[i] = {std::exp(-at_top), slope};
    at_top = at_bottom;
  }
  return beam;
}

}  // namespace raycube::atmos::solver
