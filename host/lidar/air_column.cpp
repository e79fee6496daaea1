#include "host/lidar/air_column.h"

#include <algorithm>
#include <cmath>

#include "atmos_tables/interpolate.h"
#include "host/base/error.h"

namespace raycube::lidar {

namespace {

constexpr double kPostSpacing_m = 20;
constexpr int kMostPosts = 4097;

}  // namespace

std::vector<double> table_wavelengths(const std::vector<SpectralNode>& nodes) {
  std::vector<double> out;
  for (const auto& node : nodes) out.push_back(node.wavelength_um);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

AirColumn make_air(const atmos::RenderTable& table, const std::vector<SpectralNode>& nodes, int lines, double low_m,
                   double high_m) {
  const auto& heights = table.axis("range_height").nodes;
  const auto& wavelengths = atmos::wavelengths(table);
  const double bottom = heights.front(), top = std::min(heights.back(), high_m);
  low_m = std::min(low_m, top - 1);
  AirColumn air;
  air.posts = std::clamp(static_cast<int>(std::ceil((top - low_m) / kPostSpacing_m)) + 1, 2, kMostPosts);
  air.z0_m = low_m;
  air.dz_m = (top - low_m) / (air.posts - 1);
  std::vector<std::size_t> place;
  for (const auto& node : nodes) {
    const auto at = std::lower_bound(wavelengths.begin(), wavelengths.end(), node.wavelength_um);
    if (at == wavelengths.end() || *at != node.wavelength_um)
      throw base::Error(base::Fault::bug, "the LIDAR table lacks a node's wavelength");
    place.push_back(static_cast<std::size_t>(at - wavelengths.begin()));
  }
  const auto posts = static_cast<std::size_t>(air.posts);
  air.depth.assign(nodes.size() * posts, 0);
  air.backscatter_per_m_sr.assign(static_cast<std::size_t>(lines) * posts, 0);
  for (std::size_t i = 0; i < posts; ++i) {
    const double z = low_m + static_cast<double>(i) * air.dz_m, before = z - air.dz_m;
    const auto here = atmos::lidar_air(table, std::clamp(z, bottom, heights.back()));
    for (std::size_t n = 0; n < nodes.size(); ++n)
      air.backscatter_per_m_sr[static_cast<std::size_t>(nodes[n].line) * posts + i] +=
          nodes[n].weight *
          (here.backscatter_molecular_per_m_sr[place[n]] + here.backscatter_aerosol_per_m_sr[place[n]]);
    if (i == 0) continue;
    const double from = std::clamp(before, bottom, heights.back()), to = std::clamp(z, bottom, heights.back());
    const auto between = atmos::lidar_optical_depth(table, from, to);
    const auto lowest = atmos::lidar_air(table, bottom);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      const std::size_t w = place[n];
      const double below =
          std::max(0.0, std::min(z, bottom) - before) *
          (lowest.extinction_molecular_per_m[w] + lowest.extinction_aerosol_per_m[w] + lowest.extinction_gas_per_m[w]);
      air.depth[n * posts + i] = air.depth[n * posts + i - 1] + between[w] + below;
    }
  }
  return air;
}

}  // namespace raycube::lidar
