#include "atmos_tables/solver/beam_scatter.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "atmos_tables/solver/exp_differences.h"
#include "atmos_tables/solver/legendre.h"
#include "atmos_tables/solver/path_integrals.h"
#include "host/base/units.h"

namespace raycube::atmos::solver {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// The small-angle expansion holds in the aureole: whole within 10 degrees of the beam, fading to nothing at
/// 20, smooth in between so that radiance stays continuous.
double aureole_weight(double cos_angle) {
  constexpr double kWhole = base::rad_by_division(10), kNone = base::rad_by_division(20);
  const double part = std::clamp((kNone - std::acos(std::clamp(cos_angle, -1.0, 1.0))) / (kNone - kWhole), 0.0, 1.0);
  return part * part * (3 - 2 * part);
}

/// The layer's own phase function counts, not the truncated one.
bool own_phase(const Column& column, std::size_t layer, bool exact) {
  return exact && (column.phase_values || !column.layers[layer].phase_moments.empty());
}

}  // namespace

std::vector<MatrixXd> scatter_once(const Column& column, const ScaledColumn& scaled, const Rays& rays,
                                   const std::vector<Place>& places, bool exact) {
  const auto layers = static_cast<Index>(scaled.layers.size()), count = static_cast<Index>(rays.cosine.size());
  std::vector<MatrixXd> out(places.size(), MatrixXd::Zero(layers, count));
  if (layers == 0 || column.beam.flux <= 0) return out;
  const auto strength = [&](std::size_t i) {
    const ScaledLayer& layer = scaled.layers[i];
    const double albedo = own_phase(column, i, exact) ? layer.source_albedo : layer.albedo;
    return layer.source_albedo > 0 && layer.depth > 0
               ? column.beam.flux / (4 * std::numbers::pi) * albedo * scaled.beam[i].top
               : 0.0;
  };
  MatrixXd weight = MatrixXd::Zero(layers, count);
  travel(
      scaled, rays.up, places, [&](std::size_t p) { out[p] = weight; },
      [&](std::size_t p, std::size_t i) {
        out[p] = weight;
        for (Index r = 0; r < count; ++r) {
          const Sight sight{rays.cosine[static_cast<std::size_t>(r)], rays.up, scaled.layers[i].depth, places[p].u};
          out[p].col(r) *= std::exp(-sight.seen_depth() / sight.cosine);
          out[p](static_cast<Index>(i), r) = strength(i) * sight_falling(sight, scaled.beam[i].slope);
        }
      },
      [&](std::size_t i) {
        const auto at = static_cast<Index>(i);
        for (Index r = 0; r < count; ++r) {
          weight.col(r) *= rays.fade(r, at);
          weight(at, r) = strength(i) * rays.slant(r, at) * rays.beam(r, at);
        }
      });
  return out;
}

OnceScattered::OnceScattered(const Column& column, const ScaledColumn& scaled, bool exact,
                             const std::vector<MatrixXd>& weights)
    : column_(column), weights_(weights), tabulated_(exact && column.phase_values) {
  if (tabulated_ || column.beam.flux <= 0) return;
  for (const MatrixXd& place : weights) {
    std::vector<std::vector<double>>& rays = series_.emplace_back(static_cast<std::size_t>(place.cols()));
    for (std::size_t r = 0; r < rays.size(); ++r)
      for (std::size_t i = 0; i < scaled.layers.size(); ++i) {
        const double weight = place(static_cast<Index>(i), static_cast<Index>(r));
        if (weight == 0) continue;
        const std::vector<double>& moments =
            own_phase(column, i, exact) ? column.layers[i].phase_moments : scaled.layers[i].moment;
        if (rays[r].size() < moments.size()) rays[r].resize(moments.size(), 0.0);
        for (std::size_t k = 0; k < moments.size(); ++k) rays[r][k] += weight * moments[k];
      }
  }
}

void OnceScattered::add(Index ray, double cos_angle, Eigen::Ref<Eigen::VectorXd> radiance) const {
  if (column_.beam.flux <= 0) return;
  if (tabulated_) {
    const std::vector<double> phase = column_.phase_values(cos_angle);
    const Eigen::Map<const Eigen::VectorXd> values(phase.data(), static_cast<Index>(phase.size()));
    for (std::size_t p = 0; p < weights_.size(); ++p)
      radiance(static_cast<Index>(p)) += weights_[p].col(ray).dot(values);
    return;
  }
  for (std::size_t p = 0; p < series_.size(); ++p) {
    const std::vector<double>& series = series_[p][static_cast<std::size_t>(ray)];
    radiance(static_cast<Index>(p)) += legendre_series(series, series.size(), cos_angle);
  }
}

Aureole::Aureole(const Column& column, const ScaledColumn& scaled, const Place& place) {
  double truncated = 0;
  std::size_t longest = 0;
  // Means over the column above the place, weighted by scattering depth (eq. 24).
  std::vector<double> share(scaled.layers.size(), 0.0);
  for (std::size_t i = 0; i < scaled.layers.size() && i <= place.layer; ++i) {
    const ScaledLayer& layer = scaled.layers[i];
    const double part = i < place.layer ? 1.0 : (layer.depth > 0 ? place.u / layer.depth : 0.0);
    share[i] = layer.true_albedo * layer.true_depth * part;
    depth_ += layer.true_depth * part;
    truncated += layer.truncation * share[i];
    longest = std::max(longest, column.layers[i].phase_moments.size());
  }
  if (column.beam.flux <= 0 || truncated <= 1e-12 * depth_ || depth_ <= 0) return;
  flux_ = column.beam.flux;
  peak_albedo_ = truncated / depth_;  // mean f omega
  beam_cosine_ = column.beam.cosine / (1 - peak_albedo_);
  // Moments of 2 P'' - P'' * P'': the truncated peak is 1 below `streams` and chi_k / f from there on.
  spike_.assign(longest, 1.0);
  for (std::size_t k = static_cast<std::size_t>(scaled.streams); k < longest; ++k) {
    double moment = 0;
    for (std::size_t i = 0; i < share.size(); ++i)
      if (k < column.layers[i].phase_moments.size()) moment += share[i] * column.layers[i].phase_moments[k];
    moment /= truncated;
    spike_[k] = moment * (2 - moment);
  }
}

double Aureole::excess(double cosine, double cos_angle) const {
  if (spike_.empty()) return 0;
  const double weight = aureole_weight(cos_angle);
  if (weight <= 0) return 0;
  const double slant = depth_ / beam_cosine_, view = depth_ / cosine;
  return weight * flux_ / (4 * std::numbers::pi) * peak_albedo_ * peak_albedo_ / (1 - peak_albedo_) *
         legendre_series(spike_, spike_.size(), cos_angle) * slant * view * exp_difference(slant, slant, view);
}

}  // namespace raycube::atmos::solver
