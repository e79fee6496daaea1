// The cards MODTRAN 4 to 6 echoes above the header of a tape7 run: what was asked for, in fixed columns.
#pragma once

#include <limits>
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

/// The geometry of a path as MODTRAN's cards or its input give it: heights and length in km, angles in degrees; NaN =
/// not said.
struct ModtranPath {
  double h1_km = kNotSaid, h2_km = kNotSaid, observer_zenith_deg = kNotSaid, range_km = kNotSaid, beta_deg = kNotSaid;
  /// What parm holds. 0, 10: latitude and longitude (west) of observer or target, then of the subsolar point; 1, 11:
  /// the place alone, the sun by day and time; 2, 12: the sun's azimuth from the path at observer or target, and its
  /// zenith.
  int iparm = 0;
  double parm[4] = {kNotSaid, kNotSaid, kNotSaid, kNotSaid};
  int day_of_year = 0;                 ///< 0: not said
  double time_h = kNotSaid;            ///< UT
  double path_azimuth_deg = kNotSaid;  ///< clockwise from north: of H1 towards H2, with iparm 10 to 12 of H2 towards H1
  double ground_km = kNotSaid;

  static constexpr double kNotSaid = std::numeric_limits<double>::quiet_NaN();
};
/// With iparm 10 and above, and for paths down wherever the place is known, the sun is that of the path's lower end. A
/// place given for the observer is carried there along the sight, a straight line over a sphere of 6371.23 km, without
/// refraction. The sun's zenith has none either: 0.019 deg more than the .tp6 of the same run prints at 52 deg.
Geometry geometry_from_modtran(const ModtranPath& path);

}  // namespace raycube::atmos::imported
