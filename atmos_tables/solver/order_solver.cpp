#include "atmos_tables/solver/order_solver.h"

#include <Eigen/Core>

namespace raycube::atmos::solver {

/// N: nodes of a hemisphere, or Eigen::Dynamic. Each number is instantiated in a source of its own (order_of_nodes.h):
/// matrices of fixed sizes take a compiler long, and gigabytes when they come together.
template <int N>
OrderSolution solve_with_nodes(const ScaledColumn& column, int order);

OrderSolution solve_order(const ScaledColumn& column, int order) {
  switch (column.streams) {
    case 4:
      return solve_with_nodes<2>(column, order);
    case 8:
      return solve_with_nodes<4>(column, order);
    case 16:
      return solve_with_nodes<8>(column, order);
    case 32:
      return solve_with_nodes<16>(column, order);
    default:
      return solve_with_nodes<Eigen::Dynamic>(column, order);
  }
}

}  // namespace raycube::atmos::solver
