#include "host/reference/lidar_optics.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "host/lidar/pulse_lobes.h"

namespace raycube::reference {

namespace {

/// (y - sin y) / 2 for 0 <= y <= 2 pi: area of a segment of angle y in the unit circle.
double segment(double y) {
  if (y > 0.5) return 0.5 * (y - std::sin(y));
  double term = y * y * y / 6, sum = 0;
  for (int n = 1; n <= 8; ++n) {
    sum += term;
    term *= -y * y / ((2 * n + 2) * (2 * n + 3));
  }
  return 0.5 * sum;
}

RcLocal local(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

}  // namespace

double lens_area(double a, double b, double d) {
  if (d >= a + b) return 0;
  const double small = std::min(a, b), large = std::max(a, b);
  if (d <= large - small) return M_PI * small * small;
  // Twice the triangle's area, sides sorted; then half angles at both centres.
  double s[3] = {a, b, d};
  std::sort(s, s + 3, std::greater<>());
  const double four_area = std::sqrt(
      std::max(0.0, (s[0] + (s[1] + s[2])) * (s[2] - (s[0] - s[1])) * (s[2] + (s[0] - s[1])) * (s[0] + (s[1] - s[2]))));
  const double at_a = std::atan2(four_area, d * d + (a - b) * (a + b));
  const double at_b = std::atan2(four_area, d * d + (b - a) * (b + a));
  return a * a * segment(2 * at_a) + b * b * segment(2 * at_b);
}

double pupil_share(const scene::LidarReceiver& receiver, double range_m, double offset_m) {
  if (range_m <= 0) return 0;
  const double fov = receiver.half_fov_rad, off_rad = offset_m / range_m;
  const double defocus = std::abs(1 / range_m - (receiver.focus_m > 0 ? 1 / receiver.focus_m : 0));
  const double outer = receiver.aperture_radius_m * defocus, inner = receiver.obscuration_radius_m * defocus;
  // An image far smaller than the stop lies in or out of it.
  if (outer <= 1e-12 * fov) return off_rad < fov ? 1 : 0;
  return (lens_area(fov, outer, off_rad) - lens_area(fov, inner, off_rad)) / (M_PI * (outer - inner) * (outer + inner));
}

double collecting_area(const scene::LidarReceiver& receiver) {
  const double area = M_PI * (receiver.aperture_radius_m - receiver.obscuration_radius_m) *
                      (receiver.aperture_radius_m + receiver.obscuration_radius_m);
  if (!receiver.tangent_aperture) return area;
  const double f_number = receiver.focal_length_m / (2 * receiver.aperture_radius_m);
  return area * 4 * f_number * f_number / (1 + 4 * f_number * f_number);
}

LidarMatter matter_of(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, std::uint32_t surface,
                      int line) {
  LidarMatter out;
  const shared::Surface& mixed = scene.surfaces[surface];
  for (int i = 0; i < 4; ++i) {
    if (mixed.material[i] == 0) continue;
    const std::size_t material = mixed.material[i] - 1;
    const lidar::Matter& matter =
        plan.matter[material * static_cast<std::size_t>(plan.lines()) + static_cast<std::size_t>(line)];
    const double share = mixed.fraction[i];
    out.reflectance += share * matter.reflectance, out.gloss += share * matter.mirrored;
    (scene.materials[material].behind.number == RC_SHAPE_plate ? out.plate : out.leaf) += share * matter.transmittance;
  }
  return out;
}

SurfaceLobes lobes_of(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, std::uint32_t surface, int line,
                      const glm::dvec3& normal, const glm::dvec3& in, const glm::dvec3& out) {
  const RcAngles angles = rc_angles(local(normal), local(in), local(out));
  return {lidar::front_form(plan, scene, surface, line, angles), lidar::gloss_form(plan, scene, surface, line, angles)};
}

RcLocal draw_direction(const scene::CompiledScene& scene, std::uint32_t surface, bool front, const RcLocal& in,
                       double u, double v) {
  const scene::Material& material = scene.materials[scene.surfaces[surface].material[0] - 1];
  const scene::Shape shape = front ? material.front : scene::Shape{RC_SHAPE_leaf};
  return rc_shape_sample(shape.number, shape.parameters(), in, u, v);
}

RcLocal draw_mirrored(const scene::CompiledScene& scene, std::uint32_t surface, const RcLocal& in, double u, double v) {
  return rc_mirror_or_cosine(lidar::gloss_alpha(scene, surface), in, u, v);
}

double mirrored_weight(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, std::uint32_t surface, int line,
                       const glm::dvec3& normal, const glm::dvec3& in, const glm::dvec3& out) {
  const RcAngles angles = rc_angles(local(normal), local(in), local(out));
  if (!(angles.cos_out > 0)) return 0;
  return lidar::gloss_form(plan, scene, surface, line, angles) * angles.cos_out /
         rc_mirror_or_cosine_pdf(lidar::gloss_alpha(scene, surface), angles);
}

double drawn_weight(const scene::CompiledScene& scene, const lidar::LidarPlan& plan, std::uint32_t surface, int line,
                    const glm::dvec3& normal, const glm::dvec3& in, const glm::dvec3& out) {
  const scene::Shape shape = scene.materials[scene.surfaces[surface].material[0] - 1].front;
  if (shape.number == RC_SHAPE_lambert) return 1;
  const RcAngles angles = rc_angles(local(normal), local(in), local(out));
  return lidar::front_form(plan, scene, surface, line, angles) * angles.cos_out /
         rc_shape_pdf(shape.number, shape.parameters(), angles);
}

}  // namespace raycube::reference
