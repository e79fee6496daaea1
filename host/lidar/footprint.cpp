#include "host/lidar/footprint.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace raycube::lidar {

namespace {

constexpr double kGoldenAngle = M_PI * (3.0 - 2.2360679774997896964);

struct Point {
  double a = 0, b = 0;
};

/// Point i of n of the beam's profile; `turn` tells one spiral from another.
Point spiral(scene::BeamProfile profile, int i, int n, double turn) {
  if (n == 1) return {};
  const double u = (i + 0.5) / n;
  const double radius = profile == scene::BeamProfile::gaussian ? std::sqrt(-0.5 * std::log1p(-u)) : std::sqrt(u);
  return {radius * std::cos(i * kGoldenAngle + turn), radius * std::sin(i * kGoldenAngle + turn)};
}

double fraction(double x) { return x - std::floor(x); }

/// Cuts first..last by the longer side of its bounds until runs of 16 are left: neighbours stay together for the
/// kernel's culling.
void sort_compact(const std::vector<Point>& points, std::vector<int>::iterator first, std::vector<int>::iterator last) {
  const auto count = last - first;
  if (count <= 16) return;
  Point lo{1e30, 1e30}, hi{-1e30, -1e30};
  for (auto i = first; i != last; ++i) {
    const Point& p = points[static_cast<std::size_t>(*i)];
    lo = {std::min(lo.a, p.a), std::min(lo.b, p.b)};
    hi = {std::max(hi.a, p.a), std::max(hi.b, p.b)};
  }
  const bool along_a = hi.a - lo.a >= hi.b - lo.b;
  const auto runs = (count + 15) / 16;
  const auto middle = first + (runs + 1) / 2 * 16;
  std::nth_element(first, middle, last, [&](int i, int j) {
    const Point &p = points[static_cast<std::size_t>(i)], &q = points[static_cast<std::size_t>(j)];
    const double x = along_a ? p.a : p.b, y = along_a ? q.a : q.b;
    return x != y ? x < y : i < j;
  });
  sort_compact(points, first, middle);
  sort_compact(points, middle, last);
}

}  // namespace

Footprint make_footprint(const scene::Lidar& lidar, bool distributed, std::array<double, 2> shift) {
  const int n = lidar.transport.subrays;
  const bool receiver = lidar.transport.sampling == scene::LidarSampling::receiver;
  std::vector<Point> points, exits;
  for (int i = 0; i < n; ++i) {
    // R2 sequence: Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018; 1/g and 1/g^2, g^3 = g +
    // 1.
    points.push_back(receiver ? Point{fraction(0.5 + shift[0] + i * 0.7548776662466927) - 0.5,
                                      fraction(0.5 + shift[1] + i * 0.5698402909980532) - 0.5}
                              : spiral(lidar.pulse.profile, i, n, 0));
    // Exits take the spiral's rings in the order of a van der Corput-like walk, so that place and direction do not go
    // together.
    const int ring = static_cast<int>(fraction((i + 0.5) * 0.6180339887498949) * n);
    // A uniform beam stays a disc of radius exit + divergence x range: rays leave where they go.
    if (distributed && !receiver)
      exits.push_back(lidar.pulse.profile == scene::BeamProfile::uniform
                          ? points.back()
                          : spiral(lidar.pulse.profile, ring, n, 1.0 + 2.399963 * i));
  }
  std::vector<int> order(static_cast<std::size_t>(n));
  std::iota(order.begin(), order.end(), 0);
  sort_compact(points, order.begin(), order.end());
  Footprint out;
  for (const int i : order) {
    const auto k = static_cast<std::size_t>(i);
    out.a.push_back(static_cast<float>(points[k].a));
    out.b.push_back(static_cast<float>(points[k].b));
    if (exits.empty()) continue;
    out.exit_a.push_back(static_cast<float>(exits[k].a));
    out.exit_b.push_back(static_cast<float>(exits[k].b));
  }
  return out;
}

bool exit_matters(const scene::Lidar& lidar) {
  if (lidar.transport.sampling == scene::LidarSampling::receiver || lidar.pulse.exit_radius_m == 0) return false;
  const double nearest_m =
      std::max(lidar.transport.minimum_range_m, 0.5 * 299792458.0 * lidar.gate.start_s / lidar.transport.group_index);
  return lidar.pulse.exit_radius_m > 0.02 * std::tan(lidar.pulse.half_divergence_rad) * nearest_m;
}

}  // namespace raycube::lidar
