#include "host/reference/lidar_tracer.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/reference/sampled_pixel.h"
#include "scene_compiler/matter.h"

namespace raycube::reference {

namespace {

/// One ulp of the sizes that a ray's origin on this triangle is rounded relative to, m (as
/// ReferenceScene::point_ulp_m).
double ulp_at(const scene::CompiledScene& scene, const Hit& hit, const glm::dvec3& point) {
  const shared::Instance& placed = scene.instances[hit.instance];
  const shared::rc_float4 rows[3] = {placed.world_from_local_0, placed.world_from_local_1, placed.world_from_local_2};
  const glm::dvec3 translation(rows[0].w, rows[1].w, rows[2].w);
  double corner = 0;
  for (int i = 0; i < 3; ++i) {
    const glm::dvec3 v = vertex(scene, hit.primitive, i);
    glm::dvec3 world = translation;
    for (int r = 0; r < 3; ++r) world[r] += rows[r].x * v.x + rows[r].y * v.y + rows[r].z * v.z;
    corner = std::max(corner, glm::length(world - point));
  }
  return kUlp * (glm::length(point) + glm::length(translation) + corner);
}

}  // namespace

std::pair<double, double> LidarTracer::inside(const glm::dvec3& origin, const glm::dvec3& direction, double from_m,
                                              double to_m) const {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  double enter = from_m, leave = to_m;
  for (int axis = 0; axis < 3; ++axis) {
    const double low = scene_.lo[static_cast<std::size_t>(axis)], high = scene_.hi[static_cast<std::size_t>(axis)];
    if (low > high) return {kNone, 0};
    const double pad = 1e-3 + 1e-6 * std::max(std::abs(low), std::abs(high));
    const double below = low - pad - origin[axis], above = high + pad - origin[axis];
    if (direction[axis] == 0) {
      if (below > 0 || above < 0) return {kNone, 0};
      continue;
    }
    enter = std::max(enter, std::min(below / direction[axis], above / direction[axis]));
    leave = std::min(leave, std::max(below / direction[axis], above / direction[axis]));
  }
  return {enter <= leave ? enter : kNone, leave};
}

std::optional<LidarHit> LidarTracer::next(const glm::dvec3& origin, const glm::dvec3& direction, double from_m,
                                          double to_m, const Hit& leaving, const glm::dvec3& lift_m) const {
  auto [enter, leave] = inside(origin, direction, from_m, to_m);
  const std::array<float, 3> way = rounded(direction);
  for (int skipped = 0; skipped < 8 && enter <= leave; ++skipped) {
    // A little beyond the end, for the plane decides in double.
    const double reach = (leave - enter) * (1 + 1e-6) + 1e-6;
    const Hit hit = embree_.intersect({rounded(origin + lift_m + enter * direction), way}, static_cast<float>(reach));
    if (hit.miss()) return {};
    const double t = contact(scene_, hit.primitive, to_local(scene_.instances[hit.instance], {origin, direction, 0})).t;
    const glm::dvec3 point = origin + t * direction;
    const double clear_m = kOffsetUlp * ulp_at(scene_, hit, point);
    glm::dvec3 normal = world_normal(scene_, hit);
    double cosine = -glm::dot(normal, direction);
    if (cosine < 0) normal = -normal, cosine = -cosine;
    if (hit == leaving) {
      enter = std::max(enter, t) + clear_m / std::max(cosine, 1e-3);
      continue;
    }
    if (!(t <= to_m)) return {};
    return LidarHit{hit, t, point, normal, scene::surface_of(scene_, hit.primitive), clear_m};
  }
  return {};
}

}  // namespace raycube::reference
