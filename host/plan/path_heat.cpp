#include "host/plan/path_heat.h"

#include <algorithm>

#include "host/plan/thermal_plan.h"
#include "scene_compiler/matter.h"

namespace raycube::plan {

namespace {

constexpr double kLeastLight = 1e-9;  ///< of the largest

}  // namespace

double least_light(const std::vector<double>& together) {
  return together.empty() ? 0 : kLeastLight * *std::max_element(together.begin(), together.end());
}

std::vector<double> hottest_light(const Plan& plan, const scene::CompiledScene& scene) {
  double kelvin = 0;
  if (plan.thermal.on)
    for (const auto number : scene::used_materials(scene))
      kelvin = std::max(kelvin, scene.materials[number].temperature_K);
  if (!(kelvin > 0)) return std::vector<double>(plan.wavelength_um.size(), 0.0);
  return planck_spectrum(plan.wavelength_um, kelvin);
}

PathHeat path_heat(const Plan& plan, const scene::CompiledScene& scene, const std::vector<double>& together) {
  PathHeat out;
  if (!plan.thermal.on) return out;
  const std::vector<double>& through =
      plan.transmission_spectrum[static_cast<std::size_t>(plan.height.count / 2 * plan.view.count)];
  const double least = least_light(together);
  const auto at_sensor = [&](double kelvin) {
    std::vector<double> light(together.size(), 0.0);
    if (kelvin > 0) light = planck_spectrum(plan.wavelength_um, kelvin);
    for (std::size_t i = 0; i < light.size(); ++i) light[i] *= together[i] > least ? through[i] / together[i] : 0;
    return light;
  };
  out.surroundings = at_sensor(plan.thermal.surroundings_K);
  out.excess.resize(scene.materials.size());
  for (const auto number : scene::used_materials(scene)) {
    auto& excess = out.excess[number] = at_sensor(scene.materials[number].temperature_K);
    for (std::size_t i = 0; i < excess.size(); ++i) excess[i] -= out.surroundings[i];
  }
  return out;
}

}  // namespace raycube::plan
