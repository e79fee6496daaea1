#include "host/study/pareto.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace raycube::study {

std::vector<std::size_t> pareto_front(const std::vector<Cost>& points) {
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].time) && std::isfinite(points[i].error)) order.push_back(i);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::tie(points[a].time, points[a].error, a) < std::tie(points[b].time, points[b].error, b);
  });
  std::vector<std::size_t> front;
  double best = std::numeric_limits<double>::infinity();
  for (const std::size_t i : order)
    if (points[i].error < best) front.push_back(i), best = points[i].error;
  return front;
}

}  // namespace raycube::study
