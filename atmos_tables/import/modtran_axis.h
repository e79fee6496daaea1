// Which unit a MODTRAN spectral axis counts in: its label, the flags of card 4, and whether the values lie in the band
// asked for.
#pragma once

#include <optional>
#include <string>

#include "atmos_tables/import/conversions.h"
#include "host/base/error.h"

namespace raycube::atmos::imported {

/// The band a run was asked for, in the unit its flags name.
struct BandRequest {
  double first = 0, last = 0;
  AxisUnit unit = AxisUnit::per_cm;
  double slack = 0;  ///< a step and a slit width, in the same unit
};

/// FLAGS(1): blank or W = cm-1, M = um, N = nm; anything else is empty.
std::optional<AxisUnit> axis_unit_from_flag(char flag);

/// The axis's unit. `label`: "FREQ", "CM-1", "WAVLEN (NM)", one or two header lines joined. Adds a problem and returns
/// nothing when no unit that the label allows puts first..last into the band, or neither label nor band says which it
/// is.
std::optional<AxisUnit> settle_axis(const std::string& label, double first, double last,
                                    const std::optional<BandRequest>& band, const base::Where& where,
                                    base::Problems& problems);

}  // namespace raycube::atmos::imported
