#include "atmos_tables/solver/level_fields.h"

namespace raycube::atmos::solver {

using Eigen::MatrixXd;

LevelFields solve_levels(const std::vector<LayerMode>& layers, const MatrixXd& top, const MatrixXd& bottom) {
  const std::size_t count = layers.size();
  const Eigen::Index nodes = top.rows();
  // Below level i: up = reflect[i] down + source[i]. Across layer i: down[i+1] = carry[i] down[i] + gain[i].
  std::vector<MatrixXd> reflect(count + 1), source(count + 1), carry(count), gain(count);
  reflect[count] = MatrixXd::Zero(nodes, nodes);
  source[count] = bottom;
  const MatrixXd one = MatrixXd::Identity(nodes, nodes);
  for (std::size_t i = count; i-- > 0;) {
    const LayerMode& layer = layers[i];
    const LayerEmission emission = layer_emission(layer);
    const Eigen::PartialPivLU<MatrixXd> bounces(one - layer.reflect * reflect[i + 1]);
    MatrixXd lit = layer.reflect * source[i + 1];
    lit.col(0) += emission.down;
    carry[i] = bounces.solve(layer.transmit);
    gain[i] = bounces.solve(lit);
    reflect[i] = layer.reflect + layer.transmit * reflect[i + 1] * carry[i];
    source[i] = layer.transmit * (reflect[i + 1] * gain[i] + source[i + 1]);
    source[i].col(0) += emission.up;
  }
  LevelFields fields;
  fields.down.push_back(top);
  for (std::size_t i = 0; i < count; ++i) fields.down.push_back(carry[i] * fields.down[i] + gain[i]);
  for (std::size_t i = 0; i <= count; ++i) fields.up.push_back(reflect[i] * fields.down[i] + source[i]);
  return fields;
}

}  // namespace raycube::atmos::solver
