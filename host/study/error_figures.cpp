#include "host/study/error_figures.h"

#include <algorithm>
#include <cmath>

#include "host/base/error.h"

namespace raycube::study {

namespace {

constexpr double kFloor = 1e-4;  ///< of the largest band mean (DESIGN 5a)

std::vector<double> divisors(const Converged& reference) {
  std::vector<double> mean(reference.bands, 0.0);
  for (std::size_t i = 0; i < reference.radiance.size(); ++i) mean[i % reference.bands] += reference.radiance[i];
  for (double& m : mean) m /= static_cast<double>(std::max<std::size_t>(1, reference.pixels()));
  const double largest = mean.empty() ? 0 : *std::max_element(mean.begin(), mean.end());
  for (double& m : mean) m = std::max(m, kFloor * largest);
  return mean;
}

double rms_of(const std::vector<double>& values, std::size_t bands, std::size_t band) {
  double sum = 0;
  for (std::size_t i = band; i < values.size(); i += bands) sum += values[i] * values[i];
  return std::sqrt(sum / static_cast<double>(std::max<std::size_t>(1, values.size() / bands)));
}

}  // namespace

ErrorFigures error_of(const Converged& reference, const std::vector<float>& radiance) {
  const std::size_t bands = reference.bands, pixels = reference.pixels();
  if (radiance.size() != reference.radiance.size() || pixels == 0)
    throw base::Error(base::Fault::bug, "error_of: " + std::to_string(radiance.size()) + " radiances for " +
                                            std::to_string(reference.radiance.size()) + " of the reference");
  const std::vector<double> divisor = divisors(reference);
  std::vector<double> difference(radiance.size());
  for (std::size_t i = 0; i < difference.size(); ++i)
    difference[i] = (static_cast<double>(radiance[i]) - reference.radiance[i]) / divisor[i % bands];
  ErrorFigures out;
  for (std::size_t b = 0; b < bands; ++b) {
    const double error = rms_of(difference, bands, b);
    out.rms += error * error / static_cast<double>(bands);
    if (b == 0 || error > out.worst || std::isnan(error)) out.worst = error, out.band = b;
  }
  out.rms = std::sqrt(out.rms);
  out.own = rms_of(reference.half, bands, out.band) / divisor[out.band];
  std::vector<double> sizes;
  for (std::size_t p = 0; p < pixels; ++p) sizes.push_back(std::abs(difference[p * bands + out.band]));
  const std::size_t at = static_cast<std::size_t>(std::ceil(0.95 * static_cast<double>(pixels))) - 1;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(at), sizes.end());
  out.p95 = sizes[at];
  // Standard error of a root mean square: half that of the mean square, over the rms.
  double spread = 0;
  for (const double s : sizes) spread += std::pow(s * s - out.worst * out.worst, 2);
  const double n = static_cast<double>(pixels);
  const double standard = out.worst > 0 && n > 1 ? 0.5 * std::sqrt(spread / (n - 1) / n) / out.worst : 0;
  out.low = std::max(0.0, std::sqrt(std::max(0.0, out.worst * out.worst - out.own * out.own)) - standard);
  out.high = out.worst + standard;
  return out;
}

double own_error(const Converged& reference) {
  const std::vector<double> divisor = divisors(reference);
  double worst = 0;
  for (std::size_t b = 0; b < reference.bands; ++b)
    worst = std::max(worst, rms_of(reference.half, reference.bands, b) / divisor[b]);
  return worst;
}

}  // namespace raycube::study
