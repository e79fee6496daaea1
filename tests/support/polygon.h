// Convex polygons in the plane, for areas that tests know exactly.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace raycube::test {

using Point = std::array<double, 2>;

/// Sutherland & Hodgman (1974): the part of a convex polygon with a x + b y <= c.
inline std::vector<Point> clipped(const std::vector<Point>& polygon, double a, double b, double c) {
  std::vector<Point> out;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    const double here = a * p[0] + b * p[1] - c, next = a * q[0] + b * q[1] - c;
    if (here <= 0) out.push_back(p);
    if ((here < 0 && next > 0) || (here > 0 && next < 0))
      out.push_back({p[0] + here / (here - next) * (q[0] - p[0]), p[1] + here / (here - next) * (q[1] - p[1])});
  }
  return out;
}

inline double area(const std::vector<Point>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
    twice += p[0] * q[1] - p[1] * q[0];
  }
  return std::abs(twice) / 2;
}

}  // namespace raycube::test
