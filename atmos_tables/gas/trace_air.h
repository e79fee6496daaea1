// Gases that a profile does not carry: one mixing ratio against height for every model (AFGL 1986).
#pragma once

#include <array>

namespace raycube::atmos {

struct TraceAir {
  double no_ppmv = 0, so2_ppmv = 0, no2_ppmv = 0, nh3_ppmv = 0, hno3_ppmv = 0;
};

/// Exponential between the 50 heights, 0 to 120 km above the sea; the value at the end beyond.
TraceAir trace_air(double height_km);

}  // namespace raycube::atmos
