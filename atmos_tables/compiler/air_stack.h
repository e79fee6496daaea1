// The air of one scene in layers: profile, aerosols and gases as a user states them, cut at the scene's lowest ground.
// Heights km above the sea, layers from the ground up; everything that does not depend on wavelength is prepared here
// once.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/aerosol/aerosol_column.h"
#include "atmos_tables/compiler/line_air.h"
#include "atmos_tables/gas/layer_gases.h"
#include "atmos_tables/optics/air_profile.h"
#include "scene_compiler/simulation.h"

namespace raycube::atmos {

inline constexpr double kTopOfStack_km = 100;
inline constexpr double kPlanetRadius_km = 6371.23;

/// The profile of a specification, by name or from its file, scaled to the columns, pressure and mixing ratios stated
/// and cut at the ground. Notes what was capped. Throws Error(input) with what is out of range.
AirProfile make_profile(const scene::AirSpec& spec, double ground_km, std::vector<std::string>& notices);

/// Aerosols and clouds of a specification. Throws Error(input) for names that do not exist.
AerosolSpec make_aerosols(const scene::AirSpec& spec);

class AirStack {
 public:
  /// ground_km: where the air begins. marks_km: heights that must be levels (targets, the sensor); those above the top
  /// are dropped, those below the ground refused. With gas_bands "lowtran" the levels are LOWTRAN7's, 1 km apart up to
  /// 25 km. lines: gases that are resolved by somebody else, whose band models are silent.
  AirStack(const scene::AirSpec& spec, double ground_km, const std::vector<double>& marks_km,
           const LineAir& lines = {});

  const std::vector<double>& level_km() const { return level_km_; }
  std::size_t layers() const { return level_km_.size() - 1; }
  /// The level within half a metre of a height; the top for heights above it.
  std::size_t level_of(double height_km) const;

  const AirProfile& profile() const { return profile_; }
  const AerosolColumn& aerosols() const { return aerosols_; }
  /// All gases: continua and other grey absorption.
  const LayerGases& gases() const { return gases_; }
  /// Those whose lines the band models give.
  const LayerGases& band_gases() const { return bands_ ? *bands_ : gases_; }
  double temperature_K(std::size_t level) const { return temperature_K_[level]; }
  double mean_temperature_K(std::size_t layer) const { return mean_temperature_K_[layer]; }  ///< by density
  double air_column_per_cm2(std::size_t layer) const { return air_column_[layer]; }
  double co2_ppmv() const { return co2_ppmv_; }
  const std::vector<std::string>& notices() const { return notices_; }

  /// Path length over thickness in every layer (0 outside) of the ray that leaves level `from` upward at this apparent
  /// zenith angle (0..90 deg) and ends at level `to` >= from: spherical shells, refracted (solver/slant_path.h).
  std::vector<double> path_factors(std::size_t from, std::size_t to, double zenith_deg) const;

 private:
  std::vector<std::string> notices_;
  AirProfile profile_;
  AerosolColumn aerosols_;
  std::vector<double> level_km_;
  LayerGases gases_;
  std::optional<LayerGases> bands_;
  std::vector<double> temperature_K_, mean_temperature_K_, refractivity_, air_column_;
  double co2_ppmv_ = 0;
};

}  // namespace raycube::atmos
