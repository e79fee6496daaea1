// The column's boundary-value problem, solved by adding the layers from the ground up and following the light
// down again (block elimination of the discrete-ordinate system; every step inverts 1 - R R', which no depth
// makes singular).
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "atmos_tables/solver/layer_modes.h"

namespace raycube::atmos::solver {

/// sqrt(w mu) I at every level, upward and downward. One column per lighting case.
struct LevelFields {
  std::vector<Eigen::MatrixXd> up, down;  ///< [level], nodes x cases
};

/// top, bottom: light that enters at the top and at the ground, nodes x cases. The layers' own sources belong
/// to case 0 alone. The ground reflects nothing.
LevelFields solve_levels(const std::vector<LayerMode>& layers, const Eigen::MatrixXd& top,
                         const Eigen::MatrixXd& bottom);

}  // namespace raycube::atmos::solver
