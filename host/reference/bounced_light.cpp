#include "host/reference/bounced_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/base/planck.h"
#include "host/reference/ground_around.h"
#include "host/reference/lamp_light.h"
#include "host/reference/plan_nodes.h"
#include "host/reference/spread.h"
#include "kernels/sampling/sampler.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::reference {

namespace {

constexpr std::uint32_t kFirstDraw = 1000;  ///< of rc_hash; the device's end far below, but for plates (from 4096)
constexpr double kThroughPlates = 0.5;      ///< share of the paths that meet a plate and go through it
constexpr double kByGloss = 0.4;            ///< share of the paths that leave a glossy surface by its gloss
constexpr int kOpenSteps = 256;             ///< of an open sky's integral, each way

/// Unit vector by the cosine about a normal, for u and v uniform in [0, 1).
glm::dvec3 by_cosine(const glm::dvec3& normal, double u, double v) {
  const glm::dvec3 other = std::abs(normal.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
  const glm::dvec3 across = glm::normalize(glm::cross(normal, other)), along = glm::cross(normal, across);
  const double turn = 2 * std::numbers::pi * v;
  return std::sqrt(u) * (std::cos(turn) * across + std::sin(turn) * along) + std::sqrt(1 - u) * normal;
}

/// The side of a surface that the path came to, the one behind it where something goes through, and the gloss of the
/// first where it has one.
std::vector<const Sample*> sides_of(const SampledPixel& at) {
  std::vector<const Sample*> out = {&at.samples[0]};
  for (const auto* others : {&at.far_sides, &at.glosses})
    if (!others->empty() && !others->front().hit.miss()) out.push_back(&others->front());
  return out;
}

}  // namespace

struct BouncedLight::Walk {
  std::uint64_t seed;
  std::uint32_t pixel, path, drawn = 0;
  Spectrum carried;              ///< what the viewer sees of a unit of radiance that comes back
  Spectrum emitted;              ///< by surfaces beyond the surroundings, W m-2 sr-1 um-1
  std::vector<Spectrum> gained;  ///< [source], as the plan counts them, emission left out
  Sample from{};                 ///< the side that the path leaves
  glm::dvec3 way{0};             ///< unit

  double draw() {
    return static_cast<double>(
        rc_unit_float(rc_hash(static_cast<std::uint32_t>(seed), pixel, path, kFirstDraw + drawn++)));
  }
  /// False: nothing is left to carry.
  bool carry(double factor, const Spectrum& times) {
    double most = 0;
    for (std::size_t i = 0; i < carried.size(); ++i) most = std::max(most, carried[i] *= factor * times[i]);
    return most > 0;
  }
  void add(std::size_t source, double scalar, const Spectrum& times) {
    for (std::size_t i = 0; i < carried.size(); ++i) gained[source][i] += scalar * carried[i] * times[i];
  }
};

BouncedLight::BouncedLight(const ReferenceScene& scene, const plan::Plan& plan, int levels)
    : scene_(scene), plan_(plan), levels_(levels), curve_(curves_on(scene.compiled, plan.wavelength_um)) {
  if (plan.environment.empty()) return;
  ground_.assign(plan.wavelength_um.size(), 0.0);
  const Reflectances albedo = ground_albedos(scene.compiled, plan.wavelength_um);
  for (std::size_t m = 0; m < plan.environment.mean.size(); ++m)
    for (std::size_t i = 0; i < ground_.size(); ++i) ground_[i] += plan.environment.mean[m] * albedo[m][i];
  for (int a = 0; a < kOpenSteps; ++a)
    for (int b = 0; b < kOpenSteps; ++b) {
      const auto light = sky_light(plan, by_cosine({0, 0, 1}, (a + 0.5) / kOpenSteps, (b + 0.5) / kOpenSteps));
      for (std::size_t c = 0; c < static_cast<std::size_t>(plan.sky_components); ++c)
        open_[c] += std::numbers::pi * light[c] / (kOpenSteps * kOpenSteps);
    }
}

BouncedLight::Spectrum BouncedLight::scattered(const Sample& side, const glm::dvec3& from) const {
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

void BouncedLight::add_sun(const SampledPixel& at, Walk& walk, bool seen_too) const {
  if (plan_.sun_sources == 0) return;
  const glm::dvec3 sun = to_double(plan_.sun_direction);
  for (const Sample* side : sides_of(at)) {
    if (side->sun_visible) {
      if (seen_too) walk.add(0, side->cos_sun, scattered(*side, sun));
      continue;
    }
    Spectrum let(walk.carried.size(), 1.0);
    if (!plan_.matter.plates || !plan_.sun_up || !(side->cos_sun > 0) || !behind_plates(*side, sun, let)) continue;
    const Spectrum sent = scattered(*side, sun);
    for (std::size_t i = 0; i < let.size(); ++i) let[i] *= sent[i];
    walk.add(0, side->cos_sun, let);
  }
}

bool BouncedLight::behind_plates(Sample from, const glm::dvec3& way, Spectrum& let) const {
  for (;;) {
    const Hit hit = scene_.meets(from, way);
    if (hit.miss()) return true;
    if (!scene::is_plate(scene_.compiled, hit.primitive)) return false;
    from = stand(from, way, hit).samples[0];
    const Spectrum through = let_through(from);
    for (std::size_t i = 0; i < let.size(); ++i) let[i] *= through[i];
    from.normal = -from.normal;
  }
}

BouncedLight::Spectrum BouncedLight::let_through(const Sample& at) const {
  Spectrum out(plan_.wavelength_um.size(), 0.0);
  const scene::CompiledScene& scene = scene_.compiled;
  scene::for_each_material(scene::matter_of(scene, at.hit.primitive), [&](std::size_t material, float fraction) {
    const Spectrum& curve = curve_[scene::transmittance_curve(scene, material) - 1];
    for (std::size_t i = 0; i < out.size(); ++i) out[i] += static_cast<double>(fraction) * curve[i];
  });
  return out;
}

bool BouncedLight::pass(const SampledPixel& at, Walk& walk) const {
  const Sample& near = at.samples[0];
  if (!plan_.matter.plates || !scene::is_plate(scene_.compiled, near.hit.primitive)) return false;
  if (walk.draw() >= kThroughPlates) {
    walk.carry(1 / (1 - kThroughPlates), Spectrum(walk.carried.size(), 1.0));
    return false;
  }
  walk.carry(1 / kThroughPlates, let_through(near));
  walk.way = glm::normalize(to_double(near.ray.direction));
  walk.from = near;
  walk.from.normal = -near.normal;
  return true;
}

Hit BouncedLight::ahead(Walk& walk, bool& passed) const {
  for (;;) {
    const Hit hit = scene_.meets(walk.from, walk.way);
    if (hit.miss() || !plan_.matter.plates || !pass(stand(walk.from, walk.way, hit), walk)) return hit;
    passed = true;
  }
}

void BouncedLight::add_lamps(const SampledPixel& at, Walk& walk) const {
  const auto first = static_cast<std::size_t>(plan_.first_lamp());
  if (plan_.lamps.sources() == 0) return;
  for (const Sample* side : sides_of(at)) {
    const double v = walk.draw(), w = walk.draw();
    for (const LampLight& light : some_lamplight(scene_, plan_, *side, v, w))
      walk.add(first + light.source, light.irradiance, scattered(*side, light.direction));
  }
}

void BouncedLight::add_heat(const Sample& at, Walk& walk, bool whole, double times) const {
  if (!plan_.thermal.on) return;
  const double around_K = plan_.thermal.surroundings_K;
  const scene::CompiledScene& scene = scene_.compiled;
  Spectrum sent(walk.carried.size(), 0.0);
  scene::for_each_material(scene::matter_of(scene, at.hit.primitive), [&](std::size_t material, float fraction) {
    const Spectrum &back = curve_[scene::reflectance_curve(scene, material) - 1],
                   &on = curve_[scene::transmittance_curve(scene, material) - 1];
    const double kelvin = scene.materials[material].temperature_K;
    for (std::size_t i = 0; i < sent.size(); ++i) {
      const double l = plan_.wavelength_um[i];
      const double excess = base::planck_radiance(l, kelvin) - base::planck_radiance(l, around_K);
      sent[i] += times * static_cast<double>(fraction) * (whole ? 1 : 1 - back[i] - on[i]) * excess;
    }
  });
  for (std::size_t i = 0; i < sent.size(); ++i) walk.emitted[i] += walk.carried[i] * sent[i];
}

void BouncedLight::add_sky(const glm::dvec3& way, Walk& walk) const {
  const std::array<double, 8> light = sky_light(plan_, way);
  const Spectrum one(walk.carried.size(), 1.0);
  for (std::size_t c = 0; c < static_cast<std::size_t>(plan_.components()); ++c)
    walk.add(static_cast<std::size_t>(plan_.sun_sources) + c, std::numbers::pi * light[c], one);
}

void BouncedLight::add_last_sky(Walk& walk) const {
  Spectrum let(walk.carried.size(), 1.0);
  if (plan_.matter.plates ? !behind_plates(walk.from, walk.way, let) : !scene_.sees(walk.from, walk.way)) return;
  walk.carry(1, let);
  add_sky(walk.way, walk);
}

void BouncedLight::add_ground(Walk& walk) const {
  if (ground_.empty() || !(walk.from.point.z > static_cast<double>(scene_.compiled.lo[2]))) return;
  const double sun = plan_.sun_up ? std::max(0.0, static_cast<double>(plan_.sun_direction[2])) : 0;
  if (plan_.sun_sources > 0) walk.add(0, sun, ground_);
  for (std::size_t c = 0; c < static_cast<std::size_t>(plan_.sky_components); ++c)
    walk.add(static_cast<std::size_t>(plan_.sun_sources) + c, open_[c], ground_);
}

bool BouncedLight::mirror(const Sample& gloss, Walk& walk) const {
  const scene::Shape& shape = *scene::gloss_of(scene_.compiled, gloss.hit.primitive);
  const double a = rc_shape_roughness(shape.number, shape.parameters());
  const double u = walk.draw(), tan = a * std::sqrt(u / (1 - u)), cosine = 1 / std::sqrt(1 + tan * tan);
  const glm::dvec3 viewer = -glm::normalize(to_double(gloss.ray.direction));
  const glm::dvec3 facet = by_cosine(gloss.normal, 1 - cosine * cosine, walk.draw());
  walk.way = 2 * glm::dot(facet, viewer) * facet - viewer;
  walk.from = gloss;
  const double facing = glm::dot(walk.way, gloss.normal), turn = glm::dot(facet, viewer);
  if (!(facing > 0 && turn > 0)) return false;
  // Facets' density D cos; mirrored ways' is that over 4 turn (Walter et al. 2007, equation 38).
  const double slope = 1 + tan * tan / (a * a);
  const double density = cosine / (std::numbers::pi * a * a * std::pow(cosine, 4) * slope * slope) / (4 * turn);
  const double factor = facing / (std::numbers::pi * density * kByGloss);
  const Spectrum sent = scattered(gloss, walk.way);
  return walk.carry(factor, sent);
}

bool BouncedLight::turn(const SampledPixel& at, Walk& walk) const {
  const bool glossy = !at.glosses.empty() && !at.glosses[0].hit.miss();
  if (glossy && walk.draw() < kByGloss) return mirror(at.glosses[0], walk);
  const bool leaf = !at.far_sides.empty() && !at.far_sides[0].hit.miss(), through = leaf && walk.draw() < 0.5;
  const Sample& side = through ? at.far_sides[0] : at.samples[0];
  const double u = walk.draw(), v = walk.draw();
  walk.way = by_cosine(side.normal, u, v);
  walk.from = side;
  const double factor = (leaf ? 2 : 1) / (glossy ? 1 - kByGloss : 1);
  const Spectrum sent = scattered(side, walk.way);
  return walk.carry(factor, sent);
}

SampledPixel BouncedLight::stand(const Sample& from, const glm::dvec3& way, const Hit& hit) const {
  SampledPixel at;
  Sample& sample = at.samples.emplace_back();
  sample.ray = {rounded(from.point), rounded(way), {}};
  sample.hit = hit;
  if (plan_.matter.through) at.far_sides.resize(1);
  if (plan_.matter.glossy) at.glosses.resize(1);
  scene_.place(at, 0, plan_);
  return at;
}

std::vector<double> BouncedLight::at_sensor(const SampledPixel& pixel, const Sample& first, const Walk& walk) const {
  const NodeWeight h = locate(plan_.height, first.point.z), v = locate(plan_.view, 1 / pixel.to_sensor.z);
  Spectrum sum(plan_.wavelength_um.size(), 0.0);
  for (int ih = 0; ih < plan_.height.count; ++ih)
    for (int iv = 0; iv < plan_.view.count; ++iv) {
      const double weight = h.of(ih) * v.of(iv);
      if (weight == 0) continue;
      const auto node = static_cast<std::size_t>(ih * plan_.view.count + iv),
                 nodes = static_cast<std::size_t>(plan_.height.count * plan_.view.count);
      const auto add = [&](const Spectrum& gained, const Spectrum& light) {
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * gained[i] * light[i];
      };
      for (std::size_t source = 0; source < walk.gained.size(); ++source)
        add(walk.gained[source], plan_.source_spectrum[source * nodes + node]);
      if (plan_.thermal.on) add(walk.emitted, plan_.transmission_spectrum[node]);
    }
  return band_values(plan_, sum);
}

std::vector<double> BouncedLight::by_path(const SampledPixel& pixel, std::uint64_t seed, std::uint32_t path) const {
  const std::size_t grid = plan_.wavelength_um.size(), sources = static_cast<std::size_t>(plan_.first_emission());
  Walk walk{seed,
            pixel.number,
            path,
            0,
            Spectrum(grid, 1.0),
            Spectrum(grid, 0.0),
            std::vector<Spectrum>(sources, Spectrum(grid, 0.0))};
  double left = walk.draw();
  std::size_t chosen = 0;
  while (chosen + 1 < pixel.samples.size() && (left -= pixel.samples[chosen].weight) >= 0) ++chosen;
  const Sample& first = pixel.samples[chosen];
  if (first.hit.miss()) return std::vector<double>(plan_.bands.size(), 0.0);
  SampledPixel at;
  at.samples = {first};
  if (!pixel.far_sides.empty()) at.far_sides = {pixel.far_sides[chosen]};
  if (!pixel.glosses.empty()) at.glosses = {pixel.glosses[chosen]};
  if (plan_.matter.plates) add_sun(at, walk, false);
  bool passed = pass(at, walk);
  // So far the plate counts as if it sent by itself what it lets through.
  if (passed) add_heat(first, walk, true, -1);
  for (int level = 0; passed || turn(at, walk); ++level) {
    if (level == levels_) {
      add_last_sky(walk);
      break;
    }
    const Hit hit = ahead(walk, passed);
    if (hit.miss()) {
      if (!(walk.way.z > 0))
        add_ground(walk);
      else if (level > 0 || passed)
        add_sky(walk.way, walk);  // else it is light scattered once
      break;
    }
    passed = false;
    at = stand(walk.from, walk.way, hit);
    add_sun(at, walk, true);
    add_lamps(at, walk);
    add_heat(at.samples[0], walk, false, 1);
  }
  return at_sensor(pixel, first, walk);
}

}  // namespace raycube::reference
