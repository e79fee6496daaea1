// Radiance in any direction: the discrete-ordinate source function integrated along the line of sight
// (Stamnes et al. 1988, section II.F), for many lines and places in one sweep through the layers. The light
// scattered once from the beam is left out here; beam_scatter.h adds it with the exact phase function.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "atmos_tables/solver/rays.h"

namespace raycube::atmos::solver {

/// Radiance of both cases of one order at every ray and place, without the beam's first scattering and
/// without the azimuth factor cos(order * azimuth).
struct OrderRadiance {
  Eigen::MatrixXd own;          ///< rays x places
  Eigen::MatrixXd from_ground;  ///< rays x places in order 0, else empty
};
OrderRadiance order_radiance(const ScaledColumn& column, const OrderSolution& solution, const Rays& rays,
                             const std::vector<Place>& places);

}  // namespace raycube::atmos::solver
