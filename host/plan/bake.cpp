#include <algorithm>
#include <cmath>
#include <string>

#include "host/base/error.h"
#include "host/plan/curve.h"
#include "host/plan/plan.h"
#include "kernels/shared/tile_layout.h"

namespace raycube::plan {

namespace {

/// Sum of the parts' curves, by environment function, times the light that each brings to the sensor.
std::vector<std::vector<double>> environment_spectra(const Plan& plan, std::size_t node) {
  const EnvironmentMap& map = plan.environment;
  if (node >= map.nodes())
    throw base::Error(base::Fault::bug,
                      "bake_row: environment " + std::to_string(node) + " of " + std::to_string(map.nodes()));
  const std::size_t grid = plan.wavelength_um.size(), channels = static_cast<std::size_t>(plan.environment_channels());
  std::vector<double> molecules(grid, 0.0), aerosol(grid, 0.0);
  for (std::size_t p = map.first_part[node]; p < map.first_part[node + 1]; ++p) {
    const auto& part = map.part[p];
    const auto& reflectance = map.reflectance[part.curve - 1];
    for (std::size_t i = 0; i < grid; ++i) molecules[i] += part.molecules * reflectance[i];
    for (std::size_t i = 0; i < grid; ++i) aerosol[i] += part.aerosol * reflectance[i];
  }
  std::vector<std::vector<double>> out(channels, std::vector<double>(grid));
  for (std::size_t c = 0; c < channels; ++c)
    for (std::size_t i = 0; i < grid; ++i)
      out[c][i] =
          molecules[i] * plan.environment_spectrum[c][i] + aerosol[i] * plan.environment_spectrum[channels + c][i];
  return out;
}

}  // namespace

std::vector<float> bake_row(const Plan& plan, const scene::CompiledScene& scene, std::uint64_t key) {
  const std::size_t bands = plan.bands.size(), padded = RC_PADDED(bands);
  const bool around = (key & kEnvironmentKey) != 0;
  const std::uint64_t curve = around ? 0 : key;
  const auto environment = around ? environment_spectra(plan, static_cast<std::size_t>(key ^ kEnvironmentKey))
                                  : std::vector<std::vector<double>>{};
  const auto& spectra = around ? environment : curve == 0 ? plan.path_spectrum : plan.source_spectrum;
  std::vector<double> reflectance(plan.wavelength_um.size(), 1.0);
  if (curve > 0) {
    if (curve > scene.materials.size())
      throw base::Error(base::Fault::bug,
                        "bake_row: curve " + std::to_string(curve) + " of " + std::to_string(scene.materials.size()));
    reflectance = sample_curve(scene.materials[curve - 1], plan.wavelength_um);
  }
  std::vector<double> emissivity;
  if (curve > 0 && plan.thermal.on)
    for (const double r : reflectance) emissivity.push_back(1 - r);
  const auto first_emission = static_cast<std::size_t>(plan.first_emission() * plan.height.count * plan.view.count);
  std::vector<float> out(spectra.size() * padded, 0.0f);
  for (std::size_t c = 0; c < spectra.size(); ++c) {
    const std::vector<double>& factor = curve > 0 && c >= first_emission ? emissivity : reflectance;
    for (std::size_t b = 0; b < bands; ++b) {
      const auto& band = plan.bands[b];
      double sum = 0;
      for (std::size_t i = 0; i < band.weight.size(); ++i)
        sum += band.weight[i] * factor[band.first + i] * spectra[c][band.first + i];
      out[c * padded + b] = static_cast<float>(sum);
    }
  }
  return out;
}

}  // namespace raycube::plan
