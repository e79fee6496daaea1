#include "host/analysis/statistics.h"

#include <algorithm>

#include "host/base/error.h"

namespace raycube::analysis {
namespace {

constexpr std::size_t kMatrices_bytes = std::size_t{256} << 20;

}  // namespace

Eigen::VectorXd RegionStatistics::mean() const {
  Eigen::VectorXd out(static_cast<Eigen::Index>(band.size()));
  for (Eigen::Index b = 0; b < out.size(); ++b) out[b] = band[static_cast<std::size_t>(b)].mean;
  return out;
}

std::vector<RegionStatistics> region_statistics(const Cube& cube, const std::vector<Region>& regions,
                                                const Pass& pass) {
  std::vector<RegionStatistics> empty;
  for (const Region& region : regions)
    empty.push_back({region.name(), 0, std::vector<products::BandStatistics>(cube.bands())});
  std::vector<std::vector<RegionStatistics>> part(parts_of(cube).size(), empty);
  for_each_part(cube, pass, [&](std::size_t number, const Pixels& pixels) {
    for_each_in(regions, pixels, [&](std::size_t r, std::size_t p) {
      RegionStatistics& here = part[number][r];
      if (!pixels.counts[p]) {
        ++here.left_out;
        return;
      }
      const double* const value = pixels.at(p);
      for (std::size_t b = 0; b < pixels.bands; ++b) here.band[b].add(value[b]);
    });
  });
  std::vector<RegionStatistics> out = empty;
  for (const auto& one : part)
    for (std::size_t r = 0; r < out.size(); ++r) {
      out[r].left_out += one[r].left_out;
      for (std::size_t b = 0; b < out[r].band.size(); ++b) out[r].band[b].merge(one[r].band[b]);
    }
  for (const RegionStatistics& one : out)
    if (one.pixels() == 0)
      throw base::Error(base::Fault::input, cube.path() + ": no pixel of the region \"" + one.name +
                                                "\" has finite numbers that are not the header's ignore value");
  return out;
}

std::vector<Moments> region_moments(const Cube& cube, const std::vector<Region>& regions, const Pass& pass) {
  const std::vector<Moments> empty(regions.size(), Moments(cube.bands()));
  Pass few = pass;  // each part holds a matrix for each region
  const std::size_t size = std::max<std::size_t>(1, regions.size() * cube.bands() * cube.bands() * sizeof(double));
  few.most_parts = static_cast<int>(std::clamp<std::size_t>(kMatrices_bytes / size, 1, kMostParts));
  std::vector<std::vector<Moments>> part(parts_of(cube, few.most_parts).size(), empty);
  for_each_part(cube, few, [&](std::size_t number, const Pixels& pixels) {
    std::vector<std::vector<double>> taken(regions.size());
    for_each_in(regions, pixels, [&](std::size_t r, std::size_t p) {
      if (pixels.counts[p]) taken[r].insert(taken[r].end(), pixels.at(p), pixels.at(p) + pixels.bands);
    });
    for (std::size_t r = 0; r < regions.size(); ++r)
      part[number][r].add(taken[r].data(), taken[r].size() / pixels.bands);
  });
  std::vector<Moments> out = empty;
  for (const auto& one : part)
    for (std::size_t r = 0; r < out.size(); ++r) out[r].merge(one[r]);
  return out;
}

}  // namespace raycube::analysis
