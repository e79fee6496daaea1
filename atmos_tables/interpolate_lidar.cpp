#include "atmos_tables/interpolate.h"

#include <algorithm>
#include <cmath>

#include "atmos_tables/detail/row_corners.h"
#include "atmos_tables/optics/air_profile.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

using namespace detail;

constexpr const char* kNeeds = "a LIDAR profile";

/// Exponential between nodes, linear where one end is 0.
Spectrum at_height(const RenderTable& table, const Row& row, double height_m) {
  const Bracket here = bracket(table.axis("range_height"), height_m);
  const std::size_t heights = table.axis("range_height").nodes.size(), count = wavelengths(table).size();
  Spectrum out(count);
  for (std::size_t i = 0; i < count; ++i)
    out[i] = between(row.values[i * heights + here.low], row.values[i * heights + here.high], here.weight);
  return out;
}

}  // namespace

LidarAir lidar_air(const RenderTable& table, double height_m) {
  LidarAir out;
  out.extinction_molecular_per_m = at_height(table, table.need("lidar_extinction_molecular", kNeeds), height_m);
  out.extinction_aerosol_per_m = at_height(table, table.need("lidar_extinction_aerosol", kNeeds), height_m);
  out.backscatter_molecular_per_m_sr = at_height(table, table.need("lidar_backscatter_molecular", kNeeds), height_m);
  out.backscatter_aerosol_per_m_sr = at_height(table, table.need("lidar_backscatter_aerosol", kNeeds), height_m);
  out.depolarization = linear(table, table.need("lidar_depolarization", kNeeds), {{"range_height", height_m}});
  out.extinction_gas_per_m = table.has("lidar_extinction_gas")
                                 ? at_height(table, table.rows.at("lidar_extinction_gas"), height_m)
                                 : Spectrum(wavelengths(table).size(), 0.0);
  return out;
}

std::vector<double> lidar_optical_depth(const RenderTable& table, double low_m, double high_m) {
  const Axis& axis = table.axis("range_height");
  if (!(low_m <= high_m))
    throw base::Error(base::Fault::input, "LIDAR path: the lower height " + std::to_string(low_m) +
                                              " m lies above the higher one, " + std::to_string(high_m) +
                                              " m; exchange them");
  const Bracket low = bracket(axis, low_m);
  bracket(axis, high_m);  // refuses what lies above the profile
  const std::size_t heights = axis.nodes.size(), count = wavelengths(table).size();
  Spectrum out(count, 0.0);
  for (const char* name : {"lidar_extinction_molecular", "lidar_extinction_aerosol", "lidar_extinction_gas"}) {
    if (std::string(name) == "lidar_extinction_gas" && !table.has(name)) continue;
    const Row& row = table.need(name, kNeeds);
    if (heights == 1) {  // stated not to vary
      for (std::size_t i = 0; i < count; ++i) out[i] += (high_m - low_m) * row.values[i];
      continue;
    }
    for (std::size_t k = low.low; k + 1 < heights && axis.nodes[k] < high_m; ++k) {
      const double a = axis.nodes[k], b = axis.nodes[k + 1], from = std::max(a, low_m), to = std::min(b, high_m);
      if (!(to > from)) continue;
      for (std::size_t i = 0; i < count; ++i) {
        const double at_a = row.values[i * heights + k], at_b = row.values[i * heights + k + 1];
        out[i] += (to - from) *
                  mean_between(between(at_a, at_b, (from - a) / (b - a)), between(at_a, at_b, (to - a) / (b - a)));
      }
    }
  }
  return out;
}

}  // namespace raycube::atmos
