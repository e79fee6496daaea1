// The cards MODTRAN 4 to 6 echoes above the header of a tape7 run: what was asked for, in fixed columns.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/import/imported.h"
#include "atmos_tables/import/modtran_axis.h"

namespace raycube::atmos::imported {

struct ModtranCards {
  std::optional<int> iemsct;  ///< 0 transmittance, 1 thermal, 2 thermal and solar, 3 direct irradiance, 4 solar
  std::optional<BandRequest> band;
  Geometry geometry;
};

/// Reads cards 1, 3, 3A and 4 from the echo above a header. What is not there or not readable stays empty.
ModtranCards read_modtran_cards(const std::vector<std::string>& echo);

/// The geometry of a path: heights and length in km, angles in degrees as MODTRAN means them; NaN = not said.
struct ModtranPath {
  double h1_km, h2_km, observer_zenith_deg, range_km, beta_deg;
  int iparm = 0;
  double parm1 = 0, parm2 = 0;  ///< IPARM = 2: sun's azimuth from the line of sight, and the sun's zenith
};
Geometry geometry_from_modtran(const ModtranPath& path);

}  // namespace raycube::atmos::imported
