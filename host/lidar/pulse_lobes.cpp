#include "host/lidar/pulse_lobes.h"

#include <algorithm>

#include "host/plan/curve.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::lidar {

namespace {

/// Places in Matter::lobe: the first of what is reflected, of the gloss, then the further ones.
constexpr std::size_t kFront = 0, kGloss = 1, kFurther = 2;
/// Of what is left of a line's light, at least, by a gloss.
constexpr double kLeastMirrored = 1e-3;

/// Mean over a line of a curve.
double line_mean(const LidarPlan& plan, const scene::Material& material, const scene::Curve& curve, std::size_t line) {
  double sum = 0;
  for (const SpectralNode& node : plan.nodes)
    if (static_cast<std::size_t>(node.line) == line)
      sum += node.weight * plan::sample_curve(material, curve, {node.wavelength_um}).front();
  return sum;
}

const Matter& matter_of(const LidarPlan& plan, std::size_t material, int line) {
  return plan.matter[material * static_cast<std::size_t>(plan.lines()) + static_cast<std::size_t>(line)];
}

double factor(const Matter& matter, std::size_t lobe) { return matter.lobe.empty() ? 1 : matter.lobe[lobe]; }

double eval(const scene::Shape& shape, double scale, const RcAngles& angles) {
  return rc_shape_eval(shape.number, scale, shape.parameters(), angles);
}

/// Share of a lobe of what a surface reflects, or mirrors, of a line.
double share_of(const LidarPlan& plan, const scene::CompiledScene& scene, const shared::Surface& surface, int line,
                std::size_t lobe, bool gloss) {
  double sum = 0, whole = 0;
  scene::for_each_material(surface, [&](std::size_t index, float fraction) {
    const Matter& matter = matter_of(plan, index, line);
    const double part = static_cast<double>(fraction) * (gloss ? 1 : matter.reflectance);
    const bool has = lobe < kFurther || lobe - kFurther < scene.materials[index].further.size();
    sum += has ? part * factor(matter, lobe) : 0, whole += part;
  });
  if (gloss) return sum;
  return whole > 0 ? sum / whole : 0;
}

}  // namespace

Matter matter_at(const LidarPlan& plan, const scene::Material& material, std::size_t line) {
  Matter out;
  for (const auto& part : scene::front_parts(material)) out.reflectance += line_mean(plan, material, part.curve, line);
  if (!material.transmittance.wavelength_um.empty())
    out.transmittance = line_mean(plan, material, material.transmittance, line);
  for (const auto& part : scene::gloss_parts(material))
    out.mirrored +=
        line_mean(plan, material, part.curve, line) * rc_shape_mirrored(part.shape.number, part.shape.parameters(), 1);
  // One that mirrors nothing upright mirrors towards the horizon: paths must find it.
  if (material.gloss.number != RC_SHAPE_none)
    out.mirrored = std::max(out.mirrored, kLeastMirrored * std::max(0.0, 1 - out.reflectance - out.transmittance));
  if (material.further.empty()) return out;
  const auto of_reflected = [&](const scene::Curve& curve) {
    return out.reflectance > 0 ? line_mean(plan, material, curve, line) / out.reflectance : 0;
  };
  const auto front = scene::front_parts(material), gloss = scene::gloss_parts(material);
  out.lobe = {of_reflected(front.front().curve),
              gloss.empty() ? 0 : line_mean(plan, material, gloss.front().curve, line)};
  for (const scene::FurtherLobe& lobe : material.further)
    out.lobe.push_back(scene::is_gloss(lobe.shape) ? line_mean(plan, material, lobe.curve, line)
                                                   : of_reflected(lobe.curve));
  return out;
}

double front_form(const LidarPlan& plan, const scene::CompiledScene& scene, std::uint32_t surface, int line,
                  const RcAngles& angles) {
  double sum = 0, reflectance = 0;
  scene::for_each_material(scene.surfaces[surface], [&](std::size_t index, float fraction) {
    const scene::Material& material = scene.materials[index];
    const Matter& matter = matter_of(plan, index, line);
    double form = eval(material.front, factor(matter, kFront), angles);
    for (std::size_t t = 0; t < material.further.size(); ++t)
      if (!scene::is_gloss(material.further[t].shape))
        form += eval(material.further[t].shape, factor(matter, kFurther + t), angles);
    sum += static_cast<double>(fraction) * matter.reflectance * form;
    reflectance += static_cast<double>(fraction) * matter.reflectance;
  });
  return reflectance > 0 ? sum / reflectance : 0;
}

double gloss_form(const LidarPlan& plan, const scene::CompiledScene& scene, std::uint32_t surface, int line,
                  const RcAngles& angles) {
  double sum = 0;
  scene::for_each_material(scene.surfaces[surface], [&](std::size_t index, float fraction) {
    const scene::Material& material = scene.materials[index];
    if (material.gloss.number == RC_SHAPE_none) return;
    const Matter& matter = matter_of(plan, index, line);
    sum += eval(material.gloss, static_cast<double>(fraction) * factor(matter, kGloss), angles);
    for (std::size_t t = 0; t < material.further.size(); ++t)
      if (scene::is_gloss(material.further[t].shape))
        sum += eval(material.further[t].shape, static_cast<double>(fraction) * factor(matter, kFurther + t), angles);
  });
  return sum;
}

double gloss_alpha(const scene::CompiledScene& scene, std::uint32_t surface) {
  double alpha = 0;
  scene::for_each_material(scene.surfaces[surface], [&](std::size_t index, float) {
    for (const auto& part : scene::gloss_parts(scene.materials[index]))
      alpha = std::max(alpha, rc_shape_roughness(part.shape.number, part.shape.parameters()));
  });
  return alpha;
}

bool has_line_lobes(const scene::CompiledScene& scene) { return scene::most_further(scene) > 0; }

std::vector<shared::Lobe> pulse_lobes(const LidarPlan& plan, const scene::CompiledScene& scene) {
  if (!has_line_lobes(scene)) return scene::surface_lobes(scene);
  return scene::surface_lobes(
      scene, static_cast<std::size_t>(plan.lines()),
      [&](std::size_t line, const shared::Surface& surface, std::size_t record, const scene::Shape& shape) {
        const auto at = static_cast<int>(line);
        const bool of_gloss = record > 0 && record < RC_LOBE_BEHIND;
        if (of_gloss) return factor(matter_of(plan, surface.material[record - 1] - 1, at), kGloss);
        const std::size_t lobe = record == 0 ? kFront : kFurther + record - RC_LOBES;
        return share_of(plan, scene, surface, at, lobe, scene::is_gloss(shape));
      });
}

}  // namespace raycube::lidar
