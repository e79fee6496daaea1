#include <algorithm>
#include <cmath>

#include "host/plan/sky_rays.h"
#include "host/reference/radiance.h"
#include "kernels/sampling/sky_rays.h"
#include "scene_compiler/matter.h"

namespace raycube::reference {

std::vector<std::vector<NumberedRay>> numbered_rays(const plan::Plan& plan, const scene::Instrument& instrument,
                                                    std::uint64_t seed, std::uint32_t pixel) {
  const auto nu = static_cast<rc_u32>(instrument.samples_u), nv = static_cast<rc_u32>(instrument.samples_v),
             rays = static_cast<rc_u32>(plan.sky.rays), samples = nu * nv, low = plan::sky_seed(plan.sky, seed);
  std::vector<std::vector<NumberedRay>> out(samples);
  if (plan.components() == 0 || rays == 0) return out;
  for (rc_u32 part = 0; part < rc_sky_parts(samples, rays); ++part) {
    const SkyPart share =
        rc_sky_shares(static_cast<int>(instrument.sampler), nu, nv, rays, low, pixel, part);
    for (rc_u32 ray = 0; ray < share.rays; ++ray)
      out.at(rc_sky_sample(share, nu, samples, rays, low, pixel, part, ray))
          .push_back({rc_sky_number(samples, rays, part, ray), static_cast<double>(share.scale)});
  }
  return out;
}

SentRays sent_rays(const ReferenceScene& scene, const plan::Plan& plan, std::uint64_t seed, std::uint32_t pixel,
                   const Sample& side, const std::vector<NumberedRay>& rays) {
  SentRays out;
  if (side.hit.miss()) return out;
  const SkyDensity law = plan::sky_density(plan);
  for (const NumberedRay& numbered : rays) {
    const ::SkyRay ray =
        rc_sky_ray(law, plan::sky_seed(plan.sky, seed), pixel, numbered.number, static_cast<float>(side.normal.x),
                   static_cast<float>(side.normal.y), static_cast<float>(side.normal.z));
    SentRay& sent = out.emplace_back();
    sent.direction = {ray.x, ray.y, ray.z};
    if (!(ray.facing > 0) || !(ray.z > 0)) continue;
    const double each = 1 / static_cast<double>(ray.density);
    sent.weight = numbered.samples * static_cast<double>(ray.facing) * each;
    sent.solid_angle_sr = numbered.samples * std::min(each, 20.0);
    sent.open = scene.sees(side, sent.direction);
  }
  return out;
}

std::array<double, 8> sky_light(const plan::Plan& plan, const glm::dvec3& direction) {
  std::array<double, 8> out{};
  if (direction.z < 0) return out;
  const auto solar =
      plan::sky_value(plan.sky_basis, plan.sky.sun_azimuth_rad, direction.x, direction.y, direction.z);
  const auto first = static_cast<std::size_t>(plan.sky_components);
  std::copy_n(solar.begin(), first, out.begin());
  if (!plan.thermal.on) return out;
  const auto warm =
      plan::sky_value(plan.thermal.basis, plan.sky.sun_azimuth_rad, direction.x, direction.y, direction.z);
  const auto sky = static_cast<std::size_t>(plan.thermal.sky_components);
  std::copy_n(warm.begin(), sky, out.begin() + plan.sky_components);
  out[first + sky] = -1;
  return out;
}

double known_share(const scene::CompiledScene& scene, const plan::Plan& plan, const Hit& hit) {
  return static_cast<double>(
      plan.sky.known(scene.blocks[hit.primitive / RC_BLOCK].surface[hit.primitive % RC_BLOCK]));
}

}  // namespace raycube::reference
