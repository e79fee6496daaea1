// Statistics of regions, band by band.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/analysis/cube.h"
#include "host/analysis/moments.h"
#include "host/analysis/regions.h"
#include "host/products/cube_statistics.h"

namespace raycube::analysis {

struct RegionStatistics {
  std::string name;
  std::uint64_t left_out = 0;  ///< pixels that do not count (Pixels::counts)
  std::vector<products::BandStatistics> band;

  std::uint64_t pixels() const { return band.empty() ? 0 : band.front().count; }
  Eigen::VectorXd mean() const;
};

/// Calls is(region, pixel) for each pixel of a stretch that lies in a region, region by region.
template <class Is>
void for_each_in(const std::vector<Region>& regions, const Pixels& pixels, const Is& is) {
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const std::vector<Span>& spans = regions[r].spans();
    auto span = std::lower_bound(spans.begin(), spans.end(), pixels.first_line,
                                 [](const Span& s, std::int64_t line) { return s.line < line; });
    for (; span != spans.end() && span->line < pixels.first_line + pixels.lines; ++span)
      for (std::int64_t x = span->first; x <= span->last; ++x)
        is(r, static_cast<std::size_t>((span->line - pixels.first_line) * pixels.samples + x));
  }
}

/// One for each region, in one pass. Throws Error(input) where no pixel of a region counts.
std::vector<RegionStatistics> region_statistics(const Cube& cube, const std::vector<Region>& regions, const Pass& pass);

/// Mean and covariance of each region, in one pass.
std::vector<Moments> region_moments(const Cube& cube, const std::vector<Region>& regions, const Pass& pass);

}  // namespace raycube::analysis
