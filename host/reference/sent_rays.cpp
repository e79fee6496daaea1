#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/geometric.hpp>

#include "host/reference/radiance.h"
#include "host/reference/spread.h"
#include "kernels/sampling/sky_rays.h"
#include "scene_compiler/matter.h"

namespace raycube::reference {

std::vector<std::vector<NumberedRay>> numbered_rays(const plan::Plan& plan, const scene::Instrument& instrument,
                                                    std::uint64_t seed, std::uint32_t pixel) {
  const auto nu = static_cast<rc_u32>(instrument.samples_u), nv = static_cast<rc_u32>(instrument.samples_v),
             rays = static_cast<rc_u32>(plan.sky.rays), samples = nu * nv, low = plan.sky.hash_seed(seed);
  std::vector<std::vector<NumberedRay>> out(samples);
  if (plan.components() == 0 || rays == 0) return out;
  for (rc_u32 part = 0; part < rc_sky_parts(samples, rays); ++part) {
    const SkyPart share = rc_sky_shares(static_cast<int>(instrument.sampler), nu, nv, rays, low, pixel, part);
    for (rc_u32 ray = 0; ray < share.rays; ++ray)
      out.at(rc_sky_sample(share, nu, samples, rays, low, pixel, part, ray))
          .push_back({rc_sky_number(samples, rays, part, ray), static_cast<double>(share.scale)});
  }
  return out;
}

namespace {

/// Density of a ray's direction, sr-1, in double and by its own formula: shares of the cosine about the normal, of
/// Henyey and Greenstein's law about the sun (Astrophys. J. 93, 1941, equation 2), of an even upper hemisphere.
double law_density(const plan::Plan& plan, const glm::dvec3& normal, const glm::dvec3& direction) {
  const glm::dvec3 sun(plan.sun_direction[0], plan.sun_direction[1], plan.sun_direction[2]);
  const double g = plan.sky.asymmetry, rest = 1 - plan.sky.cosine_share;
  const double cosine = std::max(0.0, glm::dot(normal, direction)) / std::numbers::pi;
  if (!(rest > 0)) return cosine;
  const double lobe =
      (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * glm::dot(sun, direction), 1.5));
  const double even = direction.z > 0 ? 0.5 / std::numbers::pi : 0;
  return plan.sky.cosine_share * cosine + rest * (plan.sky.sun_share * lobe + (1 - plan.sky.sun_share) * even);
}

double roughness_of(const scene::CompiledScene& scene, const Sample& side) {
  const scene::Shape& gloss = *scene::gloss_of(scene, side.hit.primitive);
  return rc_shape_roughness(gloss.number, gloss.parameters());
}

}  // namespace

double mirrored_density(const scene::CompiledScene& scene, const Sample& side, const glm::dvec3& direction) {
  const double a = roughness_of(scene, side);
  const glm::dvec3 facet = glm::normalize(viewer_of(side) + direction);
  const double cosine = glm::dot(facet, side.normal), turn = glm::dot(facet, direction);
  const glm::dvec3 across = glm::cross(facet, side.normal);
  const double slope2 = glm::dot(across, across) / (cosine * cosine);
  const double facets = std::pow(1 + slope2 / (a * a), -2) / (std::numbers::pi * a * a * std::pow(cosine, 4));
  return cosine > 0 && turn > 0 ? facets * cosine / (4 * turn) : 0;
}

namespace {

/// The same with the share of a gloss.
double density_of(const scene::CompiledScene& scene, const plan::Plan& plan, const Sample& side,
                  const glm::dvec3& direction) {
  const double law = law_density(plan, side.normal, direction);
  return side.rays == RC_GLOSS_SIDE ? 0.5 * (law + mirrored_density(scene, side, direction)) : law;
}

/// The ray: bit for bit the device's, of gloss but for the rounding of the way to the viewer.
::SkyRay ray_of(const scene::CompiledScene& scene, const SkyDensity& law, rc_u32 seed, rc_u32 pixel, rc_u32 number,
                const Sample& side) {
  const glm::vec3 n(side.normal), v(viewer_of(side));
  if (side.rays != RC_GLOSS_SIDE) return rc_sky_ray(law, seed, pixel, number, n.x, n.y, n.z);
  const auto roughness = static_cast<float>(roughness_of(scene, side));
  return rc_gloss_way(law, roughness, seed, pixel, number, n.x, n.y, n.z, v.x, v.y, v.z);
}

}  // namespace

SentRays sent_rays(const ReferenceScene& scene, const plan::Plan& plan, std::uint64_t seed, std::uint32_t pixel,
                   const Sample& side, const std::vector<NumberedRay>& rays) {
  SentRays out;
  if (side.hit.miss()) return out;
  const SkyDensity law{static_cast<float>(plan.sky.cosine_share),
                       static_cast<float>(plan.sky.sun_share),
                       static_cast<float>(plan.sky.asymmetry),
                       plan.sun_direction[0],
                       plan.sun_direction[1],
                       plan.sun_direction[2]};
  for (const NumberedRay& numbered : rays) {
    const ::SkyRay ray = ray_of(scene.compiled, law, plan.sky.hash_seed(seed), pixel, numbered.number, side);
    SentRay& sent = out.emplace_back();
    sent.direction = {ray.x, ray.y, ray.z};
    if (!(ray.facing > 0) || !(ray.z > 0)) continue;
    const double each = 1 / density_of(scene.compiled, plan, side, sent.direction);
    sent.weight = numbered.samples * static_cast<double>(ray.facing) * each;
    sent.solid_angle_sr = numbered.samples * std::min(each, 20.0);
    sent.open = scene.sees(side, sent.direction);
  }
  return out;
}

namespace {

/// Where a value lies between ascending nodes: linear weights of node `low` and the next.
struct Between {
  std::size_t low = 0;
  double f = 0;
};
Between between(const std::vector<double>& nodes, double at) {
  Between out;
  while (out.low + 2 < nodes.size() && nodes[out.low + 1] <= at) ++out.low;
  out.f = std::clamp((at - nodes[out.low]) / (nodes[out.low + 1] - nodes[out.low]), 0.0, 1.0);
  return out;
}

/// The maps of a basis, linear in zenith and in the azimuth from the sun's, either side alike.
std::array<double, 4> map_value(const plan::SkyBasis& basis, double sun_azimuth_rad, const glm::dvec3& d) {
  std::array<double, 4> out{};
  const double around = std::atan2(d.x, d.y) - sun_azimuth_rad;
  const Between zenith = between(basis.zenith_rad, std::atan2(std::hypot(d.x, d.y), d.z)),
                azimuth = between(basis.azimuth_rad, std::abs(std::remainder(around, 2 * std::numbers::pi)));
  for (const auto& [i, u] : {std::pair{zenith.low, 1 - zenith.f}, {zenith.low + 1, zenith.f}})
    for (const auto& [j, v] : {std::pair{azimuth.low, 1 - azimuth.f}, {azimuth.low + 1, azimuth.f}})
      for (std::size_t m = 0; m < 4; ++m) out[m] += u * v * basis.value[i * basis.azimuth_rad.size() + j][m];
  return out;
}

}  // namespace

std::array<double, 8> sky_light(const plan::Plan& plan, const glm::dvec3& direction) {
  std::array<double, 8> out{};
  if (direction.z < 0) return out;
  const auto first = static_cast<std::size_t>(plan.sky_components);
  if (plan.sky_components > 0) {
    const auto solar = map_value(plan.sky_basis, plan.sky.sun_azimuth_rad, direction);
    std::copy_n(solar.begin(), first, out.begin());
  }
  if (!plan.thermal.on) return out;
  const auto warm = map_value(plan.thermal.basis, plan.sky.sun_azimuth_rad, direction);
  const auto sky = static_cast<std::size_t>(plan.thermal.sky_components);
  std::copy_n(warm.begin(), sky, out.begin() + plan.sky_components);
  out[first + sky] = -1;
  return out;
}

double known_share(const scene::CompiledScene& scene, const plan::Plan& plan, const Sample& side) {
  if (side.rays == RC_GLOSS_SIDE) return 0;
  return static_cast<double>(plan.sky.known(scene::surface_of(scene, side.hit.primitive)));
}

}  // namespace raycube::reference
