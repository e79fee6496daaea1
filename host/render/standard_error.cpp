#include "host/render/standard_error.h"

#include <algorithm>
#include <cmath>

#include "host/sensors/psf.h"

namespace raycube::render {

namespace {
constexpr double kLeastBand = 1e-4;  ///< of the brightest band's mean
/// Standard error over that of four independent parts, by measurement (standard_error.h).
constexpr double kLatticeFactor = 0.7, kCellFactor = 0.85;
}  // namespace

double spread_of_draws(scene::SamplerKind sampler) {
  return 1 / (sampler == scene::SamplerKind::lattice ? kLatticeFactor : kCellFactor);
}

double error_of_spread(scene::SamplerKind sampler) {
  const double independent = 1 / std::sqrt(sensors::kSampleSubsets * (sensors::kSampleSubsets - 1.0));
  return independent / spread_of_draws(sampler);
}

std::vector<float> error_scale(const std::vector<double>& band_means) {
  const double largest = band_means.empty() ? 0 : *std::max_element(band_means.begin(), band_means.end());
  std::vector<float> scale;
  for (const double mean : band_means) scale.push_back(static_cast<float>(std::max(mean, kLeastBand * largest)));
  return scale;
}

float worst_error(const float* band_error, const std::vector<float>& scale) {
  float worst = 0;
  for (std::size_t b = 0; b < scale.size(); ++b) {
    const float error = band_error[b] == 0 ? 0 : band_error[b] / scale[b];
    if (std::isnan(error)) return error;
    worst = std::max(worst, error);
  }
  return worst;
}

}  // namespace raycube::render
