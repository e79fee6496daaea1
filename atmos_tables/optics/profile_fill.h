// A user's profile completed from a model atmosphere, as MODTRAN and others do: what a radiosonde does not
// measure is there all the same.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/optics/profile_csv.h"
#include "atmos_tables/optics/standard_air.h"

namespace raycube::atmos {

struct CompletedProfile {
  AirProfile air;
  std::vector<std::string> notices;  ///< what was taken from the model
};

/// Gases that the file has no column for get the model's mixing ratios at the same height (water at most
/// saturation); between the file's levels the model's stand in too, where state and own gases are those of
/// the file's own rule. Above the file's last level, where that lies below top_km, the model goes on: its
/// temperatures and mixing ratios, its pressures times the one factor that meets the file's at the joint,
/// which keeps them hydrostatic; a gas that the file states as 0 throughout stays 0. A file with all gases up
/// to top_km comes back as it is.
CompletedProfile completed(const ProfileFile& own, AfglModel model, double top_km);

}  // namespace raycube::atmos
