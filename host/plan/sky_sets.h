// Direction sets towards the sky: low-discrepancy points over the hemisphere, shifted and turned from set to set.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/plan/plan.h"

namespace raycube::plan {

inline constexpr int kMostDirections = 4096;
inline constexpr int kFewestSets = 64, kMostSets = 4096;

/// Sets of `directions` unit vectors (1 .. kMostDirections). Each estimates integral of A_m max(0, n.d) dOmega without
/// bias over the sets. sun_azimuth_rad: where the maps' azimuth 0 lies, clockwise from north.
/// `components`: how many of the basis' maps count. With `thermal` light its sky's maps (of zenith angle alone) and the
/// surroundings follow them in the weights; directions are then drawn for the basis, or for the thermal sky where that
/// is empty. `most_sets` (>= kFewestSets): fewer sets, the first of the same, for trials.
SkySets make_sky_sets(const SkyBasis& basis, double sun_azimuth_rad, int directions, std::uint64_t seed,
                      int components = 4, const Thermal* thermal = nullptr, int most_sets = kMostSets);

/// One set of given directions (unit, z > 0), each of the same solid angle.
SkySets sky_set_of(const SkyBasis& basis, double sun_azimuth_rad, const std::vector<std::array<double, 3>>& directions,
                   double solid_angle_sr, int components, const Thermal* thermal);

/// How a pixel's samples share out its directions unless the simulation says: the largest power of two, up to
/// kMostShare, that divides the directions and leaves each of them kFewestPoints samples, below which a bundle costs as
/// much as a few rays. `given`: Simulation::sky_share; 0 is the rule, others are as they are and must divide the
/// directions.
int sky_share(int given, int samples, int directions);
inline constexpr int kMostShare = 16, kFewestPoints = 8;

}  // namespace raycube::plan
