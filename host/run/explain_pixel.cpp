#include "host/run/explain_pixel.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <tuple>

#include "host/plan/band_truth.h"
#include "host/render/pixel_terms.h"
#include "kernels/shared/product_key.h"
#include "scene_compiler/matter.h"

namespace raycube::run {

namespace {

constexpr int kOrdersApart = 8;  ///< each takes a render of the pixel's group

/// Part of the radiance, curve of the material (0: none), number.
using Origin = std::tuple<scene::BandTruth, std::uint32_t, int>;

Origin origin_of(const plan::Plan& plan, const scene::CompiledScene& scene, const render::Term& term) {
  using enum scene::BandTruth;
  const scene::BandTruth kind = plan::light_kind(plan, term.key, static_cast<int>(term.channel));
  if (kind == path || kind == between_surfaces || kind == ground_around) return {kind, 0, 0};
  const std::uint32_t member = rc_key_curve(term.key, 0);
  // Members of a family are one material, and their curves follow one another.
  const std::uint32_t first = scene::material_of_curve(scene, member),
                      material = first - scene.materials[first].in_family;
  const std::uint32_t curve = scene::is_of_front(scene, member)   ? scene::reflectance_curve(scene, material)
                              : scene::is_of_gloss(scene, member) ? scene::gloss_curve(scene, material)
                                                                  : scene::transmittance_curve(scene, material);
  if (kind == emission)  // a leaf's is 1 less both of its curves
    return {kind, scene::reflectance_curve(scene, scene::material_of_curve(scene, curve)), 0};
  const int component = static_cast<int>(term.channel) / (plan.height.count * plan.view.count) - plan.first_component();
  return {kind, curve,
          kind == sky           ? component + 1
          : kind == thermal_sky ? component - plan.sky_components + 1
          : kind == lamps       ? component - plan.components() + 1
                                : 0};
}

std::map<Origin, render::PixelTerms> by_origin(const plan::Plan& plan, const scene::CompiledScene& scene,
                                               const render::PixelTerms& terms) {
  std::map<Origin, render::PixelTerms> parts;
  for (const render::Term& term : terms) parts[origin_of(plan, scene, term)].push_back(term);
  return parts;
}

/// Light between surfaces by the number of surfaces after the first; `whole`: of all. The last is what is left.
std::vector<std::vector<double>> by_order(const plan::Plan& plan, const std::vector<double>& whole,
                                          const std::function<std::vector<double>(int levels)>& up_to) {
  std::vector<std::vector<double>> orders;
  std::vector<double> before(whole.size(), 0.0);
  const int last = std::min(plan.bounces.levels, kOrdersApart + 1);
  for (int level = 1; level <= last; ++level) {
    const std::vector<double> here = level == last ? whole : up_to(level);
    orders.push_back(here);
    for (std::size_t b = 0; b < here.size(); ++b) orders.back()[b] -= before[b];
    before = here;
  }
  return orders;
}

}  // namespace

PixelBudget explain_pixel(render::Renderer& renderer, const scene::Simulation& simulation, const CameraJob& job,
                          int line, int sample) {
  using enum scene::BandTruth;
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
    if (kind == between_surfaces) {
      const auto up_to = [&](int levels) {
        plan::Plan fewer = job.plan;
        fewer.bounces.levels = levels;
        return light_of(by_origin(fewer, scene, parts_of(fewer).terms)[{between_surfaces, 0, 0}]);
      };
      int order = 0;
      for (auto& light : by_order(job.plan, light_of(terms), up_to))
        out.light.push_back({.kind = kind, .number = ++order, .radiance = std::move(light)});
      out.light.back().and_more = job.plan.bounces.levels > order;
      continue;
    }
    PixelPart light{.kind = kind, .number = number, .radiance = light_of(terms)};
    if (curve > 0) {
      light.material = scene.materials[scene::material_of_curve(scene, curve)].name;
      const rc_id role = rc_curve_role(curve, scene::material_count(scene));
      light.through = role == RC_CURVE_TRANSMITTANCE, light.gloss = role == RC_CURVE_GLOSS;
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
