// What light between surfaces is multiplied by along paths, from curves and sources to products: what the wavelengths
// along them are chosen by.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/plan/path_heat.h"
#include "host/plan/plan.h"

namespace raycube::plan {

using Curves = std::vector<std::vector<double>>;  ///< [curve][grid]

inline constexpr std::uint32_t kNobody = 0xFFFFFFFFu;

struct PathFactors {
  Curves curve;
  std::vector<std::uint32_t> owner;  ///< material of each; kNobody: of several
};
/// Every curve that light may be multiplied by, on the grid: reflectances, transmittances of leaves and plates, sums of
/// both, and 1, a gloss's; none of what is black.
PathFactors factors_of(const Plan& plan, const scene::CompiledScene& scene);

/// What all sources but lamps send together, [h * view.count + v][grid]: Bounces::together.
Curves light_together(const Plan& plan, const scene::CompiledScene& scene);
/// The node in the middle of heights, whose light stands for that of all.
std::size_t middle_node(const Plan& plan);
/// Of sun, skies and surroundings: each source's light over that of all together, on the grid; 0 where there is none.
Curves shares_of(const Plan& plan, const std::vector<double>& together);

/// What products are made of: the first `curves` are of matter, the others are sources' shares, the last `emitted` of
/// what matter sends by itself.
struct PathParts {
  Curves all;
  std::size_t curves = 0, emitted = 0;
  std::vector<std::uint32_t> owner;  ///< of the curves: PathFactors
  /// Of the plan, weighted by the light that falls there, that of all sources but lamps, then that of each source of
  /// lamps; each sums to 1, or to 0.
  std::vector<BandQuadrature> bands;
  /// What black matter shows by itself beside the light of bands before `warm_bands`, [grid]; empty: nothing.
  std::vector<double> warmth;
  std::size_t warm_bands = 0;
  /// Light at a place of the grid over that of the bands there, where that is most of all lights; 0: none sees it.
  std::vector<double> seen;
  std::size_t shares() const { return all.size() - curves; }
  /// Of how many curves a product with that share is at least: all but emitted light was scattered before.
  std::size_t fewest(std::size_t share) const { return share + emitted < shares() ? 2 : 1; }
  /// A curve's matter as it shows by itself, on the grid.
  std::vector<double> shown(std::size_t curve) const {
    std::vector<double> out = all[curve];
    for (std::size_t i = 0; i < warmth.size(); ++i) out[i] += (1 - out[i]) * warmth[i];
    return out;
  }
};

/// Curves of matter with what they are lit by, and with what they send by themselves.
PathParts parts_of(const Plan& plan, const scene::CompiledScene& scene, PathFactors factors,
                   const std::vector<double>& together, const Curves& shares, const PathHeat& heat);

/// Mean of values on the grid over a band.
double band_mean(const BandQuadrature& band, const double* values);
double largest_of(const std::vector<double>& values);

/// Means of each curve over the bands, [curve][band], no smaller than a hundredth of its largest: what its matter shows
/// of itself.
Curves own_light(const PathParts& parts);

}  // namespace raycube::plan
