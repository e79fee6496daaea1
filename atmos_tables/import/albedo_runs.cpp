#include "atmos_tables/import/albedo_runs.h"

#include <algorithm>

namespace raycube::atmos::imported {

GroundCoupling coupling_of_three_runs(double radiance_0, double radiance_1, double radiance_2, double r1, double r2) {
  const double d1 = radiance_1 - radiance_0, d2 = radiance_2 - radiance_0;
  if (!(d1 > 0) || !(d2 > d1)) return {0, std::max(0.0, r1 > 0 ? d1 / r1 : 0.0)};
  const double s = std::clamp((d2 / r2 - d1 / r1) / (d2 - d1), 0.0, 1.0);
  return {s, d1 * (1 / r1 - s)};
}

}  // namespace raycube::atmos::imported
