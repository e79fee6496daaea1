#include "atmos_tables/wave_column.h"

#include <algorithm>
#include <cmath>

#include "atmos_tables/rayleigh.h"
#include "atmos_tables/single_scatter.h"
#include "host/base/units.h"

namespace raycube::atmos {

namespace {}  // namespace

double aerosol_back_share(double asymmetry, double zenith_deg) {
  // Midpoint rule over the far hemisphere; smooth there, so 32 x 32 is good to 1e-3.
  constexpr int kSteps = 32;
  const double mu = std::cos(base::rad_by_division(zenith_deg)), sine = std::sin(base::rad_by_division(zenith_deg));
  double sum = 0;
  for (int i = 0; i < kSteps; ++i)
    for (int j = 0; j < kSteps; ++j) {
      const double other = (i + 0.5) / kSteps;
      const double cosine =
          -mu * other + sine * std::sqrt(1 - other * other) * std::cos(base::kPi * (j + 0.5) / kSteps);
      sum += phase_henyey_greenstein(asymmetry, cosine);
    }
  return 0.5 * sum / (kSteps * kSteps);
}

Path make_path(const AirColumn& air, std::size_t from, std::size_t to, double zenith_deg, bool observer_below,
               double asymmetry) {
  Path path;
  path.observer_below = observer_below;
  path.aerosol_back = aerosol_back_share(asymmetry, zenith_deg);
  path.from = from, path.to = to;
  path.slant = air.slant(from, zenith_deg);
  path.to_mid.resize(air.layers());
  ColumnShare passed;
  for (std::size_t n = 0; from + n < to; ++n) {
    const std::size_t l = observer_below ? from + n : to - 1 - n;
    const ColumnShare half = 0.5 * path.slant[l] * air.share(l);
    path.to_mid[l] = passed + half;
    passed = path.to_mid[l] + half;
  }
  path.share = passed;
  return path;
}

double scattering_cosine(double cos_sun, double zenith_deg, double relative_azimuth_deg, bool looking_up) {
  const double sines = std::sqrt(1 - cos_sun * cos_sun) * std::sin(base::rad_by_division(zenith_deg));
  const double cosine = cos_sun * std::cos(base::rad_by_division(zenith_deg)) +
                        sines * std::cos(base::rad_by_division(relative_azimuth_deg));
  return std::clamp(looking_up ? cosine : -cosine, -1.0, 1.0);
}

WaveColumn::WaveColumn(const AirColumn& air, const std::vector<ColumnShare>& sun_share,
                       const scene::AtmosphereSpec& spec, double wavelength_um, double cos_sun)
    : air_(air),
      sun_share_(sun_share),
      spec_(spec),
      line_(bird_riordan_at(wavelength_um)),
      cos_sun_(cos_sun),
      rayleigh_(rayleigh_depth(wavelength_um, spec.pressure_hPa)),
      aerosol_(spec.aod_550 * std::pow(wavelength_um / 0.55, -spec.angstrom)),
      albedo_(aerosol_albedo(spec.ssa, wavelength_um)),
      forward_(spec.asymmetry * spec.asymmetry),
      scaled_aerosol_(aerosol_ * (1 - albedo_ * forward_)) {
  for (const ColumnShare& share : sun_share) sun_depth_.push_back(scaled_depth(share));
}

double WaveColumn::gas_depth(const ColumnShare& share) const {
  return water_depth(line_.water, spec_.water_g_cm2 * share.water) + line_.ozone * spec_.ozone_atm_cm * share.ozone +
         mixed_gas_depth(line_.mixed, spec_.pressure_hPa / 1013.0 * share.air);
}

SlantTransmission WaveColumn::slant(std::size_t level, bool with_gas, double albedo) const {
  SlantTransmission t;
  t.rayleigh = std::exp(-rayleigh_ * sun_share_[level].air);
  t.aerosol_scattering = std::exp(-albedo * aerosol_ * sun_share_[level].aerosol);
  t.aerosol_absorption = std::exp(-(1 - albedo) * aerosol_ * sun_share_[level].aerosol);
  t.gas = with_gas ? std::exp(-gas_depth(sun_share_[level])) : 1.0;
  return t;
}

double WaveColumn::diffuse_black(std::size_t level, bool with_gas) const {
  return diffuse_irradiance_black_ground(line_.wavelength_um, 1.0, cos_sun_, spec_.asymmetry,
                                         slant(level, with_gas, albedo_));
}

double WaveColumn::diffuse_up(std::size_t level, std::size_t ground) const {
  const auto net = [&](std::size_t at) {
    const SlantTransmission t = slant(at, false, 1.0);
    return cos_sun_ * t.rayleigh * t.aerosol_scattering +
           diffuse_irradiance_black_ground(line_.wavelength_um, 1.0, cos_sun_, spec_.asymmetry, t);
  };
  return std::max(0.0, net(level) - net(ground)) * slant(ground, false, albedo_).aerosol_absorption;
}

double WaveColumn::diffuse_from_ground(std::size_t level) const {
  if (spec_.ground_albedo <= 0) return 0;
  ColumnShare above;
  for (std::size_t l = level; l < air_.layers(); ++l) above += 1.8 * air_.share(l);
  SlantTransmission t;
  t.rayleigh = std::exp(-rayleigh_ * above.air);
  t.aerosol_scattering = std::exp(-albedo_ * aerosol_ * above.aerosol);
  t.aerosol_absorption = std::exp(-(1 - albedo_) * aerosol_ * above.aerosol);
  above.ozone = 0;  // the authors leave ozone out of the sky's reflectance
  t.gas = std::exp(-gas_depth(above));
  const double sky = sky_reflectance(spec_.asymmetry, t), correction = short_wave_correction(line_.wavelength_um);
  const double direct = cos_sun_ * std::exp(-scatter_depth(sun_share_[level]) - gas_depth(sun_share_[level]));
  const double coupling = spec_.ground_albedo * sky / (1 - spec_.ground_albedo * sky);
  return (direct + diffuse_black(level, true) / correction) * coupling * correction;
}

double WaveColumn::sun_slope(std::size_t layer) const {
  const double depth = layer_depth(layer);
  return depth > 0 ? std::max(0.0, sun_depth_[layer] - sun_depth_[layer + 1]) / depth : 0.0;
}

double WaveColumn::rayleigh_part(std::size_t layer) const {
  const double depth = layer_depth(layer);
  return depth > 0 ? rayleigh_ * air_.share(layer).air / depth : 0.0;
}

double WaveColumn::aerosol_part(std::size_t layer) const {
  const double depth = layer_depth(layer);
  return depth > 0 ? albedo_ * aerosol_ * air_.share(layer).aerosol / depth : 0.0;
}

double WaveColumn::joined(const Path& path, std::size_t layer) const {
  const ColumnShare to_edge = path.to_mid[layer] + (-0.5 * path.slant[layer]) * air_.share(layer);
  const ColumnShare sun_to_mid = 0.5 * (sun_share_[layer] + sun_share_[layer + 1]);
  return std::exp(-scaled_depth(to_edge) - gas_depth(sun_to_mid + path.to_mid[layer]));
}

WaveColumn::Single WaveColumn::single(const Path& path) const {
  Single out;
  for (std::size_t l = path.from; l < path.to; ++l) {
    const double depth = layer_depth(l);
    const double in_layer = path.observer_below ? layer_scatter_down(depth, sun_slope(l), path.slant[l])
                                                : layer_scatter_up(depth, sun_slope(l), path.slant[l]);
    const double value = in_layer * std::exp(-sun_depth_[l + 1]) * joined(path, l);
    out.rayleigh += rayleigh_part(l) * value;
    out.aerosol += aerosol_part(l) * value;
  }
  return out;
}

WaveColumn::Fluxes WaveColumn::fluxes() const {
  Fluxes out;
  for (std::size_t level = 0; level < sun_depth_.size(); ++level) {
    const double in_beam = cos_sun_ * (std::exp(-sun_depth_[level]) - std::exp(-scatter_depth(sun_share_[level])));
    out.down.push_back(std::max(0.0, diffuse_black(level, false) - in_beam));
    out.up.push_back(diffuse_up(level, 0));
  }
  return out;
}

double WaveColumn::scattered_diffuse(const Path& path, const Fluxes& fluxes) const {
  const double turned = path.aerosol_back, kept = std::max(0.0, 1 - path.aerosol_back - forward_);
  double sum = 0;
  for (std::size_t l = path.from; l < path.to; ++l) {
    const double down = 0.5 * (fluxes.down[l] + fluxes.down[l + 1]) / base::kPi;
    const double up = 0.5 * (fluxes.up[l] + fluxes.up[l + 1]) / base::kPi;
    const double along = path.observer_below ? down : up, against = path.observer_below ? up : down;
    const double source =
        rayleigh_part(l) * 0.5 * (along + against) + aerosol_part(l) * (turned * against + kept * along);
    sum += source * layer_emission(layer_depth(l), path.slant[l]) * joined(path, l);
  }
  return sum;
}

}  // namespace raycube::atmos
