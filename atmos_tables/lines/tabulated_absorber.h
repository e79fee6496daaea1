// Cross-sections that a user measured or bought, for gases without a line list (ethane, heavy molecules).
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/lines/absorber.h"

namespace raycube::atmos {

/// CSV under the header wavenumber_per_cm,pressure_hPa,temperature_K,cross_section_cm2; notes start with #. Rows of one
/// pressure and temperature form a spectrum, wavenumbers ascending; spectra may follow one another in any order, rows
/// may not be mixed. Between wavenumbers linear. Between states: linear in temperature among spectra of one pressure
/// (within 1 %), then linear in ln p; held beyond the outermost, so a single spectrum serves every height, with the
/// error of not knowing better.
class TabulatedAbsorber : public Absorber {
 public:
  /// Throws Error(environment) when the file cannot be read, Error(input) with every fault by line.
  static TabulatedAbsorber read_csv(const std::string& file);

  /// 0 outside a spectrum's wavenumbers.
  std::vector<double> cross_section_cm2(const std::vector<double>& wavenumber_per_cm,
                                        const GasState& state) const override;

  /// Wavenumbers that every spectrum covers.
  double first_per_cm() const;
  double last_per_cm() const;

 private:
  struct Spectrum {
    double pressure_hPa = 0, temperature_K = 0;
    std::vector<double> wavenumber_per_cm, sigma_cm2;
    double at(double wavenumber) const;
  };
  struct Group {
    double pressure_hPa = 0;
    std::vector<Spectrum> by_temperature;
  };
  std::vector<Group> groups_;  ///< ascending in pressure
};

}  // namespace raycube::atmos
