#include "atmos_tables/optics/rayleigh_air.h"

#include <numbers>

namespace raycube::atmos {

double air_refractivity(double wavelength_um, double co2_ppmv) {
  const double il2 = 1 / (wavelength_um * wavelength_um);
  const double at_300ppmv = 1e-8 * (8060.51 + 2480990 / (132.274 - il2) + 17455.7 / (39.32957 - il2));
  return at_300ppmv * (1 + 0.54 * (1e-6 * co2_ppmv - 0.0003));
}

double air_king_factor(double wavelength_um, double co2_ppmv) {
  const double il2 = 1 / (wavelength_um * wavelength_um), il4 = il2 * il2;
  const double n2 = 1.034 + 3.17e-4 * il2, o2 = 1.096 + 1.385e-3 * il2 + 1.448e-4 * il4, argon = 1.00, co2 = 1.15;
  const double co2_percent = 1e-4 * co2_ppmv;
  return (78.084 * n2 + 20.946 * o2 + 0.934 * argon + co2_percent * co2) / (78.084 + 20.946 + 0.934 + co2_percent);
}

double air_depolarization(double wavelength_um, double co2_ppmv) {
  const double king = air_king_factor(wavelength_um, co2_ppmv);
  return 6 * (king - 1) / (3 + 7 * king);
}

double rayleigh_cross_section_cm2(double wavelength_um, double co2_ppmv) {
  constexpr double pi = std::numbers::pi, molecules_per_cm3 = 2.546899e19;  // 288.15 K, 1013.25 hPa
  const double excess = air_refractivity(wavelength_um, co2_ppmv), square = excess * (2 + excess);  // n^2 - 1
  const double wavelength_cm = 1e-4 * wavelength_um, length2 = wavelength_cm * wavelength_cm;
  const double ratio = square / (molecules_per_cm3 * (square + 3));
  return 24 * pi * pi * pi * ratio * ratio / (length2 * length2) * air_king_factor(wavelength_um, co2_ppmv);
}

std::vector<double> rayleigh_moments(double depolarization) {
  return {1, 0, 0.1 * (1 - depolarization) / (1 + 0.5 * depolarization)};
}

double rayleigh_depth_above(const AirProfile& profile, double height_km, double wavelength_um) {
  const double co2_ppmv = profile.at(height_km).ppmv(Gas::co2);
  return rayleigh_cross_section_cm2(wavelength_um, co2_ppmv) * profile.air_above_per_cm2(height_km);
}

}  // namespace raycube::atmos
