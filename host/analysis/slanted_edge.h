// Resolution from a slanted edge: edge spread, line spread and modulation transfer of each band (docs/analysis.md).
#pragma once

#include <string>
#include <vector>

#include "host/analysis/cube.h"
#include "host/analysis/regions.h"

namespace raycube::analysis {

/// Bins of a pixel in which the edge spread is told.
inline constexpr int kEdgeBins = 4;

struct EdgeSpread {
  std::vector<double> at_px;           ///< of the bins' middles, from the edge, along its normal
  std::vector<double> spread;          ///< edge spread, from about 0 to about 1
  std::vector<double> line;            ///< its derivative, sum 1
  double angle_deg = 0;                ///< of the edge from the column or row of pixels that it is nearest to
  double low = 0, high = 0;            ///< levels on both sides
  std::vector<double> frequency, mtf;  ///< cycles per pixel along the normal, to 1; MTF is 1 at 0
  double mtf_nyquist = 0;              ///< at 0.5 cycles per pixel
  double mtf50 = 0;                    ///< frequency at which it falls to 0.5; NaN: it does not
  double fwhm_px = 0;                  ///< width of the line spread at half its maximum
};

/// One for each band of the cube, of a rectangular region with one straight edge through it that leaves by two opposite
/// sides. Edge and angle as ISO 12233 (2017), annex D, finds them: a line through the rows' centroids. The transfer is
/// that of the pixels themselves, by their distances from the edge, and of straight lines between one and the next:
/// means over quarter pixels, as the standard takes them, err by 0.04 where phases come unevenly. Pixels that do not
/// count, Error(input), and so are: a region that is no rectangle or narrower than 8 pixels, no edge (a step below 1e-6
/// of the level), one within 0.5 degrees of the pixels' rows and columns or past 40, rows too few or of
/// phases that repeat, so that pixels are more than 0.15 apart along the normal.
std::vector<EdgeSpread> slanted_edge(const Cube& cube, const Region& region);

/// The same of one band's numbers, rows by columns.
EdgeSpread slanted_edge(const std::vector<double>& value, std::size_t rows, std::size_t columns,
                        const std::string& what);

}  // namespace raycube::analysis
