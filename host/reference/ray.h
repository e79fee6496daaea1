// The fp32 rays that device and reference share bit for bit, and the hit that both report.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>

#include <glm/vec3.hpp>
#include <glm/geometric.hpp>

#include "kernels/shared/structs.h"

namespace raycube::reference {

/// Origin (m, scene frame) and direction as the device holds them: not normalised, so a hit lies at origin + offset + t
/// direction. The offset of camera rays that start ahead of the sensor is small, and its sum with the origin is not
/// rounded.
struct Ray {
  std::array<float, 3> origin{}, direction{}, offset{};
};

/// A first hit by name: placed tree and primitive = block * 16 + lane. RC_NONE in both: a miss.
struct Hit {
  std::uint32_t instance = RC_NONE, primitive = RC_NONE;
  bool miss() const { return primitive == RC_NONE; }
  bool operator==(const Hit&) const = default;
};

/// Image-plane abscissa of a point u pixels right of the centre of pixel `lane` of a group of `width` pixels, from the
/// group's centre, in pixels. (width - 1) / 2 and lane are exact; one rounding.
inline float group_abscissa(int lane, int width, float u) {
  return (static_cast<float>(lane) - static_cast<float>(width - 1) * 0.5f) + u;
}

/// The ray of the point (u, v), in pixels from the centre of pixel `lane` of the group, each component by the device's
/// own operations (kernels/geometry/samples.h), so that any exact fma gives the same bits.
inline Ray sample_ray(const shared::RayGroup& group, int lane, int width, float u, float v) {
  const float a = group_abscissa(lane, width, u);
  const auto direction = [&](float d0, float du, float dv) { return std::fma(v, dv, std::fma(a, du, d0)); };
  const float a_ahead = a * group.d0.w, v_ahead = v * group.d0.w;
  const auto offset = [&](float du, float dv, float ov) {
    return std::fma(v, ov, std::fma(v_ahead, dv, a_ahead * du));
  };
  return {{group.origin.x, group.origin.y, group.origin.z},
          {direction(group.d0.x, group.du.x, group.dv.x), direction(group.d0.y, group.du.y, group.dv.y),
           direction(group.d0.z, group.du.z, group.dv.z)},
          {offset(group.du.x, group.dv.x, group.ov.x), offset(group.du.y, group.dv.y, group.ov.y),
           offset(group.du.z, group.dv.z, group.ov.z)}};
}

inline std::array<float, 3> rounded(const glm::dvec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
inline glm::dvec3 to_double(const std::array<float, 3>& v) { return {v[0], v[1], v[2]}; }

/// Where a ray starts, m, scene frame.
inline glm::dvec3 start_of(const Ray& ray) { return to_double(ray.origin) + to_double(ray.offset); }

/// Where the sensor stands for a ray of the group, m, scene frame.
inline glm::dvec3 sensor_of(const shared::RayGroup& group, const Ray& ray) {
  return start_of(ray) - static_cast<double>(group.d0.w) * to_double(ray.direction);
}

}  // namespace raycube::reference
