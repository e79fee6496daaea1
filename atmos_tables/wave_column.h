// One wavelength in the air's layers: depths towards the sun, gas along joined paths, single scattering, diffuse
// fluxes. Radiances use delta scaling (Wiscombe 1977, J. Atmos. Sci. 34, 1408): the share g^2 of aerosol scattering
// goes on as if it had not scattered, while single scattering keeps the whole phase function (Nakajima & Tanaka 1988,
// TMS).
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
  bool observer_below = false;      ///< the light travels down to `from` (sky), else up to `to` (path radiance)
  double aerosol_back = 0.5;        ///< aerosol_back_share at this zenith
};
/// zenith_deg at `from`.
Path make_path(const AirColumn& air, std::size_t from, std::size_t to, double zenith_deg, bool observer_below,
               double asymmetry);

/// Share of light arriving evenly from one hemisphere that a Henyey-Greenstein scatterer turns into the direction with
/// this zenith in the other one, relative to an isotropic scatterer's 1/2 + 1/2: mean of P/2 over the hemisphere.
double aerosol_back_share(double asymmetry, double zenith_deg);

/// Cosine between the travel of sunlight and that of the light that reaches an observer looking up (sky) or down
/// (path). zenith and azimuth (relative to the sun) of the sky point, or of the sensor seen from the target.
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
  /// Ground-reflected part of the sky's irradiance at a level (eq. 3-8), for the albedo of the specification.
  double diffuse_from_ground(std::size_t level) const;

  /// Single-scattered light at a path's observer per P/(4 pi), for the Rayleigh and the aerosol phase function.
  struct Single {
    double rayleigh = 0, aerosol = 0;
  };
  Single single(const Path& path) const;
  /// Diffuse fluxes per level, gases left out: down without the part that delta scaling leaves in the beam, and up.
  struct Fluxes {
    std::vector<double> down, up;
  };
  Fluxes fluxes() const;
  /// Light that reaches a path's observer after the diffuse fluxes scattered in the path; each hemisphere counts as
  /// even.
  double scattered_diffuse(const Path& path, const Fluxes& fluxes) const;

 private:
  SlantTransmission slant(std::size_t level, bool with_gas, double albedo) const;
  /// Delta-scaled depth of scatterers.
  double scaled_depth(const ColumnShare& share) const {
    return rayleigh_ * share.air + scaled_aerosol_ * share.aerosol;
  }
  double layer_depth(std::size_t layer) const { return scaled_depth(air_.share(layer)); }
  /// Diffuse flux up at a level over black ground, gases left out: a lossless sky sends up what it does not send down.
  double diffuse_up(std::size_t level, std::size_t ground) const;
  /// The sun's slant depth per unit of the layer's vertical depth.
  double sun_slope(std::size_t layer) const;
  double rayleigh_part(std::size_t layer) const;
  double aerosol_part(std::size_t layer) const;
  /// Transmission from the sun to the layer's middle and on to the observer by gas, and from the layer's edge by
  /// scatterers.
  double joined(const Path& path, std::size_t layer) const;

  const AirColumn& air_;
  const std::vector<ColumnShare>& sun_share_;
  const scene::AtmosphereSpec& spec_;
  BirdRiordanLine line_;
  double cos_sun_, rayleigh_, aerosol_, albedo_;
  double forward_, scaled_aerosol_;  ///< g^2; aerosol depth after delta scaling
  std::vector<double> sun_depth_;    ///< of scatterers after delta scaling, per level
};

}  // namespace raycube::atmos
