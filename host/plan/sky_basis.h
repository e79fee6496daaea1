// The sky's angular maps: up to four functions of direction, linear in (zenith, azimuth) between the nodes of a product
// grid, symmetric about the sun's vertical plane, zero below the horizon. Component 0 integrates to 1 against
// cos(zenith), the others to 0, so that component 0 carries the horizontal irradiance exactly.
#pragma once

#include <array>
#include <vector>

namespace raycube::plan {

struct SkyBasis {
  std::vector<double> zenith_rad;   ///< ascending, 0 .. pi/2
  std::vector<double> azimuth_rad;  ///< relative to the sun, ascending, 0 .. pi
  std::vector<std::array<double, 4>>
      value;  ///< [zenith][azimuth], components 0..3, sr-1; equal over azimuth at zenith 0

  bool empty() const { return value.empty(); }
  std::size_t nodes() const { return zenith_rad.size() * azimuth_rad.size(); }
};

/// The maps in one direction: unit vector towards the sky, x east, y north, z up; sun azimuth clockwise from north.
/// Zero below the horizon.
std::array<double, 4> sky_value(const SkyBasis& basis, double sun_azimuth_rad, double x, double y, double z);

/// Weights q of the grid's nodes such that sum_i q_i A_i = integral of A cos(zenith) over the hemisphere, exactly, for
/// A linear between the nodes. Sum pi. Order [zenith][azimuth].
std::vector<double> cosine_weights(const SkyBasis& basis);

/// The same for the integral of A alone. Sum 2 pi.
std::vector<double> solid_angle_weights(const SkyBasis& basis);

/// Index of the cell that holds `at` and the fraction inside it; clamped to the axis.
struct Cell {
  std::size_t index = 0;
  double fraction = 0;
};
Cell find_cell(const std::vector<double>& nodes, double at);

}  // namespace raycube::plan
