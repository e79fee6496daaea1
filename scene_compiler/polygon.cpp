#include "scene_compiler/polygon.h"

#include <cmath>
#include <numeric>

namespace raycube::scene {
namespace {

using Point = std::array<double, 2>;

double cross(const Point& a, const Point& b, const Point& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Drops the largest component of the Newell normal, keeping the turn counter-clockwise.
std::vector<Point> project(std::span<const std::array<double, 3>> corners) {
  std::array<double, 3> normal{};
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto &a = corners[i], &b = corners[(i + 1) % corners.size()];
    for (int k = 0; k < 3; ++k) {
      const int u = (k + 1) % 3, v = (k + 2) % 3;
      normal[static_cast<std::size_t>(k)] += (a[u] - b[u]) * (a[v] + b[v]);
    }
  }
  int drop = 2;
  for (int k = 0; k < 3; ++k)
    if (std::abs(normal[k]) > std::abs(normal[drop])) drop = k;
  const int u = (drop + 1) % 3, v = (drop + 2) % 3;
  const double sense = normal[drop] < 0 ? -1 : 1;
  std::vector<Point> out;
  for (const auto& corner : corners) out.push_back({sense * corner[u], corner[v]});
  return out;
}

bool inside(const Point& p, const Point& a, const Point& b, const Point& c) {
  return cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> triangulate_polygon(std::span<const std::array<double, 3>> corners) {
  std::vector<std::array<std::uint32_t, 3>> out;
  if (corners.size() < 3) return out;
  if (corners.size() == 3) return {{0, 1, 2}};
  const auto points = project(corners);
  std::vector<std::uint32_t> ring(corners.size());
  std::iota(ring.begin(), ring.end(), 0u);
  while (ring.size() > 3) {
    std::size_t ear = ring.size();
    // From the second corner on, so that a convex polygon becomes the usual fan about its first corner.
    for (std::size_t step = 1; step <= ring.size() && ear == ring.size(); ++step) {
      const std::size_t i = step % ring.size();
      const auto a = ring[(i + ring.size() - 1) % ring.size()], b = ring[i], c = ring[(i + 1) % ring.size()];
      if (cross(points[a], points[b], points[c]) <= 0) continue;
      bool empty = true;
      for (const auto other : ring) {
        if (other == a || other == b || other == c) continue;
        const auto& p = points[other];
        if (p == points[a] || p == points[b] || p == points[c]) continue;  // bridges repeat corners
        if (inside(p, points[a], points[b], points[c])) {
          empty = false;
          break;
        }
      }
      if (empty) ear = i;
    }
    if (ear == ring.size()) ear = 1;  // no ear left: not a simple polygon; clip on so that every corner is used
    const auto n = ring.size();
    out.push_back({ring[(ear + n - 1) % n], ring[ear], ring[(ear + 1) % n]});
    ring.erase(ring.begin() + static_cast<long>(ear));
  }
  out.push_back({ring[0], ring[1], ring[2]});
  return out;
}

}  // namespace raycube::scene
