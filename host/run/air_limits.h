// What a scene asks of the air beyond what the air knows: cut or held where that costs next to nothing, and told.
#pragma once

#include "scene_compiler/simulation.h"

namespace raycube::run {

/// Most of a band's weight that a cut may take, both sides together.
inline constexpr double kMostLostWeight = 1e-4;
/// A sun whose disc is still seen, by refraction (34') and its radius (16'), lights the air as at kHeldZenith_deg.
inline constexpr double kSunsetZenith_deg = 90 + 50.0 / 60, kHeldZenith_deg = 89.99;

/// Bands: sets Band::from_um and to_um where the atmosphere (its model, or its table), or the curve of a material that
/// is used, ends within a Gaussian response that has at most kMostLostWeight of its weight beyond; the band's mean is
/// then over what is left. A band that would lose more is left as it is, and refused later by the name of what does not
/// cover it.
/// Sun: of the built-in air, which is dark from 90 deg on, a zenith angle above kHeldZenith_deg, to kSunsetZenith_deg,
/// becomes kHeldZenith_deg; so it does with a table that was made for that angle.
/// A notice tells of each. Of a scene that is not compiled, no material is used.
void keep_within_air(scene::Simulation& simulation);

}  // namespace raycube::run
