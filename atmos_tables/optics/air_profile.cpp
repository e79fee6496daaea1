#include "atmos_tables/optics/air_profile.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "atmos_tables/single_scatter.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

constexpr double kCmPerKm = 1e5;

void check(const std::vector<AirLevel>& levels, const std::string& source) {
  base::Problems problems;
  if (levels.size() < 2)
    problems.add({source, 0, 0, ""}, "a profile needs at least 2 levels", std::to_string(levels.size()), "add levels");
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const AirLevel& level = levels[i];
    const base::Where where{source, 0, 0, "level " + std::to_string(i + 1)};
    const auto rule = [&](bool kept, const char* what, double found) {
      if (!kept) problems.add(where, what, std::to_string(found), "correct the level");
    };
    rule(level.height_km >= -1 && level.height_km <= 150, "height must lie in -1 to 150 km", level.height_km);
    rule(level.pressure_hPa > 0 && level.pressure_hPa <= 1200, "pressure must lie above 0, up to 1200 hPa",
         level.pressure_hPa);
    rule(level.temperature_K >= 100 && level.temperature_K <= 1000, "temperature must lie in 100 to 1000 K",
         level.temperature_K);
    rule(level.air_per_cm3 > 0 && level.air_per_cm3 < 1e21, "molecules of air per cm3 must be positive",
         level.air_per_cm3);
    for (double density : level.gas_per_cm3)
      rule(density >= 0 && density <= level.air_per_cm3, "a gas must lie between 0 and all molecules", density);
    if (i == 0) continue;
    rule(level.height_km > levels[i - 1].height_km, "heights must ascend strictly", level.height_km);
    rule(level.pressure_hPa < levels[i - 1].pressure_hPa, "pressure must fall with height", level.pressure_hPa);
  }
  problems.throw_if_any();
}

}  // namespace

double between(double low, double high, double fraction) {
  if (!(low > 0 && high > 0)) return low + fraction * (high - low);
  return low * std::exp(fraction * std::log(high / low));
}

double mean_between(double low, double high) {
  if (!(low > 0 && high > 0)) return 0.5 * (low + high);
  const auto [small, large] = std::minmax(low, high);
  return large * slab_mean(std::log(large / small));
}

double gravity_m_s2(double height_km) {
  const double ratio = 6356.766 / (6356.766 + height_km);
  return 9.80665 * ratio * ratio;
}

double dry_air_molecule_kg(double co2_ppmv) { return (28.9595 + 15.0556e-6 * co2_ppmv) * 1e-3 / kAvogadro; }

AirProfile::AirProfile(std::vector<AirLevel> levels, std::string source)
    : levels_(std::move(levels)), source_(std::move(source)) {
  check(levels_, source_);
}

void AirProfile::check_inside(double height_km) const {
  if (height_km >= ground_km() && height_km <= top_km()) return;
  throw base::Error(base::Fault::input, "profile " + source_ + ": height " + std::to_string(height_km) +
                                            " km lies outside " + std::to_string(ground_km()) + " to " +
                                            std::to_string(top_km()) + " km; give a profile that reaches it");
}

AirLevel AirProfile::at(double height_km) const {
  check_inside(height_km);
  const auto upper = std::upper_bound(levels_.begin() + 1, levels_.end() - 1, height_km,
                                      [](double h, const AirLevel& level) { return h < level.height_km; });
  const AirLevel &low = upper[-1], &high = *upper;
  const double f = (height_km - low.height_km) / (high.height_km - low.height_km);
  AirLevel out;
  out.height_km = height_km;
  out.pressure_hPa = between(low.pressure_hPa, high.pressure_hPa, f);
  out.temperature_K = low.temperature_K + f * (high.temperature_K - low.temperature_K);
  out.air_per_cm3 = between(low.air_per_cm3, high.air_per_cm3, f);
  for (std::size_t g = 0; g < kGases; ++g) out.gas_per_cm3[g] = between(low.gas_per_cm3[g], high.gas_per_cm3[g], f);
  return out;
}

template <class Density>
double AirProfile::column_per_cm2(double low_km, double high_km, Density&& density) const {
  check_inside(low_km), check_inside(high_km);
  double sum = 0;
  for (std::size_t i = 0; i + 1 < levels_.size(); ++i) {
    const AirLevel &low = levels_[i], &high = levels_[i + 1];
    const double from = std::max(low_km, low.height_km), to = std::min(high_km, high.height_km);
    if (!(from < to)) continue;
    const double thickness = high.height_km - low.height_km, d1 = density(low), d2 = density(high);
    sum += (to - from) * mean_between(between(d1, d2, (from - low.height_km) / thickness),
                                      between(d1, d2, (to - low.height_km) / thickness));
  }
  return sum * kCmPerKm;
}

double AirProfile::air_column_per_cm2(double low_km, double high_km) const {
  return column_per_cm2(low_km, high_km, [](const AirLevel& level) { return level.air_per_cm3; });
}

double AirProfile::gas_column_per_cm2(Gas gas, double low_km, double high_km) const {
  return column_per_cm2(low_km, high_km, [gas](const AirLevel& level) { return level.gas(gas); });
}

double AirProfile::air_above_per_cm2(double height_km) const {
  const AirLevel& top = levels_.back();
  const double mass_kg_m2 = 100 * top.pressure_hPa / gravity_m_s2(top.height_km);
  return air_column_per_cm2(height_km, top.height_km) + mass_kg_m2 * 1e-4 / dry_air_molecule_kg(top.ppmv(Gas::co2));
}

double AirProfile::water_g_cm2() const {
  return gas_column_per_cm2(Gas::h2o, ground_km(), top_km()) * kMolarMass_g[static_cast<std::size_t>(Gas::h2o)] /
         kAvogadro;
}

double AirProfile::ozone_atm_cm() const {
  return gas_column_per_cm2(Gas::o3, ground_km(), top_km()) / kLoschmidt_per_cm3;
}

}  // namespace raycube::atmos
