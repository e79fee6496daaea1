#include "host/reference/path_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/base/planck.h"
#include "host/reference/ground_around.h"
#include "host/reference/spread.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::reference {

bool PathGains::carry(double factor, const Spectrum& times) {
  double most = 0;
  for (std::size_t i = 0; i < carried.size(); ++i) most = std::max(most, carried[i] *= factor * times[i]);
  return most > 0;
}

void PathGains::add(std::size_t source, double scalar, const Spectrum& times) {
  for (std::size_t i = 0; i < carried.size(); ++i) gained[source][i] += scalar * carried[i] * times[i];
}

glm::dvec3 by_cosine(const glm::dvec3& normal, double u, double v) {
  const glm::dvec3 other = std::abs(normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 across = glm::normalize(glm::cross(normal, other)), along = glm::cross(normal, across);
  const double turn = 2 * std::numbers::pi * v;
  return std::sqrt(u) * (std::cos(turn) * across + std::sin(turn) * along) + std::sqrt(1 - u) * normal;
}

std::vector<const Sample*> sides_of(const SampledPixel& at) {
  std::vector<const Sample*> out = {&at.samples[0]};
  for (const auto* others : {&at.far_sides, &at.glosses})
    if (!others->empty() && !others->front().hit.miss()) out.push_back(&others->front());
  return out;
}

PathLight::PathLight(const ReferenceScene& scene, const plan::Plan& plan)
    : scene_(scene), plan_(plan), curve_(curves_on(scene.compiled, plan.wavelength_um)) {
  if (plan.environment.empty()) return;
  ground_.assign(plan.wavelength_um.size(), 0.0);
  const Reflectances albedo = ground_albedos(scene.compiled, plan.wavelength_um);
  for (std::size_t m = 0; m < plan.environment.mean.size(); ++m)
    for (std::size_t i = 0; i < ground_.size(); ++i) ground_[i] += plan.environment.mean[m] * albedo[m][i];
  if (plan.sky_components > 0) open_ = unoccluded_irradiance(plan.irradiance, {0, 0, 1});
}

PathGains PathLight::unit() const {
  const std::size_t grid = plan_.wavelength_um.size(), sources = static_cast<std::size_t>(plan_.first_emission());
  return {Spectrum(grid, 1.0), Spectrum(grid, 0.0), std::vector<Spectrum>(sources, Spectrum(grid, 0.0))};
}

Spectrum PathLight::scattered(const Sample& side, const glm::dvec3& from) const {
  Spectrum out(plan_.wavelength_um.size(), 0.0);
  const scene::CompiledScene& scene = scene_.compiled;
  const auto add = [&](std::size_t material, double times, rc_id role) {
    const auto id = rc_curve_id(role, static_cast<rc_id>(material), scene::material_count(scene));
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += times * curve_[id - 1][i];
  };
  scene::for_each_material(scene::matter_of(scene, side.hit.primitive), [&](std::size_t material, float fraction) {
    add(material, static_cast<double>(fraction) * spread(scene, side, from), rc_curve_of_side(side.side));
    const auto& further = scene.materials[material].further;
    for (std::size_t t = 0; t < further.size() && side.side != RC_FAR_SIDE; ++t)
      if (scene::is_gloss(further[t].shape) == (side.side == RC_GLOSS_SIDE))
        add(material, static_cast<double>(fraction) * spread(further[t].shape, side, from),
            RC_CURVE_FURTHER + static_cast<rc_id>(t));
  });
  return out;
}

Spectrum PathLight::let_through(const Sample& at) const {
  Spectrum out(plan_.wavelength_um.size(), 0.0);
  const scene::CompiledScene& scene = scene_.compiled;
  scene::for_each_material(scene::matter_of(scene, at.hit.primitive), [&](std::size_t material, float fraction) {
    const Spectrum& curve = curve_[scene::transmittance_curve(scene, material) - 1];
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += static_cast<double>(fraction) * curve[i];
  });
  return out;
}

void PathLight::add_excess(const Sample& at, PathGains& light, const OwnLight& own) const {
  if (!plan_.thermal.on) return;
  const double around_K = plan_.thermal.surroundings_K;
  const scene::CompiledScene& scene = scene_.compiled;
  scene::for_each_material(scene::matter_of(scene, at.hit.primitive), [&](std::size_t material, float fraction) {
    const Spectrum part = own(material);
    const double kelvin = scene.materials[material].temperature_K;
    for (std::size_t i = 0; i < light.carried.size(); ++i) {
      const double l = plan_.wavelength_um[i];
      const double excess = base::planck_radiance(l, kelvin) - base::planck_radiance(l, around_K);
      light.emitted[i] += light.carried[i] * static_cast<double>(fraction) * part[i] * excess;
    }
  });
}

void PathLight::add_heat(const Sample& at, PathGains& light) const {
  const scene::CompiledScene& scene = scene_.compiled;
  const shared::Surface& surface = scene::matter_of(scene, at.hit.primitive);
  add_excess(at, light, [&](std::size_t material) {
    Spectrum own(light.carried.size(), 1.0);
    const auto less = [&](std::uint32_t curve, double times) {
      for (std::size_t i = 0; i < own.size(); ++i) own[i] -= times * curve_[curve - 1][i];
    };
    less(scene::reflectance_curve(scene, material), even_light(scene, plan_.thermal, at, 0));
    less(scene::transmittance_curve(scene, material), 1);
    for (std::size_t i = 0; i < 4; ++i)
      if (surface.material[i] == material + 1 && scene.materials[material].gloss.number != RC_SHAPE_none)
        less(scene::gloss_curve(scene, material), even_light(scene, plan_.thermal, at, 1 + i));
    for (std::size_t t = 0; t < scene.materials[material].further.size(); ++t)
      less(scene::further_curve(scene, material, t), even_light(scene, plan_.thermal, at, RC_LOBES + t));
    return own;
  });
}

void PathLight::take_own_for_through(const Sample& at, PathGains& light) const {
  add_excess(at, light, [&](std::size_t material) {
    Spectrum on = curve_[scene::transmittance_curve(scene_.compiled, material) - 1];
    for (double& value : on) value = -value;
    return on;
  });
}

void PathLight::add_sky(const glm::dvec3& way, PathGains& light) const {
  const std::array<double, 8> here = sky_light(plan_, way);
  const Spectrum one(light.carried.size(), 1.0);
  for (std::size_t c = 0; c < static_cast<std::size_t>(plan_.components()); ++c)
    light.add(static_cast<std::size_t>(plan_.sun_sources) + c, std::numbers::pi * here[c], one);
}

void PathLight::add_ground(const glm::dvec3& from, PathGains& light) const {
  if (ground_.empty() || !(from.z > static_cast<double>(scene_.compiled.lo[2]))) return;
  const double sun = plan_.sun_up ? std::max(0.0, static_cast<double>(plan_.sun_direction[2])) : 0;
  if (plan_.sun_sources > 0) light.add(0, sun, ground_);
  for (std::size_t c = 0; c < static_cast<std::size_t>(plan_.sky_components); ++c)
    light.add(static_cast<std::size_t>(plan_.sun_sources) + c, open_[c], ground_);
}

SampledPixel PathLight::stand(const Ray& ray, const Hit& hit) const {
  SampledPixel at;
  Sample& sample = at.samples.emplace_back();
  sample.ray = ray;
  sample.hit = hit;
  if (plan_.matter.through) at.far_sides.resize(1);
  if (plan_.matter.glossy) at.glosses.resize(1);
  scene_.place(at, 0, plan_);
  return at;
}

}  // namespace raycube::reference
