// How many nodes each continuous quantity gets: the cheapest counts whose linear interpolation error, as a share of the
// band's scene-typical radiance, fits the tolerance and the channel limit.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "host/plan/plan.h"

namespace raycube::plan {

/// A quantity at equidistant positions of one axis, already averaged over bands and divided by each band's typical
/// radiance. Several lines (at other places of the remaining axes, or of several sources) are judged together.
struct Line {
  std::vector<std::vector<double>> value;  ///< [position][band]
  std::vector<char> counts;                ///< position lies inside the view; nodes may stand on others
};

/// Positions on a sampled axis: 0, 1/12, ... 1; counts whose nodes and cell midpoints lie on it.
inline constexpr int kLinePositions = 13;
inline constexpr std::array<int, 6> kNodeCounts = {1, 2, 3, 4, 5, 7};

/// Error of linear interpolation for each of kNodeCounts: rms over the positions that count, as DESIGN 5a has the
/// tolerance, largest over lines and bands. One node stands mid-range and is judged by its largest error: pixels may
/// crowd at one end, where two and more nodes are exact.
std::array<double, kNodeCounts.size()> node_errors(const std::vector<Line>& lines);

/// Errors per axis and count (index into kNodeCounts), and of the sky's rank 1..4.
struct NodeErrors {
  std::array<double, kNodeCounts.size()> source_height{}, source_view{}, path_height{}, path_x{}, path_y{};
  std::vector<double> sky_rank;  ///< [rank - 1], allowed ranks only finite; empty: no sky
  // Beside sunlight: sources that are there anyway, and levels of the thermal ones
  int lamps = 0;                                    ///< sources
  int sun_sources = 1;                              ///< 0: left out
  int surroundings = 0;                             ///< 1 with thermal light
  double left_out = 0;                              ///< error of leaving out sun and sky where they are dark
  std::vector<double> thermal_rank;                 ///< [rank - 1]; empty: no thermal sky
  std::vector<std::pair<int, double>> temperature;  ///< (nodes, error) of each level; empty: nothing emits
};

struct NodeChoice {
  int height = 1, view = 1, path_x = 1, path_y = 1;
  int sky_rank = 0, thermal_rank = 0;
  std::size_t temperature = 0;                             ///< level chosen
  double emission_error = 0, left_out = 0;                 ///< of temperature nodes; of a dark sun and sky
  double source_error = 0, path_error = 0, sky_error = 0;  ///< sums over the axes
  double total() const { return source_error + path_error + sky_error + emission_error + left_out; }
  bool within_budget = true;  ///< total() <= budget
  bool possible = false;
};

/// Cheapest counts whose total error fits `budget`; where RC_MAX_CHANNELS or the sky forbid that, the smallest total
/// error. `given`: counts that are not for us to choose; when they leave nothing, `possible` is false.
NodeChoice choose_nodes(const NodeErrors& errors, double budget, const scene::PlanOverrides& given = {});

/// Uniform axis of `count` nodes over lo..hi; one node stands in the middle. Degenerate ranges get one node.
NodeAxis make_axis(double lo, double hi, int count);

/// Position of a node, from the floats that the kernels use.
double node_position(const NodeAxis& axis, int index);

}  // namespace raycube::plan
