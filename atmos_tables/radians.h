// Angles of tables.
#pragma once

#include <numbers>

namespace raycube::atmos {

/// Rounded as tables have always been: base::rad_from_deg differs in the last bit, and with it their bytes.
inline double radians(double degrees) { return degrees * std::numbers::pi / 180; }

}  // namespace raycube::atmos
