#include "atmos_tables/solver/path_integrals.h"

#include <cmath>

#include "atmos_tables/solver/exp_differences.h"

namespace raycube::atmos::solver {

double sight_falling(const Sight& sight, double rate) {
  const double seen = sight.seen_depth(), slope = 1 / sight.cosine;
  if (sight.up) return std::exp(-rate * sight.u_near) * seen * slope * exp_mean((rate + slope) * seen);
  return seen * slope * exp_difference(rate * seen, slope * seen);
}

double sight_rising(const Sight& sight, double rate) {
  const double seen = sight.seen_depth(), slope = 1 / sight.cosine;
  if (sight.up) return seen * slope * exp_difference(rate * seen, slope * seen);
  return std::exp(-rate * (sight.depth - sight.u_near)) * seen * slope * exp_mean((rate + slope) * seen);
}

double sight_difference(const Sight& sight, double first, double second) {
  const double seen = sight.seen_depth(), slope = 1 / sight.cosine;
  if (!sight.up) return seen * seen * slope * exp_difference(first * seen, second * seen, slope * seen);
  // D(u_near + w) = exp(-first u_near) D(w) + exp(-second w) D(u_near)
  const double at_near = sight.u_near * exp_difference(first * sight.u_near, second * sight.u_near);
  return std::exp(-first * sight.u_near) * seen * seen * slope *
             exp_difference(0, (first + slope) * seen, (second + slope) * seen) +
         at_near * seen * slope * exp_mean((second + slope) * seen);
}

double sight_constant(const Sight& sight) { return -std::expm1(-sight.seen_depth() / sight.cosine); }

double sight_linear(const Sight& sight) {
  const double y = sight.seen_depth() / sight.cosine;
  if (sight.up) return sight.u_near * sight_constant(sight) + sight.cosine * y * y * exp_difference(0, y, y);
  return sight.cosine * y * y * exp_difference(0, 0, y);
}

}  // namespace raycube::atmos::solver
