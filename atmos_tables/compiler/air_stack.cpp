#include "atmos_tables/compiler/air_stack.h"

#include <algorithm>
#include <cmath>

#include "atmos_tables/optics/profile_fill.h"
#include "atmos_tables/optics/profile_scaling.h"
#include "atmos_tables/optics/rayleigh_air.h"
#include "atmos_tables/optics/standard_air.h"
#include "atmos_tables/solver/slant_path.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

constexpr double kSame_km = kSameHeight_km;
/// Refraction is that of 0.55 um everywhere: dispersion changes airmass by less than 1e-4 up to 85 deg.
constexpr double kRefractionAt_um = 0.55;
/// Layers of the solver where nothing asks for finer ones, km above the sea.
constexpr double kBase_km[] = {0.5, 1, 2, 3, 4, 5, 6, 8, 10, 12, 15, 18, 21, 25, 30, 35, 40, 50, 70};
/// LOWTRAN7's layers are 1 km thick up to 25 km, then:
constexpr double kLowtranAbove_km[] = {30, 35, 40, 45, 50, 70};

AfglModel model_of(const scene::AirSpec& spec) {
  for (std::size_t i = 0; i < kAfglNames.size(); ++i)
    if (spec.profile == kAfglNames[i]) return static_cast<AfglModel>(i);
  throw base::Error(base::Fault::input, "'" + spec.profile + "' is no model atmosphere; a file goes into profile_file");
}

AirProfile base_profile(const scene::AirSpec& spec, std::vector<std::string>& notices) {
  if (spec.profile_file.empty()) return afgl_profile(model_of(spec));
  CompletedProfile made = completed(read_profile_csv(spec.profile_file), model_of(spec), kTopOfStack_km);
  notices.insert(notices.end(), made.notices.begin(), made.notices.end());
  return std::move(made.air);
}

std::vector<double> stack_levels(const scene::AirSpec& spec, double ground_km, double top_km,
                                 const std::vector<double>& marks_km, const std::vector<double>& kinks_km) {
  std::vector<double> wanted = {ground_km, top_km};
  for (double mark : marks_km) {
    if (mark < ground_km - kSame_km)
      throw base::Error(base::Fault::input, "a height of " + std::to_string(mark) +
                                                " km lies below the ground of the air, " + std::to_string(ground_km) +
                                                " km");
    if (mark < top_km) wanted.push_back(std::max(mark, ground_km));
  }
  std::vector<double> optional(std::begin(kBase_km), std::end(kBase_km));
  if (spec.gas_bands == "lowtran") {
    optional.assign(std::begin(kLowtranAbove_km), std::end(kLowtranAbove_km));
    for (int km = 1; km <= 25; ++km) optional.push_back(km);
  }
  optional.insert(optional.end(), kinks_km.begin(), kinks_km.end());
  // The base grid cut into layering parts: the knob of the speed-and-accuracy chart.
  std::vector<double> sorted = optional;
  sorted.insert(sorted.end(), wanted.begin(), wanted.end());
  std::sort(sorted.begin(), sorted.end());
  for (int part = 1; part < spec.layering; ++part)
    for (std::size_t i = 0; i + 1 < sorted.size(); ++i)
      optional.push_back(sorted[i] + (sorted[i + 1] - sorted[i]) * part / spec.layering);
  std::vector<double> levels;
  const auto taken = [&](double height, double distance) {
    return std::any_of(levels.begin(), levels.end(),
                       [&](double level) { return std::abs(level - height) <= distance; });
  };
  for (double height : wanted)
    if (!taken(height, kSame_km)) levels.push_back(height);
  for (double height : optional)  // a level within 20 m of one that is there buys nothing
    if (height > ground_km && height < top_km && !taken(height, 0.02)) levels.push_back(height);
  std::sort(levels.begin(), levels.end());
  return levels;
}

}  // namespace

AirProfile make_profile(const scene::AirSpec& spec, double ground_km, std::vector<std::string>& notices) {
  AirProfile profile = cut_at_ground(extended_down(base_profile(spec, notices), ground_km), ground_km);
  if (spec.pressure_hPa >= 0) profile = with_ground_pressure(profile, spec.pressure_hPa);
  if (spec.co2_ppmv >= 0) profile = with_ground_mixing_ratio(profile, Gas::co2, spec.co2_ppmv);
  if (spec.ch4_ppmv >= 0) profile = with_ground_mixing_ratio(profile, Gas::ch4, spec.ch4_ppmv);
  if (spec.ozone_atm_cm >= 0) profile = with_ozone_column(profile, spec.ozone_atm_cm);
  if (spec.water_g_cm2 >= 0) {
    WaterScaling scaled = with_water_column(profile, spec.water_g_cm2);
    if (scaled.capped_levels > 0)
      notices.push_back("atmosphere: water was held at saturation at " + std::to_string(scaled.capped_levels) +
                        " levels; the others carry the rest of the column");
    profile = std::move(scaled.profile);
  }
  return profile;
}

AerosolSpec make_aerosols(const scene::AirSpec& spec) {
  AerosolSpec out;
  out.boundary = parse_aerosol(spec.aerosol);
  out.stratosphere = parse_stratosphere(spec.stratosphere);
  out.visibility_km = spec.visibility_km;
  out.aod_550 = spec.aod_550;
  out.humidity_percent = spec.humidity_percent;
  out.spring_summer = spec.season == "spring_summer";
  out.wind_m_s = spec.wind_m_s;
  out.henyey_greenstein = spec.henyey_greenstein;
  out.lowtran_rules = spec.gas_bands == "lowtran";
  out.own = spec.own_aerosols;
  for (const scene::CloudSpec& cloud : spec.clouds)
    out.clouds.push_back({cloud.base_km, cloud.top_km, cloud.optical_depth_550, parse_cloud(cloud.kind)});
  return out;
}

AirStack::AirStack(const scene::AirSpec& spec, double ground_km, const std::vector<double>& marks_km,
                   const LineAir& lines)
    : profile_(make_profile(spec, ground_km, notices_)),
      aerosols_(make_aerosols(spec), profile_),
      level_km_(stack_levels(spec, profile_.ground_km(), std::min(kTopOfStack_km, profile_.top_km()), marks_km,
                             aerosols_.level_km())),
      gases_(profile_, level_km_, spec.gas_bands == "lowtran" ? BandModel::lowtran : BandModel::blended) {
  for (const std::string& notice : aerosols_.notices()) notices_.push_back(notice);
  for (const std::string& notice : lines.notices) notices_.push_back(notice);
  if (!lines.gases.empty())
    bands_.emplace(without_resolved(profile_, lines), level_km_,
                   spec.gas_bands == "lowtran" ? BandModel::lowtran : BandModel::blended);
  co2_ppmv_ = profile_.levels().front().ppmv(Gas::co2);
  const double refractivity = air_refractivity(kRefractionAt_um, co2_ppmv_);
  // The refractive index is stated at 288.15 K and 1013.25 hPa; n - 1 goes with density.
  const double standard_per_cm3 = kLoschmidt_per_cm3 * 273.15 / 288.15;
  for (std::size_t i = 0; i < level_km_.size(); ++i) {
    const AirLevel level = profile_.at(level_km_[i]);
    temperature_K_.push_back(level.temperature_K);
    refractivity_.push_back(refractivity * level.air_per_cm3 / standard_per_cm3);
    if (i + 1 < level_km_.size()) air_column_.push_back(profile_.air_column_per_cm2(level_km_[i], level_km_[i + 1]));
  }
  for (std::size_t i = 0; i + 1 < level_km_.size(); ++i) {
    // LOWTRAN7's mean by density: temperature linear, density exponential between the layer's edges.
    const AirLevel low = profile_.at(level_km_[i]), high = profile_.at(level_km_[i + 1]);
    const double fall = std::log(low.air_per_cm3 / high.air_per_cm3);
    const double share = std::abs(fall) < 1e-4 ? 0.5 - fall / 12 : 1 / fall - 1 / std::expm1(fall);
    mean_temperature_K_.push_back(low.temperature_K + share * (high.temperature_K - low.temperature_K));
  }
  // What the profile's top carries belongs to the topmost layer (5e-7 of the column at 100 km).
  air_column_.back() += profile_.air_above_per_cm2(level_km_.back());
}

std::size_t AirStack::level_of(double height_km) const {
  if (height_km >= level_km_.back()) return level_km_.size() - 1;
  for (std::size_t i = 0; i < level_km_.size(); ++i)
    if (std::abs(level_km_[i] - height_km) <= kSame_km) return i;
  throw base::Error(base::Fault::bug, "no level of the air lies at " + std::to_string(height_km) + " km");
}

std::vector<double> AirStack::path_factors(std::size_t from, std::size_t to, double zenith_deg) const {
  std::vector<double> factor(layers(), 0.0);
  if (to <= from) return factor;
  solver::RefractingAir air;
  air.planet_radius_m = 1000 * kPlanetRadius_km;
  for (std::size_t i = to + 1; i-- > from;) {
    air.height_m.push_back(1000 * level_km_[i]);
    air.refractivity.push_back(refractivity_[i]);
  }
  const std::vector<double> slant = solver::slant_factors(air, zenith_deg);
  for (std::size_t i = 0; i < slant.size(); ++i) factor[to - 1 - i] = slant[i];
  return factor;
}

}  // namespace raycube::atmos
