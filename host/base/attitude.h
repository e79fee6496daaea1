// How a platform is turned, and what lies between two attitudes (docs/conventions.md, "Platform"). Double
// throughout.
#pragma once

#include <glm/gtc/quaternion.hpp>

namespace raycube::base {

/// Heading clockwise from north, pitch nose up, roll right wing down, each about the axis already turned
/// (z-y-x, intrinsic).
struct Attitude {
  double roll_deg = 0, pitch_deg = 0, heading_deg = 0;
  bool operator==(const Attitude&) const = default;
};

/// Turns forward-right-down into north-east-down.
glm::dquat ned_from_body(const Attitude& attitude);

/// The shorter turn, `fraction` of the way: 0 gives `from`, 1 gives `to`, others go on at the same rate
/// (spherical linear interpolation; Shoemake, "Animating rotation with quaternion curves", SIGGRAPH 1985).
glm::dquat turn_between(const glm::dquat& from, glm::dquat to, double fraction);

/// The same between attitudes, as angles again: roll and heading in (-180, 180], pitch in [-90, 90]; at a
/// pitch of 90 degrees, where only their sum or difference counts, roll is 0. Equal attitudes, and the ends,
/// are returned as they are, bit for bit.
Attitude attitude_between(const Attitude& from, const Attitude& to, double fraction);

}  // namespace raycube::base
