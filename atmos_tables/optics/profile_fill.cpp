#include "atmos_tables/optics/profile_fill.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "atmos_tables/optics/profile_scaling.h"

namespace raycube::atmos {

namespace {

using Levels = std::vector<AirLevel>;

/// The model's levels that lie inside the file's range join its own.
Levels with_model_heights(const AirProfile& own, const AirProfile& model) {
  Levels out = own.levels();
  for (const AirLevel& level : model.levels()) {
    const double height = level.height_km;
    const bool inside = height > own.ground_km() && height < own.top_km();
    const auto beside = [&](const AirLevel& other) { return std::abs(other.height_km - height) <= kSameHeight_km; };
    if (inside && std::none_of(out.begin(), out.end(), beside)) out.push_back(own.at(height));
  }
  std::sort(out.begin(), out.end(), [](const AirLevel& a, const AirLevel& b) { return a.height_km < b.height_km; });
  return out;
}

void add_gases(Levels& levels, const AirProfile& model, const std::array<bool, kGases>& given) {
  for (AirLevel& level : levels) {
    const AirLevel there = model.at(std::clamp(level.height_km, model.ground_km(), model.top_km()));
    for (std::size_t g = 0; g < kGases; ++g)
      if (!given[g]) level.gas_per_cm3[g] = there.gas_per_cm3[g] / there.air_per_cm3 * level.air_per_cm3;
    if (!given[static_cast<std::size_t>(Gas::h2o)])
      level.gas(Gas::h2o) = std::min(level.gas(Gas::h2o), saturation_per_cm3(level.temperature_K));
  }
}

/// A gas that the file states as none at every level is none above too.
void add_levels_above(Levels& levels, const AirProfile& model, const std::array<bool, kGases>& given) {
  const AirLevel top = levels.back();
  std::array<bool, kGases> none = given;
  for (std::size_t g = 0; g < kGases; ++g)
    for (const AirLevel& level : levels) none[g] = none[g] && level.gas_per_cm3[g] == 0;
  const double factor = top.pressure_hPa / model.at(std::max(top.height_km, model.ground_km())).pressure_hPa;
  for (AirLevel level : model.levels()) {
    if (level.height_km <= top.height_km + kSameHeight_km) continue;
    level.pressure_hPa *= factor, level.air_per_cm3 *= factor;
    for (std::size_t g = 0; g < kGases; ++g) level.gas_per_cm3[g] *= none[g] ? 0 : factor;
    levels.push_back(level);
  }
}

std::string shown(double value) {
  std::ostringstream out;
  out << value;
  return out.str();
}

}  // namespace

CompletedProfile completed(const ProfileFile& own, AfglModel model, double top_km) {
  CompletedProfile out{own.air, own.notices};
  std::string missing;
  for (std::size_t g = 0; g < kGases; ++g)
    if (!own.given[g]) missing += (missing.empty() ? "" : ", ") + std::string(kGasNames[g]);
  const bool ends = own.air.top_km() < top_km;
  if (missing.empty() && !ends) return out;
  const AirProfile filler = afgl_profile(model);
  Levels levels = missing.empty() ? own.air.levels() : with_model_heights(own.air, filler);
  add_gases(levels, filler, own.given);
  if (ends) add_levels_above(levels, filler, own.given);
  const std::string above = ends ? "everything above " + shown(own.air.top_km()) + " km" : "";
  const std::string name = kAfglNames[static_cast<std::size_t>(model)];
  out.notices.push_back("profile " + own.air.source() + ": " + missing + (missing.empty() || !ends ? "" : " and ") +
                        above + " as in " + name +
                        (missing.empty() ? "" : " (give a gas a column, of zeros for none)"));
  out.air = AirProfile(std::move(levels), own.air.source() + ", completed from " + name);
  return out;
}

}  // namespace raycube::atmos
