// Solves one azimuth order of a column: every layer by itself (layer_solver.h), then the column's
// boundary-value problem by adding the layers from the ground up and following the light down again (block
// elimination of the discrete-ordinate system; every step inverts 1 - R R', which no depth makes singular).
#pragma once

#include "atmos_tables/solver/order_solution.h"

namespace raycube::atmos::solver {

OrderSolution solve_order(const ScaledColumn& column, int order);

}  // namespace raycube::atmos::solver
