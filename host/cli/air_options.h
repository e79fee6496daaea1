// What a user types of the air's profile and aerosol: the same for `atmos build` and `atmos lidar`.
#pragma once

#include <limits>
#include <string>

#include "host/base/options.h"
#include "scene_compiler/simulation.h"

namespace raycube::cli {

/// NaN and empty: not typed.
struct AirOptions {
  std::string profile, fill, aerosol;
  double visibility_km = std::numeric_limits<double>::quiet_NaN();
  double aod_550 = std::numeric_limits<double>::quiet_NaN();
  double humidity_percent = std::numeric_limits<double>::quiet_NaN();
};

/// --profile, --fill, --aerosol, --visibility, --aod and --humidity. `aod_help`: what an absent --aod means.
void add_air_options(base::OptionTable& table, AirOptions& options, const char* aod_standing);

/// Puts what was typed in the place of what a scene file said. Throws Error(input) for what contradicts
/// itself: two amounts of aerosol, an amount of none, a filling model without a profile to fill.
void apply(const AirOptions& options, scene::AirSpec& air);

}  // namespace raycube::cli
