#include "host/reference/bounced_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/reference/lamp_light.h"
#include "host/reference/plan_nodes.h"
#include "kernels/sampling/sampler.h"
#include "scene_compiler/matter.h"

namespace raycube::reference {

namespace {

constexpr std::uint32_t kFirstDraw = 1000;  ///< of rc_hash; the device's end far below, but for plates (from 4096)
constexpr double kThroughPlates = 0.5;      ///< share of the paths that meet a plate and go through it
constexpr double kByGloss = 0.4;            ///< share of the paths that leave a glossy surface by its gloss

}  // namespace

BouncedLight::BouncedLight(const ReferenceScene& scene, const plan::Plan& plan, int levels)
    : scene_(scene), plan_(plan), levels_(levels), light_(scene, plan) {}

struct BouncedLight::Walk {
  std::uint64_t seed;
  std::uint32_t pixel, path, drawn = 0;
  PathGains light;
  Sample from{};      ///< the side that the path leaves
  glm::dvec3 way{0};  ///< unit

  double draw() {
    return static_cast<double>(
        rc_unit_float(rc_hash(static_cast<std::uint32_t>(seed), pixel, path, kFirstDraw + drawn++)));
  }
};

SampledPixel BouncedLight::stand(const Sample& from, const glm::dvec3& way, const Hit& hit) const {
  return light_.stand({rounded(from.point), rounded(way), {}}, hit);
}

void BouncedLight::add_sun(const SampledPixel& at, Walk& walk, bool seen_too) const {
  if (plan_.sun_sources == 0) return;
  const glm::dvec3 sun = to_double(plan_.sun_direction);
  for (const Sample* side : sides_of(at)) {
    if (side->sun_visible) {
      if (seen_too) walk.light.add(0, side->cos_sun, light_.scattered(*side, sun));
      continue;
    }
    Spectrum let(walk.light.carried.size(), 1.0);
    if (!plan_.matter.plates || !plan_.sun_up || !(side->cos_sun > 0) || !behind_plates(*side, sun, let)) continue;
    const Spectrum sent = light_.scattered(*side, sun);
    for (std::size_t i = 0; i < let.size(); ++i) let[i] *= sent[i];
    walk.light.add(0, side->cos_sun, let);
  }
}

bool BouncedLight::behind_plates(Sample from, const glm::dvec3& way, Spectrum& let) const {
  for (;;) {
    const Hit hit = scene_.meets(from, way);
    if (hit.miss()) return true;
    if (!scene::is_plate(scene_.compiled, hit.primitive)) return false;
    from = stand(from, way, hit).samples[0];
    const Spectrum through = light_.let_through(from);
    for (std::size_t i = 0; i < let.size(); ++i) let[i] *= through[i];
    from.normal = -from.normal;
  }
}

bool BouncedLight::pass(const SampledPixel& at, Walk& walk) const {
  const Sample& near = at.samples[0];
  if (!plan_.matter.plates || !scene::is_plate(scene_.compiled, near.hit.primitive)) return false;
  if (walk.draw() >= kThroughPlates) {
    walk.light.carry(1 / (1 - kThroughPlates), Spectrum(walk.light.carried.size(), 1.0));
    return false;
  }
  walk.light.carry(1 / kThroughPlates, light_.let_through(near));
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
      walk.light.add(first + light.source, light.irradiance, light_.scattered(*side, light.direction));
  }
}

void BouncedLight::add_last_sky(Walk& walk) const {
  Spectrum let(walk.light.carried.size(), 1.0);
  if (plan_.matter.plates ? !behind_plates(walk.from, walk.way, let) : !scene_.sees(walk.from, walk.way)) return;
  walk.light.carry(1, let);
  light_.add_sky(walk.way, walk.light);
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
  const Spectrum sent = light_.scattered(gloss, walk.way);
  return walk.light.carry(factor, sent);
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
  const Spectrum sent = light_.scattered(side, walk.way);
  return walk.light.carry(factor, sent);
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
      for (std::size_t source = 0; source < walk.light.gained.size(); ++source)
        add(walk.light.gained[source], plan_.source_spectrum[source * nodes + node]);
      if (plan_.thermal.on) add(walk.light.emitted, plan_.transmission_spectrum[node]);
    }
  return band_values(plan_, sum);
}

std::vector<double> BouncedLight::by_path(const SampledPixel& pixel, std::uint64_t seed, std::uint32_t path) const {
  Walk walk{seed, pixel.number, path, 0, light_.unit()};
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
  if (plan_.matter.plates && scene::is_plate(scene_.compiled, first.hit.primitive))
    light_.take_own_for_through(first, walk.light);
  bool passed = pass(at, walk);
  for (int level = 0; passed || turn(at, walk); ++level) {
    if (level == levels_) {
      add_last_sky(walk);
      break;
    }
    const Hit hit = ahead(walk, passed);
    if (hit.miss()) {
      if (!(walk.way.z > 0))
        light_.add_ground(walk.from.point, walk.light);
      else if (level > 0 || passed)
        light_.add_sky(walk.way, walk.light);  // else it is light scattered once
      break;
    }
    passed = false;
    at = stand(walk.from, walk.way, hit);
    add_sun(at, walk, true);
    add_lamps(at, walk);
    light_.add_heat(at.samples[0], walk.light);
  }
  return at_sensor(pixel, first, walk);
}

}  // namespace raycube::reference
