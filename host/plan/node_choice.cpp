#include "host/plan/node_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raycube::plan {

std::array<double, kNodeCounts.size()> node_errors(const std::vector<Line>& lines) {
  constexpr int steps = kLinePositions - 1;
  std::array<double, kNodeCounts.size()> error{};
  for (std::size_t c = 0; c < kNodeCounts.size(); ++c) {
    const int count = kNodeCounts[c];
    for (const Line& line : lines) {
      std::vector<double> squares(line.value.front().size(), 0.0), largest = squares;
      int counted = 0;
      for (int p = 0; p <= steps; ++p) {
        if (!line.counts[static_cast<std::size_t>(p)]) continue;
        ++counted;
        int a = steps / 2, b = steps / 2;
        double t = 0;
        if (count > 1) {
          const int width = steps / (count - 1);
          a = std::min(p / width, count - 2) * width;
          b = a + width;
          t = static_cast<double>(p - a) / width;
        }
        const auto &here = line.value[static_cast<std::size_t>(p)], &low = line.value[static_cast<std::size_t>(a)],
                   &high = line.value[static_cast<std::size_t>(b)];
        for (std::size_t k = 0; k < here.size(); ++k) {
          const double difference = std::abs(here[k] - (1 - t) * low[k] - t * high[k]);
          squares[k] += difference * difference;
          largest[k] = std::max(largest[k], difference);
        }
      }
      for (std::size_t k = 0; k < squares.size() && counted > 0; ++k)
        error[c] = std::max(error[c], count == 1 ? largest[k] : std::sqrt(squares[k] / counted));
    }
  }
  return error;
}

NodeChoice choose_nodes(const NodeErrors& errors, double budget, const scene::PlanOverrides& given) {
  const auto allowed = [](int wanted, std::size_t count) { return wanted == 0 || wanted == kNodeCounts[count]; };
  const int most_rank = static_cast<int>(errors.sky_rank.size()), wanted_rank = std::min(given.sky_rank, most_rank);
  const bool sky = !errors.sky_rank.empty();
  NodeChoice best;
  int best_cost = std::numeric_limits<int>::max();
  bool& found = best.possible;
  // Levels of thermal light: one that costs nothing where there is none.
  struct Level {
    int rank;
    std::size_t temperature;
    int nodes;
    double sky_error, emission_error;
  };
  std::vector<Level> levels;
  for (std::size_t rank = errors.thermal_rank.empty() ? 0 : 1; rank <= errors.thermal_rank.size(); ++rank)
    for (std::size_t t = 0; t < std::max<std::size_t>(1, errors.temperature.size()); ++t) {
      const auto [nodes, error] = errors.temperature.empty() ? std::pair{0, 0.0} : errors.temperature[t];
      levels.push_back({static_cast<int>(rank), t, nodes, rank > 0 ? errors.thermal_rank[rank - 1] : 0, error});
    }
  for (const Level& level : levels)
    for (std::size_t rank = sky ? 1 : 0; rank <= errors.sky_rank.size(); ++rank) {
      const double sky_error = (sky ? errors.sky_rank[rank - 1] : 0) + level.sky_error;
      if (!std::isfinite(sky_error) || (wanted_rank > 0 && static_cast<int>(rank) != wanted_rank)) continue;
      for (std::size_t h = 0; h < kNodeCounts.size(); ++h)
        for (std::size_t v = 0; v < kNodeCounts.size(); ++v)
          for (std::size_t x = 0; x < kNodeCounts.size(); ++x)
            for (std::size_t y = 0; y < kNodeCounts.size(); ++y) {
              if (!allowed(given.height_nodes, h) || !allowed(given.view_nodes, v) || !allowed(given.path_nodes, x) ||
                  !allowed(given.path_nodes, y))
                continue;
              const int sources =
                  errors.sun_sources + static_cast<int>(rank) + level.rank + errors.surroundings + errors.lamps;
              const int source = sources * kNodeCounts[h] * kNodeCounts[v],
                        emission = level.nodes * kNodeCounts[h] * kNodeCounts[v];
              const int path = kNodeCounts[h] * kNodeCounts[x] * kNodeCounts[y];
              if (source > RC_MAX_CHANNELS || emission > RC_MAX_CHANNELS || path > RC_MAX_CHANNELS) continue;
              NodeChoice choice;
              choice.height = kNodeCounts[h], choice.view = kNodeCounts[v];
              choice.path_x = kNodeCounts[x], choice.path_y = kNodeCounts[y];
              choice.sky_rank = static_cast<int>(rank), choice.thermal_rank = level.rank,
              choice.temperature = level.temperature;
              choice.source_error = errors.source_height[h] + errors.source_view[v];
              choice.path_error = errors.path_height[h] + errors.path_x[x] + errors.path_y[y];
              choice.sky_error = sky_error, choice.emission_error = level.emission_error,
              choice.left_out = errors.left_out;
              choice.within_budget = choice.total() <= budget;
              const int cost = 4 * (source + emission) + path;  // material rows are many, the path row is one
              bool better = !found;
              if (found && choice.within_budget != best.within_budget)
                better = choice.within_budget;
              else if (found && choice.within_budget)
                better = cost < best_cost || (cost == best_cost && choice.total() < best.total());
              else if (found)
                better = choice.total() < best.total();
              if (!better) continue;
              best = choice;
              found = true;
              best_cost = cost;
            }
    }
  return best;
}

NodeAxis make_axis(double lo, double hi, int count) {
  if (!(hi > lo)) count = 1;
  if (count == 1) return {static_cast<float>(0.5 * (lo + hi)), 1.0f, 1};
  return {static_cast<float>(lo), static_cast<float>((hi - lo) / (count - 1)), count};
}

double node_position(const NodeAxis& axis, int index) {
  return static_cast<double>(axis.first) + static_cast<double>(axis.step) * index;
}

}  // namespace raycube::plan
