#include "tests/support/double_trace.h"

#include <algorithm>
#include <cmath>

namespace raycube::test {
namespace {

using V = std::array<double, 3>;
constexpr double kUlp = 0x1p-24;

V sub(const V& a, const V& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
V cross(const V& a, const V& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const V& a, const V& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double norm(const V& a) { return std::sqrt(dot(a, a)); }

V map(const shared::rc_float4* m, const V& p, double w) {
  V q;
  for (int i = 0; i < 3; ++i) q[i] = double(m[i].x) * p[0] + double(m[i].y) * p[1] + double(m[i].z) * p[2] + w * m[i].w;
  return q;
}

double map_size(const shared::rc_float4* m, const V& p, double w) {
  double size = 0;
  for (int i = 0; i < 3; ++i)
    size = std::max(size,
                    std::abs(m[i].x * p[0]) + std::abs(m[i].y * p[1]) + std::abs(m[i].z * p[2]) + w * std::abs(m[i].w));
  return size;
}

}  // namespace

DoubleTest DoubleTracer::test(std::uint32_t instance, std::uint32_t primitive, const double (&origin)[3],
                              const float (&direction)[3]) const {
  const shared::Instance& placed = scene_.instances[instance];
  const shared::TriBlock& block = scene_.blocks[primitive / 16];
  const std::uint32_t lane = primitive % 16;
  V o{origin[0], origin[1], origin[2]}, d{direction[0], direction[1], direction[2]};
  double o_size = norm(o), d_size = norm(d);
  if (!(placed.flags & 1u)) {
    o_size = map_size(&placed.local_from_world_0, o, 1), d_size = map_size(&placed.local_from_world_0, d, 0);
    o = map(&placed.local_from_world_0, o, 1), d = map(&placed.local_from_world_0, d, 0);
  }
  const V a = sub({block.v0_x[lane], block.v0_y[lane], block.v0_z[lane]}, o);
  const V b = sub({block.v1_x[lane], block.v1_y[lane], block.v1_z[lane]}, o);
  const V c = sub({block.v2_x[lane], block.v2_y[lane], block.v2_z[lane]}, o);
  const V n = cross(sub(b, a), sub(c, a));
  const double nd = dot(n, d);
  DoubleTest result;
  const double u = dot(cross(b, c), d), v = dot(cross(c, a), d), w = dot(cross(a, b), d);
  if (nd == 0) return result;
  const double s = nd > 0 ? 1 : -1;
  result.t = dot(n, a) / nd;
  result.hit = s * u >= 0 && s * v >= 0 && s * w >= 0 && result.t > 0;
  // An edge function is |edge x vertex . d|: the ray's distance from the edge line is w / (|edge| |d|). Errors of the
  // moved vertices are relative to the vertex distance, those of the mapped origin and direction to the sums that made
  // them.
  const double reach = std::max({norm(a), norm(b), norm(c)});
  const double size = reach * (1 + d_size / norm(d)) + o_size;
  const auto away = [&](double edge_function, const V& edge) {
    const double length = norm(edge);
    return length == 0 ? 0 : std::abs(edge_function) / (length * norm(d)) / (kUlp * size);
  };
  result.edge_ulp = std::min({away(u, sub(c, b)), away(v, sub(a, c)), away(w, sub(b, a))});
  // t = n.a / n.d: its error relative to t grows with the obliqueness |n| |d| / |n.d|.
  result.t_ulp = norm(n) * norm(d) / std::abs(nd) * size / (norm(d) * std::max(std::abs(result.t), 1e-300));
  return result;
}

// Calls take(instance, primitive, t) for every triangle that the ray hits; the ray is mapped once per instance.
template <typename Take>
void DoubleTracer::for_hits(const double (&origin)[3], const float (&direction)[3], Take take) const {
  for (std::uint32_t i = 0; i < scene_.instances.size(); ++i) {
    const shared::Instance& placed = scene_.instances[i];
    const auto& tree = scene_.trees[placed.tree];
    V o{origin[0], origin[1], origin[2]}, d{direction[0], direction[1], direction[2]};
    if (!(placed.flags & 1u)) o = map(&placed.local_from_world_0, o, 1), d = map(&placed.local_from_world_0, d, 0);
    for (std::uint32_t p = tree.first_block * 16; p < tree.first_block * 16 + tree.triangle_count; ++p) {
      const shared::TriBlock& block = scene_.blocks[p / 16];
      const std::uint32_t lane = p % 16;
      const V a = sub({block.v0_x[lane], block.v0_y[lane], block.v0_z[lane]}, o);
      const V b = sub({block.v1_x[lane], block.v1_y[lane], block.v1_z[lane]}, o);
      const double w = dot(cross(a, b), d);
      const V c = sub({block.v2_x[lane], block.v2_y[lane], block.v2_z[lane]}, o);
      const double u = dot(cross(b, c), d);
      if (u * w < 0) continue;
      const double v = dot(cross(c, a), d);
      if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
      const V n = cross(sub(b, a), sub(c, a));
      const double nd = dot(n, d);
      if (nd == 0) continue;
      const double t = dot(n, a) / nd;
      if (t > 0) take(i, p, t);
    }
  }
}

DoubleHit DoubleTracer::closest(const double (&origin)[3], const float (&direction)[3]) const {
  DoubleHit best;
  for_hits(origin, direction, [&best](std::uint32_t i, std::uint32_t p, double t) {
    if (t < best.t) best = {t, i, p};
  });
  return best;
}

bool DoubleTracer::blocked(const double (&origin)[3], const float (&direction)[3]) const {
  bool any = false;
  for_hits(origin, direction, [&any](std::uint32_t, std::uint32_t, double) { any = true; });
  return any;
}

DoubleTracer::Verdict DoubleTracer::judge(const DoubleHit& truth, std::uint32_t instance, std::uint32_t primitive,
                                          const double (&origin)[3], const float (&direction)[3],
                                          double bound_ulp) const {
  if (truth.instance == instance && truth.primitive == primitive) return Verdict::same;
  // The kernel's own hit must be a hit within rounding.
  double kernel_t = 1e300, kernel_bound = 0;
  if (instance != RC_NONE) {
    const DoubleTest own = test(instance, primitive, origin, direction);
    if (!own.hit && own.edge_ulp > bound_ulp) return Verdict::wrong;
    kernel_t = own.t, kernel_bound = bound_ulp * own.t_ulp * kUlp * std::abs(own.t);
  }
  if (truth.instance == RC_NONE) return Verdict::explained;
  // A hit by rounding in front of the true one; else the true hit must be one that rounding can lose, or lie as deep as
  // the kernel's within rounding.
  const DoubleTest lost = test(truth.instance, truth.primitive, origin, direction);
  const double bound = kernel_bound + bound_ulp * lost.t_ulp * kUlp * std::abs(lost.t);
  return kernel_t <= lost.t + bound || lost.edge_ulp <= bound_ulp ? Verdict::explained : Verdict::wrong;
}

}  // namespace raycube::test
