// Optics of the tabulated aerosols, fogs and clouds (LOWTRAN7: Kneizys et al. 1988, AFGL-TR-88-0177; Shettle & Fenn
// 1979).
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "atmos_tables/aerosol/phase_function.h"

namespace raycube::atmos {

inline constexpr double kMinAerosolWave_um = 0.2, kMaxAerosolWave_um = 200;
/// Beyond this humidity, %, the figures end.
inline constexpr double kMaxHumidity_percent = 99;

/// Between tabulated wavelengths. power_law: extinction as Angstrom's law through the neighbours, absorption's share of
/// it and asymmetry linear; MODTRAN 6 follows it to 2 %. linear: extinction and absorption linear too, LOWTRAN7's rule,
/// which gives up to 8 % more extinction halfway between 0.69 and 1.06 um, where the curve is hollow.
enum class BetweenWaves { power_law, linear };

/// Extinction and absorption over the extinction at 0.55 um; asymmetry of the table.
struct SubstanceOptics {
  double extinction = 1, absorption = 0, asymmetry = 0;
};

/// One substance at one grade: relative humidity, % (rural, urban, maritime, tropospheric; 0..99), wind speed, m/s
/// (desert; 0..30), 0 otherwise. Between humidities the logarithms of extinction, absorption and asymmetry are linear
/// in ln(100 - RH); between wind speeds they are linear in the speed.
class Substance {
 public:
  /// Throws Error(bug) for a name the figures do not hold.
  Substance(const std::string& name, double grade);

  const std::string& name() const { return name_; }
  /// 0.2..200 um; throws Error(input) outside.
  SubstanceOptics at(double wavelength_um, BetweenWaves rule = BetweenWaves::power_law) const;
  /// Whether the figures hold Mie functions for it. Clouds, cirrus and desert have none.
  bool has_phase() const { return !phase_rows_.empty(); }
  /// Linear in wavelength between the wavelengths of the index (0.2..40 um, held beyond), and in the humidity's
  /// coordinate: a mixture of at most four shapes, so its moments and its integral are exact.
  PhaseFunction phase(double wavelength_um) const;

 private:
  struct PhaseRowPart {
    std::size_t row;
    double weight;
  };
  std::string name_;
  std::vector<SubstanceOptics> nodes_;
  std::vector<PhaseRowPart> phase_rows_;
};

/// The tabulated Mie functions, made once; number: 0 ... tabulated_phases() - 1.
std::size_t tabulated_phases();
std::shared_ptr<const PhaseShape> tabulated_phase(std::size_t number);

}  // namespace raycube::atmos
