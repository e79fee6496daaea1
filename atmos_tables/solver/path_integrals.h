// Integrals of one layer's light along a line of sight: the source functions' shapes in depth, attenuated
// towards the observer.
#pragma once

namespace raycube::atmos::solver {

/// The part of a layer that an observer sees: u is the scaled depth below the layer's top. Looking at light
/// that travels up he stands at u_near and sees u_near ... depth; at light that travels down, he stands at
/// u_near and sees 0 ... u_near.
struct Sight {
  double cosine = 1;  ///< of the line of sight, (0, 1]
  bool up = true;     ///< travel of the light
  double depth = 0;   ///< scaled depth of the whole layer
  double u_near = 0;  ///< place of the observer, [0, depth]

  double seen_depth() const { return up ? depth - u_near : u_near; }
};

/// Integral over the seen part of f(u) exp(-|u - u_near| / cosine) du / cosine, for f =
double sight_falling(const Sight& sight, double rate);  ///< exp(-rate u)
double sight_rising(const Sight& sight, double rate);   ///< exp(-rate (depth - u))
double sight_difference(const Sight& sight, double first,
                        double second);     ///< (exp(-first u) - exp(-second u)) / (second - first)
double sight_constant(const Sight& sight);  ///< 1
double sight_linear(const Sight& sight);    ///< u

}  // namespace raycube::atmos::solver
