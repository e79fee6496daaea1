#include "host/reference/contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raycube::reference {

namespace {

glm::dvec3 row(const shared::rc_float4& r) { return {r.x, r.y, r.z}; }

}  // namespace

LocalRay to_local(const shared::Instance& instance, const DoubleRay& ray) {
  const double direction_length = glm::length(ray.direction);
  if (instance.flags & 1u)
    return {ray.origin, ray.direction, ray.origin_slack_m, kDirectionUlp * kUlp * direction_length};
  const glm::dvec3 r0 = row(instance.local_from_world_0), r1 = row(instance.local_from_world_1),
                   r2 = row(instance.local_from_world_2);
  const glm::dvec3 translation(instance.local_from_world_0.w, instance.local_from_world_1.w,
                               instance.local_from_world_2.w);
  const double norm = std::sqrt(glm::dot(r0, r0) + glm::dot(r1, r1) + glm::dot(r2, r2));  // Frobenius, >= the 2-norm
  const auto apply = [&](const glm::dvec3& v) { return glm::dvec3(glm::dot(r0, v), glm::dot(r1, v), glm::dot(r2, v)); };
  LocalRay local;
  local.origin = apply(ray.origin) + translation;
  local.direction = apply(ray.direction);
  local.origin_error_m =
      kTransformUlp * kUlp * (norm * glm::length(ray.origin) + glm::length(translation)) + norm * ray.origin_slack_m;
  local.direction_error = (kTransformUlp + kDirectionUlp) * kUlp * norm * direction_length;
  return local;
}

glm::dvec3 vertex(const scene::CompiledScene& scene, std::uint32_t primitive, int corner) {
  const shared::TriBlock& block = scene.blocks[primitive / RC_BLOCK];
  const std::uint32_t lane = primitive % RC_BLOCK;
  if (corner == 0) return {block.v0_x[lane], block.v0_y[lane], block.v0_z[lane]};
  if (corner == 1) return {block.v1_x[lane], block.v1_y[lane], block.v1_z[lane]};
  return {block.v2_x[lane], block.v2_y[lane], block.v2_z[lane]};
}

Contact contact(const scene::CompiledScene& scene, std::uint32_t primitive, const LocalRay& ray) {
  const glm::dvec3 corners[3] = {vertex(scene, primitive, 0) - ray.origin, vertex(scene, primitive, 1) - ray.origin,
                                 vertex(scene, primitive, 2) - ray.origin};
  const glm::dvec3& d = ray.direction;
  const double d_length = glm::length(d);
  double farthest = 0;
  for (const glm::dvec3& corner : corners) farthest = std::max(farthest, glm::length(corner));
  // Each vertex may lie this far from where the exact arithmetic has it.
  const double vertex_error = kVertexUlp * kUlp * farthest + ray.origin_error_m;

  Contact result;
  bool any_above = false, any_below = false, all_above = true, all_below = true, all_positive = true,
       all_negative = true;
  double sum = 0, sum_bound = 0;
  result.edge_ulp = std::numeric_limits<double>::infinity();
  for (int edge = 0; edge < 3; ++edge) {
    const glm::dvec3 &p = corners[(edge + 1) % 3], &q = corners[(edge + 2) % 3];
    // d . (e x s) with e = q - p, s = p + q is 2 d . (p x q): the same for both triangles of an edge but for its sign.
    const double value = 2 * glm::dot(d, glm::cross(p, q));
    const double moved =
        2 * vertex_error * (glm::length(glm::cross(p, d)) + glm::length(glm::cross(q, d)) + vertex_error * d_length);
    const double e_s = glm::length(q - p) * glm::length(p + q);
    const double bound = moved + kEdgeUlp * kUlp * d_length * e_s + ray.direction_error * e_s;
    any_above |= value > bound;
    any_below |= value < -bound;
    all_above &= value >= bound;
    all_below &= value <= -bound;
    all_positive &= value >= 0;
    all_negative &= value <= 0;
    sum += value;
    sum_bound += bound;
    if (bound > 0) result.edge_ulp = std::min(result.edge_ulp, std::abs(value) / bound);
  }
  if (any_above && any_below) return result;  // outside for either winding
  result.side = all_above || all_below ? Side::inside : Side::uncertain;
  const glm::dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
  const double denominator = glm::dot(d, normal);  // = sum / 2
  result.grazing = std::abs(sum) <= sum_bound;
  if (denominator == 0) {
    // Edge-on to the last bit, or no area: never a hit in any arithmetic that divides; possible anywhere on its span.
    result.grazing = true;
    result.t = glm::dot(corners[0], d) / (d_length * d_length);
    result.t_bound = std::numeric_limits<double>::infinity();
    if (glm::length(normal) == 0) result.side = Side::outside;
    return result;
  }
  result.t = glm::dot(corners[0], normal) / denominator;
  result.hit = (all_positive || all_negative) && result.t >= 0;
  result.t_bound = result.grazing ? std::numeric_limits<double>::infinity()
                                  : vertex_error * glm::length(normal) / std::abs(denominator) +
                                        kDepthUlp * kUlp * std::abs(result.t);
  return result;
}

glm::dvec3 world_normal(const scene::CompiledScene& scene, const Hit& hit) {
  const glm::dvec3 v0 = vertex(scene, hit.primitive, 0);
  const glm::dvec3 n = glm::cross(vertex(scene, hit.primitive, 1) - v0, vertex(scene, hit.primitive, 2) - v0);
  const shared::Instance& instance = scene.instances[hit.instance];
  if (instance.flags & 1u) return glm::normalize(n);
  return glm::normalize(row(instance.local_from_world_0) * n.x + row(instance.local_from_world_1) * n.y +
                        row(instance.local_from_world_2) * n.z);
}

}  // namespace raycube::reference
