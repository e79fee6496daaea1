#include "atmos_tables/compiler/spectral_air.h"

#include <algorithm>
#include <cmath>

#include "atmos_tables/clear_sky_inputs.h"
#include "atmos_tables/optics/rayleigh_air.h"
#include "atmos_tables/rayleigh.h"
#include "host/base/planck.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {
/// Moments of the phase functions: the solver's streams, and beyond them what the small-angle correction of the aureole
/// sums.
constexpr std::size_t kLastMoment = 191;
constexpr double kLoneHalfWidth_per_cm = 2.5;
}  // namespace

std::vector<SpectralBin> spectral_bins(const std::vector<double>& wavelength_um) {
  std::vector<SpectralBin> bins;
  const std::size_t count = wavelength_um.size();
  for (std::size_t i = 0; i < count; ++i) {
    const double here = wavelength_um[i], centre = 1e4 / here;
    if (count == 1) {
      bins.push_back({here, centre - kLoneHalfWidth_per_cm, centre + kLoneHalfWidth_per_cm});
      continue;
    }
    const NodeSpan span = node_span(wavelength_um, i);
    bins.push_back({here, 1e4 / span.to_um, 1e4 / span.from_um});
  }
  return bins;
}

SpectralAir::SpectralAir(const AirStack& stack, const SpectralBin& bin, std::size_t k_terms,
                         const std::vector<double>& resolved)
    : stack_(stack), bin_(bin) {
  const double wavelength = bin.wavelength_um, width = bin.high_per_cm - bin.low_per_cm;
  // Continua follow their bands (a factor of 3 within 20 nm at 1.12 um): their mean depth over the bin, in steps of the
  // bands'.
  const int points = 1 + static_cast<int>(width / LowtranLines::kStep);
  const double cross_section = rayleigh_cross_section_cm2(wavelength, stack.co2_ppmv());
  depolarization_ = air_depolarization(wavelength, stack.co2_ppmv());
  rayleigh_moments_ = rayleigh_moments(depolarization_);
  const AerosolColumn& aerosols = stack.aerosols();
  for (std::size_t c = 0; c < aerosols.components(); ++c) {
    aerosol_.push_back(aerosols.optics(c, wavelength));
    aerosol_moments_.push_back(aerosol_.back().phase->moments(kLastMoment));
  }
  for (std::size_t i = 0; i < stack.layers(); ++i) {
    Layer layer;
    layer.rayleigh = cross_section * stack.air_column_per_cm2(i);
    for (int k = 0; k < points; ++k)
      layer.absorbed += stack.gases().grey_depth(bin.low_per_cm + width * (k + 0.5) / points, i) / points;
    if (!resolved.empty()) layer.absorbed += resolved[i];
    for (std::size_t c = 0; c < aerosol_.size(); ++c)
      layer.aerosol.push_back(aerosol_[c].extinction_ratio *
                              aerosols.depth_550(c, stack.level_km()[i], stack.level_km()[i + 1]));
    layers_.push_back(std::move(layer));
  }
  k_ = stack.band_gases().k_terms(bin.low_per_cm, bin.high_per_cm, k_terms);
}

double SpectralAir::layer_extinction(std::size_t i) const {
  double depth = layers_[i].rayleigh + layers_[i].absorbed;
  for (double part : layers_[i].aerosol) depth += part;
  return depth;
}

double SpectralAir::grey_depth(const std::vector<double>& path_factor) const {
  double depth = 0;
  for (std::size_t i = 0; i < layers_.size(); ++i)
    if (path_factor[i] > 0) depth += path_factor[i] * layer_extinction(i);
  return depth;
}

double SpectralAir::scatterers_depth(const std::vector<double>& path_factor) const {
  double depth = 0;
  for (std::size_t i = 0; i < layers_.size(); ++i)
    if (path_factor[i] > 0) depth += path_factor[i] * (layer_extinction(i) - layers_[i].absorbed);
  return depth;
}

double SpectralAir::line_depth(const std::vector<double>& path_factor) const {
  return stack_.band_gases().mean_line_depth(bin_.low_per_cm, bin_.high_per_cm, path_factor);
}

double SpectralAir::scattering_depth_above(std::size_t level) const {
  double depth = 0;
  for (std::size_t i = level; i < layers_.size(); ++i) {
    depth += layers_[i].rayleigh;
    for (double part : layers_[i].aerosol) depth += part;
  }
  return depth;
}

double SpectralAir::mean_phase_above(std::size_t level, double cos_angle) const {
  const std::vector<double> phase = substance_phases(cos_angle);
  double total = 0, sum = 0;
  for (std::size_t i = level; i < layers_.size(); ++i) {
    total += scattering(i);
    sum += scattering(i) * layer_phase(i, phase);
  }
  return total > 0 ? sum / total : 1.0;
}

double SpectralAir::scattering(std::size_t layer) const {
  double depth = layers_[layer].rayleigh;
  for (std::size_t c = 0; c < aerosol_.size(); ++c) depth += layers_[layer].aerosol[c] * aerosol_[c].scattering_albedo;
  return depth;
}

std::vector<double> SpectralAir::substance_phases(double cos_angle) const {
  std::vector<double> phase = {phase_rayleigh(depolarization_, cos_angle)};
  for (const auto& optics : aerosol_) phase.push_back(optics.phase->value(cos_angle));
  return phase;
}

double SpectralAir::layer_phase(std::size_t i, const std::vector<double>& phase) const {
  double sum = layers_[i].rayleigh * phase[0];
  for (std::size_t c = 0; c < aerosol_.size(); ++c)
    sum += layers_[i].aerosol[c] * aerosol_[c].scattering_albedo * phase[c + 1];
  const double total = scattering(i);
  return total > 0 ? sum / total : 1.0;
}

solver::Column SpectralAir::column(std::size_t term, double beam_flux, double sun_zenith_deg, bool emits) const {
  solver::Column column;
  const double sun = base::rad_by_division(sun_zenith_deg);
  if (beam_flux > 0) {
    column.beam = {beam_flux, std::cos(sun), 0};
    column.phase_values = [this](double cos_angle) {
      const std::vector<double> phase = substance_phases(cos_angle);
      std::vector<double> out;
      for (std::size_t i = layers_.size(); i-- > 0;) out.push_back(layer_phase(i, phase));
      return out;
    };
  }
  column.planet_radius_m = 1000 * kPlanetRadius_km;
  for (std::size_t i = layers_.size() + 1; i-- > 0;) {
    column.level_height_m.push_back(1000 * stack_.level_km()[i]);
    if (emits) column.planck.push_back(base::planck_radiance(bin_.wavelength_um, stack_.temperature_K(i)));
  }
  for (std::size_t i = layers_.size(); i-- > 0;) {
    const Layer& layer = layers_[i];
    solver::Layer out;
    out.optical_depth = layer_extinction(i) + k_.layer_depth[term][i];
    const double scattered = scattering(i);
    std::vector<double> moments(rayleigh_moments_);
    for (double& moment : moments) moment *= layer.rayleigh;
    for (std::size_t c = 0; c < aerosol_.size(); ++c) {
      const double part = layer.aerosol[c] * aerosol_[c].scattering_albedo;
      if (!(part > 0)) continue;
      if (moments.size() < aerosol_moments_[c].size()) moments.resize(aerosol_moments_[c].size(), 0.0);
      for (std::size_t k = 0; k < aerosol_moments_[c].size(); ++k) moments[k] += part * aerosol_moments_[c][k];
    }
    if (scattered > 0 && out.optical_depth > 0) {
      out.scattering_albedo = std::min(1.0, scattered / out.optical_depth);
      for (double& moment : moments) moment /= scattered;
      moments[0] = 1;
      out.phase_moments = std::move(moments);
    }
    column.layers.push_back(std::move(out));
  }
  return column;
}

double SpectralAir::depth_between(std::size_t term, std::size_t low, std::size_t high) const {
  double depth = 0;
  for (std::size_t i = low; i < high; ++i) depth += layer_extinction(i) + k_.layer_depth[term][i];
  return depth;
}

}  // namespace raycube::atmos
