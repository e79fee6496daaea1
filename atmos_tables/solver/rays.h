// Lines of sight of one side (all up or all down) through the layers, and what of them depends on no azimuth
// order.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "atmos_tables/solver/order_solution.h"

namespace raycube::atmos::solver {

/// A place in the column.
struct Place {
  std::size_t layer = 0;  ///< index; 0 in a column without layers
  double u = 0;           ///< scaled optical depth below the layer's top
};

struct Rays {
  bool up = true;
  std::vector<double> cosine;  ///< (0, 1]
  // Rows: rays. Columns: layers. All of whole layers.
  Eigen::MatrixXd slant;     ///< depth / cosine
  Eigen::MatrixXd fade;      ///< exp(-slant)
  Eigen::MatrixXd constant;  ///< sight_constant (path_integrals.h)
  Eigen::MatrixXd linear;    ///< sight_linear
  Eigen::MatrixXd beam;      ///< sight_falling at the beam's slope, over slant; no columns where there is no beam
};

Rays make_rays(const ScaledColumn& column, bool up, std::vector<double> cosine);

/// Calls pass(layer) for each layer in the order of the light's travel, and before(place index) or
/// inside(place index, layer) once per place: before a layer that the light has not entered yet at the place
/// (or after the last), inside where the place lies within the layer, ahead of pass(layer).
template <class Before, class Inside, class Pass>
void travel(const ScaledColumn& column, bool up, const std::vector<Place>& places, Before&& before, Inside&& inside,
            Pass&& pass) {
  const std::size_t count = column.layers.size();
  std::size_t left = places.size();
  for (std::size_t step = 0; step < count && left > 0; ++step) {
    const std::size_t i = up ? count - 1 - step : step;
    const double depth = column.layers[i].depth;
    for (std::size_t p = 0; p < places.size(); ++p) {
      if (places[p].layer != i) continue;
      const bool at_top = places[p].u <= 0, at_bottom = places[p].u >= depth;
      if (up ? at_bottom : at_top && !at_bottom) {
        before(p);
        --left;
      } else if (!at_top && !at_bottom) {
        inside(p, i);
        --left;
      }
    }
    if (left == 0) return;
    pass(i);
    for (std::size_t p = 0; p < places.size(); ++p) {
      if (places[p].layer != i) continue;
      const bool at_top = places[p].u <= 0, at_bottom = places[p].u >= depth;
      if (up ? at_top && !at_bottom : at_bottom) {
        before(p);
        --left;
      }
    }
  }
  if (count == 0)
    for (std::size_t p = 0; p < places.size(); ++p) before(p);
}

}  // namespace raycube::atmos::solver
