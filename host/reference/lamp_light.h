// Light of lamps on one side of a sample's surface: by the draw that the device makes, and by all lamps at once.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reference/sampled_pixel.h"

namespace raycube::reference {

/// A lamp that a side has drawn of a source (kernels/light/lamps.h), in double and by formulas of its own.
struct DrawnLamp {
  double irradiance = 0;    ///< W m-2 of the source's spectrum if nothing is in the way, over the draw's chance
  glm::dvec3 at{0};         ///< m, scene frame: where on the lamp
  glm::dvec3 direction{0};  ///< unit, to there
  double limit = 1;         ///< of the way to there, where something may hide it
  bool open = true;
};

/// What a draw may have said.
struct LampDraws {
  /// The lamp that double arithmetic draws; then those that roundings may draw in its place. Empty: no lamp may shine
  /// there.
  std::vector<DrawnLamp> lamps;
  double bound = 0;  ///< W m-2, by which another computation of the same draw may be off
};

/// number: of the draw (rc_lamp_number).
LampDraws lamp_draws(const ReferenceScene& scene, const plan::Plan& plan, std::uint64_t seed, std::uint32_t pixel,
                     std::uint32_t number, std::uint32_t source, const Sample& side);

/// Irradiance of every source, with shapes times pi f: of every lamp in sight, surfaces by 64 points each.
std::vector<double> all_lamplight(const ReferenceScene& scene, const plan::Plan& plan, const Sample& side);

/// Light of a lamp that a side sees.
struct LampLight {
  std::uint32_t source = 0;
  double irradiance = 0;    ///< W m-2 of the source's spectrum
  glm::dvec3 direction{0};  ///< unit, to the lamp
};
/// By one point of each surface, v and w in [0, 1): right in the mean of many.
std::vector<LampLight> some_lamplight(const ReferenceScene& scene, const plan::Plan& plan, const Sample& side, double v,
                                      double w);

}  // namespace raycube::reference
