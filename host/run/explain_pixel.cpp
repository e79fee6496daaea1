#include "host/run/explain_pixel.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <tuple>

#include "host/render/pixel_terms.h"
#include "kernels/shared/product_key.h"
#include "scene_compiler/matter.h"

namespace raycube::run {

namespace {

enum class Light { path, ground_around, sun, sky, thermal_sky, surroundings, emission, between_surfaces };
constexpr const char* kLights[] = {"path",        "ground_around", "sun",      "sky",
                                   "thermal_sky", "surroundings",  "emission", "between_surfaces"};

/// Light, curve of the material (0: none), number.
using Origin = std::tuple<Light, std::uint32_t, int>;

Origin origin_of(const plan::Plan& plan, const scene::CompiledScene& scene, const render::Term& term) {
  if (term.key == 0) return {Light::path, 0, 0};
  if ((term.key & plan::kSkeletonKey) == plan::kSkeletonKey) return {Light::between_surfaces, 0, 0};
  if (term.key & plan::kEnvironmentKey) return {Light::ground_around, 0, 0};
  const std::uint32_t curve = rc_key_curve(term.key, 0);
  const int source = static_cast<int>(term.channel) / (plan.height.count * plan.view.count);
  if (source < plan.first_component()) return {Light::sun, curve, 0};
  if (source >= plan.first_emission())  // a leaf's is 1 less both of its curves
    return {Light::emission, scene::reflectance_curve(scene, scene::material_of_curve(scene, curve)), 0};
  const int component = source - plan.first_component();
  if (component < plan.sky_components) return {Light::sky, curve, component + 1};
  if (component + 1 < plan.components()) return {Light::thermal_sky, curve, component - plan.sky_components + 1};
  return {Light::surroundings, curve, 0};
}

std::map<Origin, render::PixelTerms> by_origin(const plan::Plan& plan, const scene::CompiledScene& scene,
                                               const render::PixelTerms& terms) {
  std::map<Origin, render::PixelTerms> parts;
  for (const render::Term& term : terms) parts[origin_of(plan, scene, term)].push_back(term);
  return parts;
}

/// Light between surfaces by the number of surfaces after the first; `whole`: of all.
std::vector<std::vector<double>> by_order(const plan::Plan& plan, const std::vector<double>& whole,
                                          const std::function<std::vector<double>(int levels)>& up_to) {
  std::vector<std::vector<double>> orders;
  std::vector<double> before(whole.size(), 0.0);
  for (int level = 1; level <= plan.bounces.levels; ++level) {
    const std::vector<double> here = level == plan.bounces.levels ? whole : up_to(level);
    orders.push_back(here);
    for (std::size_t b = 0; b < here.size(); ++b) orders.back()[b] -= before[b];
    before = here;
  }
  return orders;
}

}  // namespace

PixelBudget explain_pixel(render::Renderer& renderer, const scene::Simulation& simulation, const CameraJob& job,
                          int line, int sample) {
  const scene::CompiledScene& scene = simulation.scene;
  const auto parts_of = [&](const plan::Plan& plan) {
    return renderer.parts_of(*job.instrument, plan, simulation.sun, simulation.seed, line, sample);
  };
  const auto light_of = [&](const render::PixelTerms& terms) { return render::sum_of_terms(job.plan, scene, terms); };
  const render::Renderer::PixelParts parts = parts_of(job.plan);
  PixelBudget out;
  out.rendered = parts.radiance;
  out.sum = light_of(parts.terms);
  for (const auto& [origin, terms] : by_origin(job.plan, scene, parts.terms)) {
    const auto [kind, curve, number] = origin;
    if (kind == Light::between_surfaces) {
      const auto up_to = [&](int levels) {
        plan::Plan fewer = job.plan;
        fewer.bounces.levels = levels;
        return light_of(by_origin(fewer, scene, parts_of(fewer).terms)[{Light::between_surfaces, 0, 0}]);
      };
      int order = 0;
      for (auto& light : by_order(job.plan, light_of(terms), up_to))
        out.light.push_back({kLights[static_cast<int>(kind)], ++order, {}, false, std::move(light)});
      continue;
    }
    PixelPart light{kLights[static_cast<int>(kind)], number, {}, false, light_of(terms)};
    if (curve > 0) {
      light.material = scene.materials[scene::material_of_curve(scene, curve)].name;
      light.through = rc_curve_role(curve, scene::material_count(scene)) == RC_CURVE_TRANSMITTANCE;
    }
    out.light.push_back(std::move(light));
  }
  for (std::size_t b = 0; b < out.sum.size(); ++b) {
    const double written = double{out.rendered[b]}, apart = std::abs(out.sum[b] - written);
    if (apart > 0) out.worst_difference = std::max(out.worst_difference, apart / std::abs(written));
  }
  return out;
}

}  // namespace raycube::run
