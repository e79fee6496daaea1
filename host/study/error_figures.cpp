#include "host/study/error_figures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/base/error.h"

namespace raycube::study {

namespace {

constexpr double kFloor = 1e-4;  ///< of the largest band mean (DESIGN 5a)

constexpr double kHigh = 0.95, kP99 = 0.99;

double weight_of(const Converged& reference, std::size_t pixel) {
  return reference.weight.empty() ? 1 : static_cast<double>(reference.weight[pixel]);
}

double weights_of(const Converged& reference) {
  double sum = 0;
  for (std::size_t p = 0; p < reference.pixels(); ++p) sum += weight_of(reference, p);
  return sum > 0 ? sum : 1;
}

std::vector<double> divisors(const Converged& reference) {
  std::vector<double> mean(reference.bands, 0.0);
  for (std::size_t i = 0; i < reference.radiance.size(); ++i)
    mean[i % reference.bands] += weight_of(reference, i / reference.bands) * reference.radiance[i];
  for (double& m : mean) m /= weights_of(reference);
  const double largest = mean.empty() ? 0 : *std::max_element(mean.begin(), mean.end());
  for (double& m : mean) m = std::max(m, kFloor * largest);
  return mean;
}

double rms_of(const Converged& reference, const std::vector<double>& values, std::size_t band) {
  double sum = 0;
  for (std::size_t p = 0; p < reference.pixels(); ++p)
    sum += weight_of(reference, p) * values[p * reference.bands + band] * values[p * reference.bands + band];
  return std::sqrt(sum / weights_of(reference));
}

/// The least size that pixels of this share of all the weight do not exceed.
double size_at(const Converged& reference, const std::vector<double>& values, std::size_t band, double share) {
  std::vector<std::pair<double, double>> sizes;
  for (std::size_t p = 0; p < reference.pixels(); ++p)
    if (const double weight = weight_of(reference, p); weight > 0)
      sizes.emplace_back(std::abs(values[p * reference.bands + band]), weight);
  std::sort(sizes.begin(), sizes.end());
  const double enough = share * weights_of(reference) * (1 - 1e-12);
  double reached = 0;
  for (const auto& [size, weight] : sizes)
    if ((reached += weight) >= enough) return size;
  return sizes.empty() ? 0 : sizes.back().first;
}

double figure_of(const Converged& reference, const std::vector<double>& values, std::size_t band) {
  if (reference.figure == scene::ErrorFigure::rms) return rms_of(reference, values, band);
  return size_at(reference, values, band, reference.figure == scene::ErrorFigure::p99 ? kP99 : 1);
}

/// Pixels that the weights are worth.
double pixels_worth(const Converged& reference) {
  double squares = 0;
  for (std::size_t p = 0; p < reference.pixels(); ++p) squares += std::pow(weight_of(reference, p), 2);
  return squares > 0 ? std::pow(weights_of(reference), 2) / squares : 1;
}

/// low and high of the worst band.
void add_bar(const Converged& reference, const std::vector<double>& difference, ErrorFigures& out) {
  const double n = pixels_worth(reference);
  if (reference.figure == scene::ErrorFigure::worst) {
    out.low = std::max(0.0, out.worst - out.own), out.high = out.worst + out.own;
    return;
  }
  if (reference.figure == scene::ErrorFigure::p99) {
    const double standard = std::sqrt(kP99 * (1 - kP99) / n);
    const double low = size_at(reference, difference, out.band, kP99 - standard);
    out.low = std::sqrt(std::max(0.0, low * low - out.own * out.own));
    out.high = size_at(reference, difference, out.band, std::min(1.0, kP99 + standard));
    return;
  }
  // Standard error of a root mean square: half that of the mean square, over the rms.
  double spread = 0;
  for (std::size_t p = 0; p < reference.pixels(); ++p)
    spread += weight_of(reference, p) *
              std::pow(std::pow(difference[p * reference.bands + out.band], 2) - out.worst * out.worst, 2);
  spread *= n / weights_of(reference);
  const double standard = out.worst > 0 && n > 1 ? 0.5 * std::sqrt(spread / (n - 1) / n) / out.worst : 0;
  out.low = std::max(0.0, std::sqrt(std::max(0.0, out.worst * out.worst - out.own * out.own)) - standard);
  out.high = out.worst + standard;
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
    const double error = figure_of(reference, difference, b), rms = rms_of(reference, difference, b);
    out.rms += rms * rms / static_cast<double>(bands);
    if (b == 0 || error > out.worst || std::isnan(error)) out.worst = error, out.band = b;
  }
  out.rms = std::sqrt(out.rms);
  out.own = figure_of(reference, reference.half, out.band) / divisor[out.band];
  out.p95 = size_at(reference, difference, out.band, kHigh);
  add_bar(reference, difference, out);
  return out;
}

double own_error(const Converged& reference) {
  const std::vector<double> divisor = divisors(reference);
  double worst = 0;
  for (std::size_t b = 0; b < reference.bands; ++b)
    worst = std::max(worst, figure_of(reference, reference.half, b) / divisor[b]);
  return worst;
}

}  // namespace raycube::study
