#include "host/plan/path_parts.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "host/plan/curve.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/shape_energy.h"
#include "scene_compiler/shape_list.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::plan {

namespace {

constexpr double kMostSeen = 4;     ///< light at a place over that of the bands there, so far counted
constexpr double kNoWarmth = 1e-9;  ///< of the light together

/// Of matter that is a sum of lobes, what light may be multiplied by: of shapes that change with wavelength each lobe's
/// curve; of those that go by the curve's value, and of a gloss by Fresnel's law, whose lobes' curves change their
/// signs, what leaves in all of light from some angles.
Curves lobe_factors(const Plan& plan, const scene::Material& material) {
  Curves out;
  const auto add = [&](const std::vector<scene::ShapeAndCurve>& parts, auto&& factor_of) {
    auto& sum = out.emplace_back(plan.wavelength_um.size(), 0.0);
    for (const auto& part : parts) {
      const std::vector<double> curve = sample_curve(material, part.curve, plan.wavelength_um);
      const double factor = factor_of(part.shape);
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += factor * curve[i];
    }
    for (double& value : sum) value = std::max(0.0, value);
  };
  const auto front = scene::front_parts(material), gloss = scene::gloss_parts(material);
  const bool by_values = scene::shape_entry(material.front.number).curve_parameter >= 0;
  if (by_values)
    for (const double zenith_rad : {0.2, 0.9, 1.3})
      add(front, [&](const scene::Shape& shape) { return scene::black_sky_albedo(shape, zenith_rad); });
  if (!material.index_n.value.empty())
    for (const double cosine : {1.0, 0.5, 0.25, 0.1})
      add(gloss,
          [&](const scene::Shape& shape) { return rc_shape_mirrored(shape.number, shape.parameters(), cosine); });
  const auto one = [](const scene::Shape&) { return 1.0; };
  if (!material.front_nodes.empty() && !by_values)
    for (const auto& part : front) add({part}, one);
  if (!material.gloss_nodes.empty())
    for (const auto& part : gloss) add({part}, one);
  return out;
}

/// Weight of a source in what light_together adds up.
double together_weight(const Plan& plan, int source) {
  if (source < plan.sun_sources) return std::max(0.05, static_cast<double>(plan.sun_direction[2]));
  const bool sky = source == plan.first_component() && plan.sky_components > 0;
  const bool warm = source == plan.first_component() + plan.sky_components && plan.thermal.sky_components > 0;
  return sky || warm ? 1 : 0;
}

/// Adds what each material sends by itself beyond the surroundings, where that is light of its own.
void add_emitted(PathParts& parts, const PathHeat& heat, const Plan& plan, const scene::CompiledScene& scene) {
  parts.warmth = heat.surroundings;
  for (std::size_t number = 0; number < heat.excess.size(); ++number) {
    std::vector<double> sent = heat.excess[number];
    if (sent.empty()) continue;
    const std::vector<double> back = curve_on(scene, scene::reflectance_curve(scene, number), plan.wavelength_um),
                              on = curve_on(scene, scene::transmittance_curve(scene, number), plan.wavelength_um);
    for (std::size_t i = 0; i < sent.size(); ++i) sent[i] *= 1 - back[i] - on[i];
    if (std::all_of(sent.begin(), sent.end(), [](double s) { return std::abs(s) < kNoWarmth; })) continue;
    parts.all.push_back(std::move(sent)), ++parts.emitted;
  }
}

/// How much of the bands' light is at each place of the grid: between the lines of a band is what it sees.
void add_seen(PathParts& parts, const Plan& plan, const std::vector<double>& spectrum) {
  if (!(largest_of(spectrum) > 0)) return;
  std::vector<double> weight(spectrum.size(), 0.0), light(spectrum.size(), 0.0);
  for (BandQuadrature band : plan.bands) {
    double sum = 0, lit = 0;
    for (std::size_t i = 0; i < band.weight.size(); ++i)
      sum += band.weight[i], lit += band.weight[i] * spectrum[band.first + i];
    for (std::size_t i = 0; i < band.weight.size(); ++i) {
      const double here = std::abs(band.weight[i]);  // some are negative
      weight[band.first + i] += here, light[band.first + i] += here * lit / sum;
      band.weight[i] *= lit > 0 ? spectrum[band.first + i] / lit : 0;
    }
    parts.bands.push_back(std::move(band));
  }
  parts.seen.resize(spectrum.size(), 0.0);
  for (std::size_t i = 0; i < spectrum.size(); ++i)
    if (light[i] > 0) parts.seen[i] = std::max(parts.seen[i], std::min(kMostSeen, spectrum[i] * weight[i] / light[i]));
}

}  // namespace

PathFactors factors_of(const Plan& plan, const scene::CompiledScene& scene) {
  PathFactors out, shares;  // the latter of shapes that change with wavelength
  const auto add = [](PathFactors& to, std::vector<double> curve, std::uint32_t owner) {
    if (!(largest_of(curve) > 0)) return;
    to.curve.push_back(std::move(curve)), to.owner.push_back(owner);
  };
  for (const auto number : scene::used_materials(scene)) {
    const scene::Material& material = scene.materials[number];
    const std::vector<double> back = sample_reflectance(material, plan.wavelength_um);
    add(out, back, number);
    for (auto& share : lobe_factors(plan, material)) add(shares, std::move(share), number);
    if (!scene::lets_light_through(material) && !scene::is_plate(material)) continue;
    std::vector<double> both = sample_curve(material, material.transmittance, plan.wavelength_um);
    add(out, both, number);
    for (std::size_t i = 0; i < both.size(); ++i) both[i] += back[i];
    add(out, std::move(both), number);
  }
  // Of what a gloss mirrors there is a curve less.
  if (plan.matter.glossy) add(out, std::vector<double>(plan.wavelength_um.size(), 1.0), kNobody);
  std::move(shares.curve.begin(), shares.curve.end(), std::back_inserter(out.curve));
  out.owner.insert(out.owner.end(), shares.owner.begin(), shares.owner.end());
  return out;
}

Curves light_together(const Plan& plan, const scene::CompiledScene& scene) {
  const auto nodes = static_cast<std::size_t>(plan.height.count * plan.view.count);
  Curves out(nodes, hottest_light(plan, scene));
  for (std::size_t n = 0; plan.thermal.on && n < nodes; ++n)
    for (std::size_t i = 0; i < out[n].size(); ++i) out[n][i] *= plan.transmission_spectrum[n][i];
  for (int source = 0; source < plan.first_lamp(); ++source)
    for (std::size_t n = 0; n < nodes; ++n) {
      const std::vector<double>& light = plan.source_spectrum[static_cast<std::size_t>(source) * nodes + n];
      for (std::size_t i = 0; i < light.size(); ++i) out[n][i] += together_weight(plan, source) * light[i];
    }
  return out;
}

std::size_t middle_node(const Plan& plan) { return static_cast<std::size_t>(plan.height.count / 2 * plan.view.count); }

double largest_of(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

Curves shares_of(const Plan& plan, const std::vector<double>& together) {
  const auto nodes = static_cast<std::size_t>(plan.height.count * plan.view.count);
  const std::size_t middle = middle_node(plan);
  const double least = least_light(together);
  Curves out;
  for (int source = 0; source < plan.first_lamp(); ++source) {
    const std::vector<double>& light = plan.source_spectrum[static_cast<std::size_t>(source) * nodes + middle];
    auto& share = out.emplace_back(light.size(), 0.0);
    for (std::size_t i = 0; i < light.size(); ++i)
      if (together[i] > least) share[i] = light[i] / together[i];
  }
  return out;
}

PathParts parts_of(const Plan& plan, const scene::CompiledScene& scene, PathFactors factors,
                   const std::vector<double>& together, const Curves& shares, const PathHeat& heat) {
  PathParts parts;
  parts.all = std::move(factors.curve), parts.owner = std::move(factors.owner);
  parts.curves = parts.all.size();
  add_seen(parts, plan, together);
  parts.warm_bands = parts.bands.size();
  for (const auto& share : shares)
    if (largest_of(share) > 0 || plan.lamps.sources() == 0) parts.all.push_back(share);
  if (plan.lamps.sources() > 0) parts.all.emplace_back(together.size(), 1.0);  // a lamp's share of its own light
  for (const auto& spectrum : plan.lamps.spectrum) add_seen(parts, plan, spectrum);
  if (parts.seen.empty()) parts.seen.assign(together.size(), 0.0), parts.bands = plan.bands;
  if (heat.any()) add_emitted(parts, heat, plan, scene);
  return parts;
}

double band_mean(const BandQuadrature& band, const double* values) {
  double sum = 0;
  for (std::size_t i = 0; i < band.weight.size(); ++i) sum += band.weight[i] * values[band.first + i];
  return sum;
}

Curves own_light(const PathParts& parts) {
  Curves out;
  for (std::size_t f = 0; f < parts.curves; ++f) {
    auto& own = out.emplace_back();
    const std::vector<double> shown = parts.shown(f);
    for (std::size_t b = 0; b < parts.bands.size(); ++b)
      own.push_back(band_mean(parts.bands[b], b < parts.warm_bands ? shown.data() : parts.all[f].data()));
    const double least = std::max(1e-100, 0.01 * *std::max_element(own.begin(), own.end()));  // its square is a number
    for (double& value : own) value = std::max(value, least);
  }
  return out;
}

}  // namespace raycube::plan
