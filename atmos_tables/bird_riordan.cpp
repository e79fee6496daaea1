#include "atmos_tables/bird_riordan.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/units.h"

namespace raycube::atmos {

const std::vector<BirdRiordanLine>& bird_riordan_table() {
  static const std::vector<BirdRiordanLine> lines = {
#include "atmos_tables/data/bird_riordan_1986.inc"
  };
  return lines;
}

BirdRiordanLine bird_riordan_at(double wavelength_um) {
  const auto& lines = bird_riordan_table();
  auto upper = std::upper_bound(lines.begin(), lines.end(), wavelength_um,
                                [](double value, const BirdRiordanLine& line) { return value < line.wavelength_um; });
  if (upper == lines.begin()) ++upper;
  if (upper == lines.end()) --upper;
  const BirdRiordanLine &a = *(upper - 1), &b = *upper;
  const double w = (wavelength_um - a.wavelength_um) / (b.wavelength_um - a.wavelength_um);
  const auto mix = [w](double x, double y) { return (1 - w) * x + w * y; };
  return {wavelength_um, mix(a.solar_irradiance, b.solar_irradiance), mix(a.water, b.water), mix(a.ozone, b.ozone),
          mix(a.mixed, b.mixed)};
}

double water_depth(double coefficient, double water_cm) {
  const double x = coefficient * water_cm;
  return x <= 0 ? 0 : 0.2385 * x / std::pow(1 + 20.07 * x, 0.45);
}

double mixed_gas_depth(double coefficient, double mixed_airmass) {
  const double x = coefficient * mixed_airmass;
  return x <= 0 ? 0 : 1.41 * x / std::pow(1 + 118.3 * x, 0.45);
}

double forward_fraction(double asymmetry, double cos_sun_zenith) {
  const double alg = std::log(1 - asymmetry);
  const double afs = alg * (1.459 + alg * (0.1595 + alg * 0.4129));
  const double bfs = alg * (0.0783 + alg * (-0.3824 - alg * 0.5874));
  return 1 - 0.5 * std::exp((afs + bfs * cos_sun_zenith) * cos_sun_zenith);
}

double short_wave_correction(double wavelength_um) {
  return wavelength_um <= 0.45 ? std::pow(wavelength_um + 0.55, 1.8) : 1.0;
}

double diffuse_irradiance_black_ground(double wavelength_um, double solar_irradiance, double cos_sun_zenith,
                                       double asymmetry, const SlantTransmission& t) {
  const double common = solar_irradiance * cos_sun_zenith * t.gas * t.aerosol_absorption;
  const double rayleigh = common * 0.5 * (1 - std::pow(t.rayleigh, 0.95));
  const double aerosol =
      common * std::pow(t.rayleigh, 1.5) * (1 - t.aerosol_scattering) * forward_fraction(asymmetry, cos_sun_zenith);
  return (rayleigh + aerosol) * short_wave_correction(wavelength_um);
}

double sky_reflectance(double asymmetry, const SlantTransmission& t) {
  return t.gas * t.aerosol_absorption *
         (0.5 * (1 - t.rayleigh) +
          (1 - forward_fraction(asymmetry, 1 / 1.8)) * t.rayleigh * (1 - t.aerosol_scattering));
}

double aerosol_albedo(double ssa_400, double wavelength_um) {
  const double x = std::log(wavelength_um / 0.4);
  return ssa_400 * std::exp(-0.095 * x * x);
}

double earth_sun_factor(int day_of_year) {
  if (day_of_year == 0) return 1;
  const double psi = 2 * std::numbers::pi * (day_of_year - 1) / 365.0;
  return 1.00011 + 0.034221 * std::cos(psi) + 0.00128 * std::sin(psi) + 0.000719 * std::cos(2 * psi) +
         0.000077 * std::sin(2 * psi);
}

std::vector<BirdRiordanLight> bird_riordan_model(const BirdRiordanCase& in) {
  const double mu0 = std::cos(base::rad_by_division(in.sun_zenith_deg));
  const double factor = earth_sun_factor(in.day_of_year);
  const double pressure = in.pressure_Pa / 101300.0;
  const double ozone_airmass = (1 + 22.0 / 6370) / std::sqrt(mu0 * mu0 + 2 * 22.0 / 6370);
  std::vector<BirdRiordanLight> out;
  for (const BirdRiordanLine& line : bird_riordan_table()) {
    const double l = line.wavelength_um, e0 = line.solar_irradiance * factor;
    const double aerosol_depth = in.aod_500 * std::pow(l / 0.5, -in.angstrom);
    const double albedo = aerosol_albedo(in.ssa_400, l);
    const auto at = [&](double airmass, double airmass_ozone) {
      SlantTransmission t;
      const double l2 = l * l;
      t.rayleigh = std::exp(-airmass * pressure / (l2 * l2 * (115.6406 - 1.3366 / l2)));
      t.aerosol_scattering = std::exp(-albedo * aerosol_depth * airmass);
      t.aerosol_absorption = std::exp(-(1 - albedo) * aerosol_depth * airmass);
      t.gas = std::exp(-water_depth(line.water, in.water_cm * airmass) - line.ozone * in.ozone_atm_cm * airmass_ozone -
                       mixed_gas_depth(line.mixed, airmass * pressure));
      return t;
    };
    const SlantTransmission t = at(in.airmass, ozone_airmass);
    const double direct = e0 * t.gas * t.rayleigh * t.aerosol_scattering * t.aerosol_absorption;
    const double black = diffuse_irradiance_black_ground(l, e0, mu0, in.asymmetry, t);
    // Eq. 3-9 leaves ozone out of the sky reflectance and evaluates the rest at airmass 1.8.
    SlantTransmission t18 = at(1.8, 0.0);
    const double sky = sky_reflectance(in.asymmetry, t18);
    const double cs = short_wave_correction(l);
    const double ground = (direct * mu0 + black / cs) * in.ground_albedo * sky / (1 - in.ground_albedo * sky) * cs;
    out.push_back({e0, direct, black + ground});
  }
  return out;
}

}  // namespace raycube::atmos
