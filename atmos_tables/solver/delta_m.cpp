#include "atmos_tables/solver/delta_m.h"

#include <algorithm>

namespace raycube::atmos::solver {

ScaledLayer scale_layer(const Layer& layer, int streams, bool delta_m) {
  ScaledLayer scaled;
  const auto count = static_cast<std::size_t>(streams);
  scaled.moment.assign(count, 0.0);
  scaled.moment[0] = 1;
  for (std::size_t k = 1; k < std::min(count, layer.phase_moments.size()); ++k)
    scaled.moment[k] = layer.phase_moments[k];
  const double omega = std::clamp(layer.scattering_albedo, 0.0, 1.0);
  scaled.true_depth = layer.optical_depth;
  scaled.true_albedo = omega;
  double peak = delta_m && layer.phase_moments.size() > count ? layer.phase_moments[count] : 0;
  if (1 - peak < 1e-12) {  // all light goes straight on: the truncated problem keeps only the absorption
    scaled.depth = (1 - omega) * layer.optical_depth;
    return scaled;
  }
  scaled.truncation = peak;
  scaled.depth = (1 - omega * peak) * layer.optical_depth;
  // (1-f)/(1-omega f) is exactly 1 for omega = 1, so a conservative layer stays conservative to the last bit.
  scaled.albedo = omega * ((1 - peak) / (1 - omega * peak));
  scaled.source_albedo = omega / (1 - omega * peak);
  for (std::size_t k = 1; k < count; ++k) scaled.moment[k] = (scaled.moment[k] - peak) / (1 - peak);
  return scaled;
}

}  // namespace raycube::atmos::solver
