#include "atmos_tables/detail/lit_factor.h"

#include <limits>

#include "atmos_tables/interpolate.h"

namespace raycube::atmos::detail {

std::vector<double> lit_two_way_factor(const RenderTable& table, double height_m, double zenith_deg) {
  constexpr double kLeast = 1e-3;
  auto out = two_way_factor(table, height_m, zenith_deg);
  const auto sun = sun_transmission(table, height_m), view = view_transmission(table, height_m, zenith_deg);
  for (std::size_t i = 0; i < out.size(); ++i)
    if (!(sun[i] * view[i] > kLeast)) out[i] = std::numeric_limits<double>::quiet_NaN();
  return out;
}

}  // namespace raycube::atmos::detail
