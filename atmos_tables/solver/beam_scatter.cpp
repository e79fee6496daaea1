#include "atmos_tables/solver/beam_scatter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/solver/exp_differences.h"
#include "atmos_tables/solver/legendre.h"
#include "atmos_tables/solver/path_integrals.h"

namespace raycube::atmos::solver {
namespace {

/// The small-angle expansion holds in the aureole: whole within 10 degrees of the beam, fading to nothing at
/// 20, smooth in between so that radiance stays continuous.
double aureole_weight(double cos_angle) {
  constexpr double kWhole = 10 * std::numbers::pi / 180, kNone = 20 * std::numbers::pi / 180;
  const double part =
      std::clamp((kNone - std::acos(std::clamp(cos_angle, -1.0, 1.0))) / (kNone - kWhole), 0.0, 1.0);
  return part * part * (3 - 2 * part);
}

}  // namespace

double once_scattered(const BeamColumn& column, double cosine, bool up, double cos_angle,
                      const Place& place) {
  const std::size_t count = column.scaled->size();
  if (count == 0 || column.flux <= 0) return 0;
  const Column& air = *column.column;
  const std::vector<double> tabulated =
      column.exact_phase && air.phase_values ? air.phase_values(cos_angle) : std::vector<double>();
  double radiance = 0;
  const std::size_t steps = up ? count - place.layer : place.layer + 1;
  for (std::size_t step = 0; step < steps; ++step) {
    const std::size_t i = up ? count - 1 - step : step;
    const ScaledLayer& scaled = (*column.scaled)[i];
    const BeamLayer& beam = (*column.beam)[i];
    const Sight sight{cosine, up, scaled.depth, i == place.layer ? place.u : (up ? 0.0 : scaled.depth)};
    radiance *= std::exp(-sight.seen_depth() / cosine);
    if (scaled.source_albedo <= 0 || scaled.depth <= 0) continue;
    const std::vector<double>& moments = air.layers[i].phase_moments;
    const bool exact = column.exact_phase && !moments.empty();
    const double phase =
        !tabulated.empty() ? scaled.source_albedo * tabulated[i]
        : exact ? scaled.source_albedo * legendre_series(moments, moments.size(), cos_angle)
              : scaled.albedo * legendre_series(scaled.moment, scaled.moment.size(), cos_angle);
    radiance += column.flux / (4 * std::numbers::pi) * phase * beam.top * sight_falling(sight, beam.slope);
  }
  return radiance;
}

double aureole_excess(const BeamColumn& column, double cosine, double cos_angle, const Place& place) {
  const double weight = aureole_weight(cos_angle);
  if (weight <= 0) return 0;
  double depth = 0, truncated = 0;
  std::size_t longest = 0;
  // Means over the column above the place, weighted by scattering depth (eq. 24).
  std::vector<double> share(column.scaled->size(), 0.0);
  for (std::size_t i = 0; i < column.scaled->size() && i <= place.layer; ++i) {
    const ScaledLayer& scaled = (*column.scaled)[i];
    const double part = i < place.layer ? 1.0 : (scaled.depth > 0 ? place.u / scaled.depth : 0.0);
    share[i] = scaled.true_albedo * scaled.true_depth * part;
    depth += scaled.true_depth * part;
    truncated += scaled.truncation * share[i];
    longest = std::max(longest, column.column->layers[i].phase_moments.size());
  }
  if (column.flux <= 0 || truncated <= 1e-12 * depth || depth <= 0) return 0;
  const double peak_albedo = truncated / depth;  // mean f omega
  // Moments of 2 P'' - P'' * P'': the truncated peak is 1 below `streams` and chi_k / f from there on.
  std::vector<double> spike(longest, 1.0);
  for (std::size_t k = static_cast<std::size_t>(column.streams); k < longest; ++k) {
    double moment = 0;
    for (std::size_t i = 0; i < share.size(); ++i)
      if (k < column.column->layers[i].phase_moments.size())
        moment += share[i] * column.column->layers[i].phase_moments[k];
    moment /= truncated;
    spike[k] = moment * (2 - moment);
  }
  const double beam_cosine = column.cosine / (1 - peak_albedo);
  const double slant = depth / beam_cosine, view = depth / cosine;
  return weight * column.flux / (4 * std::numbers::pi) * peak_albedo * peak_albedo / (1 - peak_albedo) *
         legendre_series(spike, spike.size(), cos_angle) * slant * view * exp_difference(slant, slant, view);
}

}  // namespace raycube::atmos::solver
