#include "atmos_tables/optics/profile_scaling.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::atmos {

namespace {

[[noreturn]] void refuse(const AirProfile& profile, const std::string& what, double found, const std::string& way_out) {
  throw base::Error(base::Fault::input,
                    "profile " + profile.source() + ": " + what + " (found " + std::to_string(found) + "); " + way_out);
}

AirProfile scale_gas(const AirProfile& profile, Gas gas, double factor) {
  std::vector<AirLevel> levels = profile.levels();
  for (AirLevel& level : levels) level.gas(gas) *= factor;
  return AirProfile(std::move(levels), profile.source());
}

/// Most water a level may hold, molecules per cm3: 100 % relative humidity; above 300 hPa no larger share of the air
/// than the coldest level passed on the way up lets through, or the warm stratosphere would fill. Never below what the
/// table holds.
std::vector<double> water_caps_per_cm3(const AirProfile& profile) {
  std::vector<double> out;
  double share = 0.5;
  for (const AirLevel& level : profile.levels()) {
    const double saturated = saturation_per_cm3(level.temperature_K);
    if (level.pressure_hPa < 300) share = std::min(share, saturated / level.air_per_cm3);
    out.push_back(std::max(level.gas(Gas::h2o), std::min(saturated, share * level.air_per_cm3)));
  }
  return out;
}

WaterScaling capped(const AirProfile& profile, double factor) {
  std::vector<AirLevel> levels = profile.levels();
  const std::vector<double> caps = water_caps_per_cm3(profile);
  std::size_t count = 0;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const double wanted = factor * levels[i].gas(Gas::h2o);
    levels[i].gas(Gas::h2o) = std::min(wanted, caps[i]);
    count += wanted > caps[i];
  }
  return {AirProfile(std::move(levels), profile.source()), factor, count};
}

}  // namespace

AirProfile extended_down(const AirProfile& profile, double ground_km) {
  // The gradient is that of the lowest kilometre: thin layers and inversions at the ground do not run away.
  const AirLevel &low = profile.levels()[0], next = profile.at(std::min(low.height_km + 1, profile.top_km()));
  if (ground_km >= low.height_km - kSameHeight_km) return profile;
  if (!(ground_km >= low.height_km - 1))
    throw base::Error(base::Fault::input,
                      fmt::format("{}: the ground lies more than 1 km below the profile's lowest level of {:.6g} km "
                                  "(found ground at {:.6g} km above the sea); give ground_height_m (--ground-height) "
                                  "of the site, or a profile that reaches it",
                                  profile.source(), low.height_km, ground_km));
  const double part = (low.height_km - ground_km) / (next.height_km - low.height_km);
  const auto beyond = [part](double at, double above) {
    return at > 0 && above > 0 ? at * std::pow(at / above, part) : at;
  };
  AirLevel ground = low;
  ground.height_km = ground_km;
  ground.temperature_K = low.temperature_K + part * (low.temperature_K - next.temperature_K);
  ground.pressure_hPa = beyond(low.pressure_hPa, next.pressure_hPa);
  ground.air_per_cm3 = beyond(low.air_per_cm3, next.air_per_cm3);
  for (std::size_t g = 0; g < kGases; ++g) ground.gas_per_cm3[g] = beyond(low.gas_per_cm3[g], next.gas_per_cm3[g]);
  std::vector<AirLevel> levels = {ground};
  levels.insert(levels.end(), profile.levels().begin(), profile.levels().end());
  return AirProfile(std::move(levels), profile.source());
}

AirProfile cut_at_ground(const AirProfile& profile, double ground_km) {
  const bool below = ground_km < profile.ground_km() && ground_km >= profile.ground_km() - kSameHeight_km;
  std::vector<AirLevel> levels{profile.at(below ? profile.ground_km() : ground_km)};
  levels.front().height_km = ground_km;
  for (const AirLevel& level : profile.levels())
    if (level.height_km > ground_km + kSameHeight_km) levels.push_back(level);
  return AirProfile(std::move(levels), profile.source());
}

AirProfile with_ground_pressure(const AirProfile& profile, double pressure_hPa) {
  if (!(pressure_hPa >= 300 && pressure_hPa <= 1100))
    refuse(profile, "ground pressure must lie in 300 to 1100 hPa", pressure_hPa, "give it in hPa at the ground itself");
  std::vector<AirLevel> levels = profile.levels();
  const double factor = pressure_hPa / levels.front().pressure_hPa;
  for (AirLevel& level : levels) {
    level.pressure_hPa *= factor, level.air_per_cm3 *= factor;
    for (Gas gas : {Gas::co2, Gas::n2o, Gas::co, Gas::ch4, Gas::o2}) level.gas(gas) *= factor;
  }
  return AirProfile(std::move(levels), profile.source());
}

double saturation_pressure_hPa(double temperature_K) {
  const double celsius = temperature_K - 273.15;
  return 6.1094 * std::exp(17.625 * celsius / (celsius + 243.04));
}

double saturation_per_cm3(double temperature_K) {
  return 1e-4 * saturation_pressure_hPa(temperature_K) / (kBoltzmann_J_per_K * temperature_K);
}

WaterScaling with_water_column(const AirProfile& profile, double water_g_cm2) {
  if (!(water_g_cm2 >= 0 && water_g_cm2 <= 20))
    refuse(profile, "water column must lie in 0 to 20 g cm-2", water_g_cm2, "correct it");
  const double here = profile.water_g_cm2();
  if (!(here > 0))
    refuse(profile, "it holds no water that could be scaled, g cm-2", here, "start from a profile with water");
  double low = 0, high = water_g_cm2 / here;  // without a cap the answer is `high`
  for (int i = 0; i < 60 && capped(profile, high).profile.water_g_cm2() < water_g_cm2 * (1 - 1e-12); ++i)
    low = high, high *= 2;
  const double most = capped(profile, high).profile.water_g_cm2();
  if (most < water_g_cm2 * (1 - 1e-12))
    refuse(profile, "no more than " + std::to_string(most) + " g cm-2 of water fit below saturation", water_g_cm2,
           "lower the column or give warmer air");
  for (int i = 0; i < 100 && high - low > 1e-15 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (capped(profile, middle).profile.water_g_cm2() < water_g_cm2 ? low : high) = middle;
  }
  return capped(profile, high);
}

AirProfile with_ozone_column(const AirProfile& profile, double ozone_atm_cm) {
  if (!(ozone_atm_cm >= 0 && ozone_atm_cm <= 2))
    refuse(profile, "ozone column must lie in 0 to 2 atm-cm", ozone_atm_cm, "1000 Dobson units are 1 atm-cm");
  const double here = profile.ozone_atm_cm();
  if (!(here > 0))
    refuse(profile, "it holds no ozone that could be scaled, atm-cm", here, "start from a profile with ozone");
  return scale_gas(profile, Gas::o3, ozone_atm_cm / here);
}

AirProfile with_ground_mixing_ratio(const AirProfile& profile, Gas gas, double ppmv) {
  const std::string name = kGasNames[static_cast<std::size_t>(gas)];
  if (!(ppmv >= 0 && ppmv <= 5e5)) refuse(profile, name + " must lie in 0 to 500000 ppmv", ppmv, "correct it");
  const double here = profile.levels().front().ppmv(gas);
  if (!(here > 0))
    refuse(profile, "it holds no " + name + " at the ground that could be scaled, ppmv", here,
           "start from another profile");
  return scale_gas(profile, gas, ppmv / here);
}

}  // namespace raycube::atmos
