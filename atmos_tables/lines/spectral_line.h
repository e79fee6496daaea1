// One absorption line as line lists give it.
#pragma once

namespace raycube::atmos {

/// Line parameters refer to this temperature, K.
inline constexpr double kLineReference_K = 296;
inline constexpr double kAtmosphere_hPa = 1013.25;

struct SpectralLine {
  int molecule = 0, isotopologue = 0;  ///< HITRAN's numbers, from 1
  double wavenumber_per_cm = 0;        ///< vacuum
  double intensity = 0;  ///< cm-1 / (molecule cm-2) at 296 K, natural abundance of the isotopologue included
  double gamma_air = 0, gamma_self = 0;  ///< half widths at half maximum, cm-1 atm-1, at 296 K
  double lower_energy_per_cm = 0;
  double n_air = 0;      ///< gamma goes with (296 K / T)^n
  double delta_air = 0;  ///< shift of the centre, cm-1 atm-1
};

}  // namespace raycube::atmos
