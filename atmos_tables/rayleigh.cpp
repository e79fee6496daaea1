#include "atmos_tables/rayleigh.h"

namespace raycube::atmos {

double rayleigh_depth(double wavelength_um, double pressure_hPa) {
  const double l2 = wavelength_um * wavelength_um, il2 = 1 / l2;
  return 0.0021520 * (1.0455996 - 341.29061 * il2 - 0.90230850 * l2) / (1 + 0.0027059889 * il2 - 85.968563 * l2) *
         (pressure_hPa / 1013.25);
}

double rayleigh_depolarization(double wavelength_um) {
  const double il2 = 1 / (wavelength_um * wavelength_um), il4 = il2 * il2;
  const double n2 = 1.034 + 3.17e-4 * il2, o2 = 1.096 + 1.385e-3 * il2 + 1.448e-4 * il4;
  // Volume fractions in percent: N2, O2, Ar (F = 1), CO2 (F = 1.15).
  const double king = (78.084 * n2 + 20.946 * o2 + 0.934 * 1.0 + 0.036 * 1.15) / (78.084 + 20.946 + 0.934 + 0.036);
  return 6 * (king - 1) / (3 + 7 * king);
}

double phase_rayleigh(double depolarization, double cos_angle) {
  const double g = depolarization / (2 - depolarization);
  return 3 / (4 * (1 + 2 * g)) * ((1 + 3 * g) + (1 - g) * cos_angle * cos_angle);
}

}  // namespace raycube::atmos
