#include <algorithm>
#include <cmath>
#include <string>

#include "host/base/error.h"
#include "host/plan/curve.h"
#include "host/plan/plan.h"

namespace raycube::plan {

std::vector<float> bake_row(const Plan& plan, const scene::CompiledScene& scene, std::uint32_t curve) {
  const std::size_t bands = plan.bands.size(), padded = (bands + 15) / 16 * 16;
  const auto& spectra = curve == 0 ? plan.path_spectrum : plan.source_spectrum;
  std::vector<double> reflectance(plan.wavelength_um.size(), 1.0);
  if (curve > 0) {
    if (curve > scene.materials.size())
      throw base::Error(base::Fault::bug, "bake_row: curve " + std::to_string(curve) + " of " + std::to_string(scene.materials.size()));
    reflectance = sample_curve(scene.materials[curve - 1], plan.wavelength_um);
  }
  std::vector<float> out(spectra.size() * padded, 0.0f);
  for (std::size_t c = 0; c < spectra.size(); ++c)
    for (std::size_t b = 0; b < bands; ++b) {
      const auto& band = plan.bands[b];
      double sum = 0;
      for (std::size_t i = 0; i < band.weight.size(); ++i)
        sum += band.weight[i] * reflectance[band.first + i] * spectra[c][band.first + i];
      out[c * padded + b] = static_cast<float>(sum);
    }
  return out;
}

}  // namespace raycube::plan
