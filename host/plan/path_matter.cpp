// What paths between surfaces ask of matter: by which side they leave it, how much they may carry, its curves at the
// wavelengths along them.
#include <algorithm>
#include <cstddef>
#include <vector>

#include "host/plan/bounces.h"
#include "host/plan/curve.h"
#include "kernels/shared/tile_layout.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/shape_energy.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::plan {

namespace {

constexpr double kFewest = 0.1, kMost = 0.9;  ///< chance of the side by which a path leaves a leaf
constexpr double kGrazing = 0.05;             ///< hemispherical mean of Schlick's rise of a gloss, (1 - cos)^5, about

/// Chance p of the near side that makes the largest R^2 / p + T^2 / (1 - p) smallest: what a path carries varies least.
double near_chance(const std::vector<double>& reflected, const std::vector<double>& through) {
  const double r = *std::max_element(reflected.begin(), reflected.end()),
               t = *std::max_element(through.begin(), through.end());
  if (t <= 0) return 1;
  if (r <= 0) return 0;
  double best = 0.5, least = 1e300;
  for (double p = kFewest; p <= kMost + 1e-9; p += 0.01) {
    double worst = 0;
    for (std::size_t i = 0; i < reflected.size(); ++i)
      worst = std::max(worst, reflected[i] * reflected[i] / p + through[i] * through[i] / (1 - p));
    if (worst < least) least = worst, best = p;
  }
  return best;
}

}  // namespace

std::vector<shared::rc_float4> surface_scattering(const scene::CompiledScene& scene, const std::vector<float>& curve,
                                                  std::size_t count) {
  const std::size_t padded = RC_PADDED(count);
  std::vector<shared::rc_float4> out;
  for (const shared::Surface& surface : scene.surfaces) {
    std::vector<double> side[2] = {std::vector<double>(count, 0.0), std::vector<double>(count, 0.0)};
    scene::for_each_material(surface, [&](std::size_t material, float fraction) {
      // What a shape may send beyond its curve, paths may carry: else they would end too early, and weigh too much.
      const auto add = [&](std::vector<double>& to, std::uint32_t id, double most) {
        for (std::size_t m = 0; m < count; ++m)
          to[m] += most * static_cast<double>(fraction) * static_cast<double>(curve[(id - 1) * padded + m]);
      };
      const scene::Material& of = scene.materials[material];
      add(side[0], scene::reflectance_curve(scene, material), scene::most_albedo(of.front).albedo);
      for (std::size_t t = 0; t < of.further.size(); ++t)
        if (!scene::is_gloss(of.further[t].shape))
          add(side[0], scene::further_curve(scene, material, t), scene::most_albedo(of.further[t].shape).albedo);
      add(side[1], scene::transmittance_curve(scene, material), 1);
    });
    double largest = 0;
    for (std::size_t m = 0; m < count; ++m) largest = std::max(largest, side[0][m] + side[1][m]);
    shared::rc_float4 law{};
    law.x = static_cast<float>(near_chance(side[0], side[1])), law.y = static_cast<float>(largest);
    scene::for_each_material(surface, [&](std::size_t material, float) {
      double f0 = -1;
      for (const auto& part : scene::gloss_parts(scene.materials[material])) f0 = std::max(f0, part.shape.parameter[1]);
      if (f0 < 0) return;
      const double mirrored = f0 + kGrazing * (1 - f0);
      law.z = static_cast<float>(std::clamp(mirrored / (mirrored + largest), kFewest, kMost));
    });
    out.push_back(law);
  }
  return out;
}

std::vector<float> sampled_curves(const scene::CompiledScene& scene, const std::vector<double>& at_um) {
  const std::size_t padded = RC_PADDED(at_um.size());
  std::vector<float> out(scene::curve_count(scene) * padded, 0.0f);
  const auto sample = [&](const scene::Material& material, std::uint32_t curve) {
    for (std::size_t m = 0; m < at_um.size(); ++m)
      out[(curve - 1) * padded + m] =
          static_cast<float>(sample_curve(material, scene::curve_of(scene, curve), {at_um[m]}).front());
  };
  for (const auto number : scene::used_materials(scene)) {
    const scene::Material& material = scene.materials[number];
    sample(material, scene::reflectance_curve(scene, number));
    if (scene::lets_light_through(material) || scene::is_plate(material))
      sample(material, scene::transmittance_curve(scene, number));
    if (material.gloss.number != RC_SHAPE_none) sample(material, scene::gloss_curve(scene, number));
    for (std::size_t t = 0; t < material.further.size(); ++t) sample(material, scene::further_curve(scene, number, t));
  }
  return out;
}

}  // namespace raycube::plan
