#include "host/reference/lidar_optics.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

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

/// Smith's Lambda of GGX for a direction whose angle to the normal has this cosine (Heitz, JCGT 3(2), 2014, eq. 72).
double lambda(double roughness, double cosine) {
  const double tangent = std::sqrt(std::max(0.0, 1 - cosine * cosine)) / cosine;
  return 0.5 * (std::sqrt(1 + roughness * roughness * tangent * tangent) - 1);
}

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
    if (mixed.curve[i] == 0) continue;
    const std::size_t material = mixed.curve[i] - 1;
    const lidar::Matter& matter =
        plan.matter[material * static_cast<std::size_t>(plan.lines()) + static_cast<std::size_t>(line)];
    const double share = mixed.fraction[i];
    out.reflectance += share * matter.reflectance;
    (scene.materials[material].transmission == scene::Material::Transmission::plate ? out.plate : out.leaf) +=
        share * matter.transmittance;
  }
  return out;
}

double gloss(double roughness, double f0, const glm::dvec3& normal, const glm::dvec3& in, const glm::dvec3& out) {
  const double cos_in = glm::dot(normal, in), cos_out = glm::dot(normal, out);
  if (roughness <= 0 || f0 <= 0 || cos_in <= 0 || cos_out <= 0) return 0;
  const glm::dvec3 half = glm::normalize(in + out);
  const double cos_half = glm::dot(normal, half), toward = std::clamp(glm::dot(half, out), 0.0, 1.0);
  const double a2 = roughness * roughness, bend = 1 - cos_half * cos_half + a2 * cos_half * cos_half;
  const double density = a2 / (M_PI * bend * bend);
  const double fresnel = f0 + (1 - f0) * std::pow(1 - toward, 5);
  const double l_in = lambda(roughness, std::min(cos_in, 1.0)), l_out = lambda(roughness, std::min(cos_out, 1.0));
  // Masking of ways whose azimuths lie together is the same masking (van Ginneken et al. 1998; Heitz 2014, eq. 106).
  const glm::dvec3 flat_in = in - cos_in * normal, flat_out = out - cos_out * normal;
  const double apart = glm::length(flat_in) * glm::length(flat_out) > 0
                           ? std::atan2(glm::length(glm::cross(flat_in, flat_out)), glm::dot(flat_in, flat_out))
                           : 0;
  const double uncorrelated = 4.41 * apart / (4.41 * apart + 1);
  const double masking = 1 / (1 + std::max(l_in, l_out) + uncorrelated * std::min(l_in, l_out));
  return fresnel * density * masking / (4 * cos_in * cos_out);
}

double gloss_of(const scene::CompiledScene& scene, std::uint32_t surface, const glm::dvec3& normal,
                const glm::dvec3& in, const glm::dvec3& out) {
  const shared::Surface& mixed = scene.surfaces[surface];
  double sum = 0;
  for (int i = 0; i < 4; ++i) {
    if (mixed.curve[i] == 0) continue;
    const scene::Material& material = scene.materials[mixed.curve[i] - 1];
    sum += mixed.fraction[i] * gloss(material.gloss_roughness, material.gloss_f0, normal, in, out);
  }
  return sum;
}

}  // namespace raycube::reference
