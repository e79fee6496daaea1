#include "atmos_tables/solver/rays.h"

#include <cmath>
#include <utility>

#include "atmos_tables/solver/exp_differences.h"
#include "atmos_tables/solver/path_integrals.h"

namespace raycube::atmos::solver {

Rays make_rays(const ScaledColumn& column, bool up, std::vector<double> cosine) {
  Rays rays;
  rays.up = up;
  rays.cosine = std::move(cosine);
  const auto count = static_cast<Eigen::Index>(rays.cosine.size()),
             layers = static_cast<Eigen::Index>(column.layers.size());
  for (Eigen::MatrixXd* matrix : {&rays.slant, &rays.fade, &rays.constant, &rays.linear}) matrix->resize(count, layers);
  const bool lit = column.beam_flux > 0;
  rays.beam.resize(count, lit ? layers : 0);
  for (Eigen::Index i = 0; i < layers; ++i)
    for (Eigen::Index r = 0; r < count; ++r) {
      const double depth = column.layers[static_cast<std::size_t>(i)].depth;
      const Sight sight{rays.cosine[static_cast<std::size_t>(r)], up, depth, up ? 0.0 : depth};
      rays.slant(r, i) = depth / sight.cosine;
      rays.fade(r, i) = std::exp(-rays.slant(r, i));
      rays.constant(r, i) = sight_constant(sight);
      rays.linear(r, i) = sight_linear(sight);
      if (!lit) continue;
      const double fallen = column.beam[static_cast<std::size_t>(i)].slope * depth, slant = rays.slant(r, i);
      rays.beam(r, i) = up ? exp_mean(fallen + slant) : exp_difference(fallen, slant);
    }
  return rays;
}

}  // namespace raycube::atmos::solver
