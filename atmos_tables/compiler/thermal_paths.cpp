#include "atmos_tables/compiler/thermal_paths.h"

#include <algorithm>
#include <cmath>

#include "host/base/planck.h"

namespace raycube::atmos {

namespace {

/// Beyond this depth nothing reaches the observer (1e-13).
constexpr double kLastDepth = 30;
/// Below this depth of a layer the closed form loses digits and the mean of its edges is exact to 1e-9.
constexpr double kThinDepth = 1e-4;

/// Integral over 0..depth of (near + (far - near) t / depth) exp(-t) dt.
double graded_emission(double near, double far, double depth) {
  if (depth < kThinDepth) return 0.5 * (near + far) * depth;
  const double lost = -std::expm1(-depth);
  return near * lost + (far - near) * (lost / depth - std::exp(-depth));
}

/// Layers from the observer on, as indices; level on the observer's side and beyond it.
struct Crossing {
  std::size_t layer, near, far;
};
std::vector<Crossing> crossings(std::size_t low, std::size_t high, bool observer_above) {
  std::vector<Crossing> out;
  for (std::size_t i = low; i < high; ++i) {
    const std::size_t layer = observer_above ? low + high - 1 - i : i;
    out.push_back({layer, observer_above ? layer + 1 : layer, observer_above ? layer : layer + 1});
  }
  return out;
}

}  // namespace

double path_emission(const SpectralAir& air, const AirStack& stack, const std::vector<double>& path_factor,
                     std::size_t low, std::size_t high, bool observer_above, LayerEmission rule) {
  const double wavelength = air.bin().wavelength_um;
  const auto planck = [&](double temperature_K) { return base::planck_radiance(wavelength, temperature_K); };
  std::vector<double> crossed(path_factor.size(), 0.0);
  double grey = 0, lines = 0, sum = 0;
  for (const Crossing& step : crossings(low, high, observer_above)) {
    const double before = grey + lines;
    if (before > kLastDepth) break;
    crossed[step.layer] = path_factor[step.layer];
    const double layer_grey = path_factor[step.layer] * air.layer_extinction(step.layer);
    // The depth of a band model may fall by rounding when a layer that holds next to nothing is added.
    const double layer_lines = std::max(0.0, air.line_depth(crossed) - lines);
    const double depth = layer_grey + layer_lines;
    grey += layer_grey, lines += layer_lines;
    if (!(depth > 0)) continue;
    if (rule == LayerEmission::one_temperature) {
      sum += std::exp(-before) * -std::expm1(-depth) * planck(stack.mean_temperature_K(step.layer));
    } else {
      const double emits = 1 - path_factor[step.layer] * air.layer_scattering(step.layer) / depth;
      sum += std::exp(-before) * std::max(0.0, emits) *
             graded_emission(planck(stack.temperature_K(step.near)), planck(stack.temperature_K(step.far)), depth);
    }
  }
  return sum;
}

double term_emission(const SpectralAir& air, const AirStack& stack, std::size_t term, double cosine, std::size_t low,
                     std::size_t high, bool observer_above) {
  const double wavelength = air.bin().wavelength_um;
  double before = 0, sum = 0;
  for (const Crossing& step : crossings(low, high, observer_above)) {
    if (before > kLastDepth) break;
    const double vertical = air.depth_between(term, step.layer, step.layer + 1), depth = vertical / cosine;
    if (!(depth > 0)) continue;
    const double emits = 1 - air.layer_scattering(step.layer) / vertical;
    sum += std::exp(-before) * emits *
           graded_emission(base::planck_radiance(wavelength, stack.temperature_K(step.near)),
                           base::planck_radiance(wavelength, stack.temperature_K(step.far)), depth);
    before += depth;
  }
  return sum;
}

}  // namespace raycube::atmos
