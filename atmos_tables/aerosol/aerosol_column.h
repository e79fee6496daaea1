// Aerosols, fogs and clouds above one ground: how much of each at what height, and its optics at any wavelength.
//
// Two figures exist for the mean cosine of scattering: the optics table's, and that of the tabulated Mie function,
// since 70 shapes are shared by all substances and wavelengths. From 0.35 to 2.3 um they differ by 0.01 rms in the
// boundary layer's models, 0.02 in the troposphere's, 0.04 in the stratosphere's (rural at 0.55 um and 70 %: 0.664 and
// 0.641). `phase` and its moments are the Mie function as it stands, so fluxes follow its own mean; `asymmetry` is the
// table's, for Henyey-Greenstein. Mixing layers: S4.5.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/aerosol/aerosol_spec.h"
#include "atmos_tables/aerosol/height_profile.h"
#include "atmos_tables/aerosol/particle_optics.h"
#include "atmos_tables/aerosol/phase_function.h"
#include "atmos_tables/aerosol/substance.h"
#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

class AerosolColumn {
 public:
  /// Ground altitude is the profile's lowest level, -1..5.5 km when there are aerosols. Throws Error(input) that lists
  /// every bad figure of the spec.
  AerosolColumn(const AerosolSpec& spec, const AirProfile& profile);

  /// Boundary layer, troposphere, stratosphere, upper air (none of them for AerosolModel::none), the user's own, then
  /// the clouds.
  std::size_t components() const { return components_.size(); }
  const std::string& name(std::size_t component) const { return components_.at(component).name; }

  /// Extinction at 0.55 um, km-1, at a height above the sea; 0 outside the component.
  double extinction_550_per_km(std::size_t component, double height_km) const;
  /// Vertical extinction depth at 0.55 um between two heights above the sea, low <= high: the exact integral.
  double depth_550(std::size_t component, double low_km, double high_km) const;
  /// Heights where profiles have kinks, ascending, none twice.
  std::vector<double> level_km() const;

  struct Optics {
    double extinction_ratio = 1;  ///< extinction over that at 0.55 um
    double scattering_albedo = 1;
    double asymmetry = 0;  ///< of the table
    std::shared_ptr<const PhaseFunction> phase;
  };
  /// Throws Error(input) for each component whose optics end short of these wavelengths.
  void check_covers(double first_um, double last_um) const;
  /// wavelength_um: 0.2..200, vacuum, or what a user's own cover. Throws Error(input) outside.
  Optics optics(std::size_t component, double wavelength_um) const;
  /// Backscatter coefficient, sr-1, over the extinction at 0.55 um: ratio albedo P(180) / (4 pi). The lidar ratio is
  /// extinction_ratio / backscatter_per_sr.
  double backscatter_per_sr(std::size_t component, double wavelength_um) const;

  double visibility_km() const { return visibility_km_; }  ///< used, also when a depth was asked for
  double aod_550() const { return aod_550_; }  ///< whole vertical depth of the aerosols at 0.55 um; clouds do not count
  double humidity_percent() const { return humidity_percent_; }  ///< used
  /// What a user should know: held visibility or humidity, depth below the least, kinds without a phase function of
  /// their own.
  const std::vector<std::string>& notices() const { return notices_; }

 private:
  struct Component {
    std::string name;
    HeightProfile heights;
    std::optional<Substance> substance;         ///< none where `own` is there
    std::vector<Substance> droplets;            ///< whose Mie functions stand in where the figures hold none
    std::shared_ptr<const ParticleOptics> own;  ///< a user's
  };
  void add_aerosols(const AerosolSpec& spec, const AirProfile& profile);
  void add_own(const AerosolSpec& spec, const AirProfile& profile);
  void add_clouds(const AerosolSpec& spec);
  PhaseFunction phase(const Component& component, double wavelength_um, double asymmetry) const;

  std::vector<Component> components_;
  bool henyey_greenstein_ = false;
  BetweenWaves between_waves_ = BetweenWaves::power_law;
  double visibility_km_ = 0, aod_550_ = 0, humidity_percent_ = 0;
  std::vector<std::string> notices_;
};

/// Relative humidity over water, %.
double relative_humidity_percent(const AirLevel& level);

}  // namespace raycube::atmos
