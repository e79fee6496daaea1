#include "host/plan/radiance_limit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/interpolate.h"
#include "host/base/planck.h"
#include "host/plan/quadrature.h"
#include "scene_compiler/matter.h"
#include "scene_compiler/shape_energy.h"
#include "scene_compiler/shape_list.h"
#include "scene_compiler/spectral_shape.h"

namespace raycube::plan {

namespace {

/// No air sends more than this back: a table that says so bounds nothing.
constexpr double kLargestReturn = 0.95;

/// Largest value of a row at each of the table's wavelengths; wavelength is the first axis.
std::vector<double> largest_of(const atmos::Row& row, std::size_t wavelengths) {
  const std::size_t inner = row.values.size() / wavelengths;
  std::vector<double> out;
  for (std::size_t i = 0; i < wavelengths; ++i) {
    const auto first = row.values.begin() + static_cast<std::ptrdiff_t>(i * inner);
    out.push_back(*std::max_element(first, first + static_cast<std::ptrdiff_t>(inner)));
  }
  return out;
}

/// Largest emission on the plan's grid: of used materials, and of the sky they mirror.
std::vector<double> largest_emission(const Plan& plan, const scene::CompiledScene& scene,
                                     const atmos::RenderTable& table) {
  std::vector<double> out(plan.wavelength_um.size(), 0.0);
  if (!plan.thermal.on) return out;
  double hottest_K = plan.thermal.surroundings_K;
  for (const auto material : scene::used_materials(scene))
    hottest_K = std::max(hottest_K, double{scene.materials[material].temperature_K});
  const auto& um = atmos::wavelengths(table);
  std::vector<double> sky(plan.wavelength_um.size(), 0.0);  // tables that end below 3 um hold none
  if (table.has("sky_radiance_thermal"))
    sky = atmos::resample_linear(um, largest_of(table.need("sky_radiance_thermal", "thermal light"), um.size()),
                                 plan.wavelength_um);
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = std::max(sky[i], base::planck_radiance(plan.wavelength_um[i], hottest_K));
  return out;
}

/// S of the air above the ground on the plan's grid, at the height where it is largest; 0 where the plan has no light
/// between ground and air.
std::vector<double> largest_return(const Plan& plan, const atmos::RenderTable& table) {
  std::vector<double> out(plan.wavelength_um.size(), 0.0);
  if (plan.environment.empty()) return out;
  const auto& um = atmos::wavelengths(table);
  out = atmos::resample_linear(
      um, largest_of(table.need("spherical_albedo", "light between ground and air"), um.size()), plan.wavelength_um);
  for (double& s : out) s = std::clamp(s, 0.0, kLargestReturn);
  return out;
}

/// How many times white paint's radiance the sun's mirror image has in a gloss, all light mirrored, at normal
/// incidence; GGX: pi D / 4, D = 1 / (pi roughness^2). Seen at a slant it may be more.
double mirror_image(const scene::Shape& shape) {
  const RcLocal up{0, 0, 1};
  const RcParameters p = rc_shape_widened(shape.number, shape.parameters(), scene::kLeastRoughness);
  const double mirrored = rc_shape_mirrored(shape.number, p, 1);
  const double pi_f = rc_shape_eval(shape.number, std::numbers::pi, p, rc_angles(up, up, up));
  return mirrored > 0 ? pi_f / mirrored : 0;
}

double largest_gloss(const scene::CompiledScene& scene) {
  double most = 0;
  for (const auto index : scene::used_materials(scene)) {
    for (const auto& part : scene::gloss_parts(scene.materials[index])) most = std::max(most, mirror_image(part.shape));
  }
  return most;
}

/// How many times white paint's radiance goes into the brightest direction of any used material's shape, 1 at least.
double largest_front(const scene::CompiledScene& scene) {
  double most = 1;
  for (const auto index : scene::used_families(scene)) {
    const scene::Material& material = scene.materials[index];
    if (scene::shape_entry(material.front.number).conserves || material.reflectance.value.empty()) continue;
    const double largest = *std::max_element(material.reflectance.value.begin(), material.reflectance.value.end());
    for (const auto& part : scene::front_parts(material))
      most = std::max(most, largest * scene::brightest_direction(part.shape));
  }
  return most;
}

/// Of all lamps, onto a white surface as near to each as lamps come.
void add_lamps(const Plan& plan, const scene::CompiledScene& scene, std::vector<double>& limit) {
  constexpr double kNearest_m = 0.01;
  const double factor = (largest_front(scene) + largest_gloss(scene)) / std::numbers::pi;
  std::vector<double> most(plan.lamps.spectrum.size(), 0.0);
  for (const shared::Lamp& lamp : plan.lamps.lamp)
    most[lamp.source] += static_cast<double>(lamp.position.w) / (kNearest_m * kNearest_m);
  for (std::size_t m = 0; m < most.size(); ++m)
    for (std::size_t i = 0; i < limit.size(); ++i) limit[i] += factor * most[m] * plan.lamps.spectrum[m][i];
}

}  // namespace

std::vector<double> radiance_limit(const Plan& plan, const scene::CompiledScene& scene,
                                   const atmos::RenderTable& table) {
  std::vector<double> limit = largest_emission(plan, scene, table);
  if (plan.sun_up && table.has("solar_irradiance")) {
    const auto e0 =
        atmos::resample_linear(atmos::wavelengths(table), atmos::solar_irradiance(table), plan.wavelength_um);
    const std::vector<double> back = largest_return(plan, table);
    const double mirrored = largest_gloss(scene), front = largest_front(scene);
    for (std::size_t i = 0; i < limit.size(); ++i)
      limit[i] += (front + mirrored) * e0[i] / (std::numbers::pi * (1 - back[i]));
  }
  add_lamps(plan, scene, limit);
  for (std::size_t i = 0; i < limit.size(); ++i) {
    double brightest = 0;
    for (const auto& spectrum : plan.path_spectrum) brightest = std::max(brightest, spectrum[i]);
    limit[i] += brightest;
  }
  return in_bands(plan.bands, limit);
}

}  // namespace raycube::plan
