// Gases of the layered model whose lines a user's files resolve: what replaces the band models, and where.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/lines/absorber.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

struct LineAir {
  std::vector<AbsorbingGas> gases;
  std::vector<std::string> notices;

  /// Whether a gas of the profile is resolved here: its band model must then be silent.
  bool resolves(Gas gas) const;
};

/// Whether the specification names any file of lines or cross-sections.
bool has_line_air(const scene::AirSpec& spec);

/// Reads the files for wavenumbers from low to high, cm-1. Every gas of the profile with a line anywhere in the list is
/// resolved; of water the pedestal is left to the continuum. Lines of other molecules are left out, as are gases that a
/// cross-section file gives. Notices: what stays with the band model, what the files do not cover. Throws Error as the
/// readers do.
LineAir read_line_air(const scene::AirSpec& spec, double low_per_cm, double high_per_cm);

/// The profile without the gases resolved: for the band models beside them.
AirProfile without_resolved(const AirProfile& profile, const LineAir& lines);

}  // namespace raycube::atmos
