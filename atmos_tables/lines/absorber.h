// What one molecule of a gas absorbs, resolved to single lines.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

struct GasState {
  double pressure_hPa = 0;  ///< of the air, the gas included
  double temperature_K = 0;
  double own_pressure_hPa = 0;  ///< of the gas
};

class Absorber {
 public:
  virtual ~Absorber() = default;
  /// Absorption cross-section, cm2 per molecule, at wavenumbers (cm-1, vacuum) that ascend strictly.
  virtual std::vector<double> cross_section_cm2(const std::vector<double>& wavenumber_per_cm,
                                                const GasState& state) const = 0;
};

/// A gas in the air and what it absorbs. Amount: the profile's, or one mixing ratio at every height.
struct AbsorbingGas {
  std::string name;
  std::optional<Gas> in_profile;
  double ppmv = 0;
  std::shared_ptr<const Absorber> absorber;

  double per_cm3(const AirLevel& air) const {
    return in_profile ? air.gas(*in_profile) : 1e-6 * ppmv * air.air_per_cm3;
  }
};

/// Absorption coefficient of some gases in air of one state, km-1.
std::vector<double> absorption_per_km(const std::vector<AbsorbingGas>& gases, const AirLevel& air,
                                      const std::vector<double>& wavenumber_per_cm);

/// Depths of layers by gases whose lines are resolved. Monochromatic, so they add up over layers and paths.
class ResolvedGases {
 public:
  /// Layers between levels from the ground up, km above the sea, inside the profile (Error(input) otherwise);
  /// wavenumbers ascend. Two Gauss points in every piece of a layer: the depth of a line's wing is right to 1e-4 where
  /// pressure halves in a piece.
  ResolvedGases(const std::vector<AbsorbingGas>& gases, const AirProfile& profile, const std::vector<double>& level_km,
                const std::vector<double>& wavenumber_per_cm);

  std::size_t layers() const { return layers_; }
  /// Vertical depth of a layer at the point'th wavenumber.
  double depth(std::size_t point, std::size_t layer) const { return depth_[point * layers_ + layer]; }

 private:
  std::size_t layers_ = 0;
  std::vector<double> depth_;
};

}  // namespace raycube::atmos
