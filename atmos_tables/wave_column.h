// One wavelength in the air's layers: depths towards the sun, gas along joined paths, single scattering, diffuse fluxes.
#pragma once

#include <cstddef>
#include <vector>

#include "atmos_tables/air_column.h"
#include "atmos_tables/bird_riordan.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

/// A straight path upward from level `from` to level `to`: chords per layer, and the shares it crosses.
struct Path {
  std::size_t from = 0, to = 0;
  std::vector<double> slant;
  ColumnShare share;                ///< whole path
  std::vector<ColumnShare> to_mid;  ///< per layer, from the observer's end of the path to the layer's middle
};
/// zenith_deg at `from`; observer_below: the light travels down to `from`, else up to `to`.
Path make_path(const AirColumn& air, std::size_t from, std::size_t to, double zenith_deg, bool observer_below);

/// Cosine between the travel of sunlight and that of the light that reaches an observer looking up (sky) or down (path).
/// zenith and azimuth (relative to the sun) of the sky point, or of the sensor seen from the target.
double scattering_cosine(double cos_sun, double zenith_deg, double relative_azimuth_deg, bool looking_up);

/// Everything per unit of E0. Keeps references to its arguments.
class WaveColumn {
 public:
  /// sun_share[level]: column shares of the sun's path down to that level. Wavelength 0.3..4 um.
  WaveColumn(const AirColumn& air, const std::vector<ColumnShare>& sun_share, const scene::AtmosphereSpec& spec,
             double wavelength_um, double cos_sun);

  double scatter_depth(const ColumnShare& share) const { return rayleigh_ * share.air + aerosol_ * share.aerosol; }
  /// Absorption depth of ozone, water and mixed gases by the total amounts of a path: not additive over its parts.
  double gas_depth(const ColumnShare& share) const;
  double rayleigh_total() const { return rayleigh_; }
  double aerosol_scatter_total() const { return albedo_ * aerosol_; }

  /// Bird & Riordan's diffuse irradiance on a level over black ground.
  double diffuse_black(std::size_t level, bool with_gas) const;
  /// Diffuse flux up at a level over black ground, gases left out: a lossless sky sends up what it does not send down.
  double diffuse_up(std::size_t level, std::size_t ground) const;
  /// Ground-reflected part of the sky's irradiance at a level (eq. 3-8), for the albedo of the specification.
  double diffuse_from_ground(std::size_t level) const;

  /// Single-scattered light at a path's observer per P/(4 pi), for the Rayleigh and the aerosol phase function.
  struct Single {
    double rayleigh = 0, aerosol = 0;
  };
  Single single_down(const Path& path) const { return single(path, true); }
  Single single_up(const Path& path) const { return single(path, false); }
  /// Light scattered into an upward path from the diffuse fluxes at the levels. Each hemisphere counts as isotropic; the
  /// share that turns back is 1/2 for Rayleigh and (1 - 7g/8)/2 for the aerosol (Sagan & Pollack 1967).
  double diffuse_into_path(const Path& path, const std::vector<double>& down, const std::vector<double>& up) const;

 private:
  SlantTransmission slant(std::size_t level, bool with_gas, double albedo) const;
  double layer_depth(std::size_t layer) const { return scatter_depth(air_.share(layer)); }
  /// The sun's slant depth per unit of the layer's vertical depth.
  double sun_slope(std::size_t layer) const;
  double rayleigh_part(std::size_t layer) const;
  double aerosol_part(std::size_t layer) const;
  /// Transmission from the sun to the layer's middle and on to the observer by gas, and from the layer's edge by scatterers.
  double joined(const Path& path, std::size_t layer) const;
  Single single(const Path& path, bool down) const;

  const AirColumn& air_;
  const std::vector<ColumnShare>& sun_share_;
  const scene::AtmosphereSpec& spec_;
  BirdRiordanLine line_;
  double cos_sun_, rayleigh_, aerosol_, albedo_;
  std::vector<double> sun_depth_;  ///< scatterers, per level
};

}  // namespace raycube::atmos
