// Bessel functions that do not overflow.
#pragma once

namespace raycube::lidar {

/// exp(-x) I0(x), x >= 0; relative error 1e-15 or so.
double scaled_bessel_i0(double x);

}  // namespace raycube::lidar
