#include "atmos_tables/solver/order_of_nodes.h"

namespace raycube::atmos::solver {

template OrderSolution solve_with_nodes<Eigen::Dynamic>(const ScaledColumn& column, int order);

}  // namespace raycube::atmos::solver
