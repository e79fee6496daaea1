#include "atmos_tables/aerosol/aerosol_column.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

#include "atmos_tables/aerosol/aerosol_heights.h"
#include "atmos_tables/aerosol/own_aerosol.h"
#include "atmos_tables/optics/profile_scaling.h"
#include "host/base/error.h"

namespace raycube::atmos {

namespace {

constexpr double kTroposphericHumidity_percent = 70;  ///< LOWTRAN7 and MODTRAN hold the troposphere's there
constexpr double kMaxCloudDepth = 700;

std::string text(double value) {
  std::ostringstream out;
  out.precision(6);
  out << value;
  return out.str();
}

const char* volcanic_substance(StratosphereModel model) {
  switch (model) {
    case StratosphereModel::background:
      return "stratospheric";
    case StratosphereModel::moderate_volcanic:
      return "volcanic_aged";
    default:
      return "volcanic_fresh";
  }
}

/// Weighted with the extinction; slices of 1/300 of the layer.
double mean_humidity_percent(const HeightProfile& layer, const AirProfile& profile) {
  const double base_km = layer.knots().front().height_km, step_km = (layer.knots().back().height_km - base_km) / 300;
  double sum = 0, weight = 0;
  for (int i = 0; i < 300; ++i) {
    const double height_km = base_km + (i + 0.5) * step_km, extinction = layer.extinction_per_km(height_km);
    if (height_km > profile.top_km()) break;
    sum += extinction * relative_humidity_percent(profile.at(height_km)), weight += extinction;
  }
  return weight > 0 ? sum / weight : relative_humidity_percent(profile.levels()[0]);
}

void check(const AerosolSpec& spec, const AirProfile& profile) {
  base::Problems problems;
  const auto range = [&](const std::string& element, const std::string& what, double value, double low, double high) {
    if (!(value >= low && value <= high))
      problems.add({"", 0, 0, element}, what + " must lie in " + text(low) + ".." + text(high), text(value),
                   "change it");
  };
  const bool by_depth = !(spec.aod_550 < 0);
  if (spec.boundary != AerosolModel::none) {
    range("aerosol", "ground altitude, km,", profile.ground_km(), -1, kMaxAerosolGround_km);
    if (by_depth && !std::isfinite(spec.aod_550))
      problems.add({"", 0, 0, "aerosol"}, "optical depth must be a number", text(spec.aod_550), "change it");
    if (!by_depth) range("aerosol", "visibility, km,", spec.visibility_km, kMinVisibility_km, 1e6);
    if (!(spec.humidity_percent < 0)) range("aerosol", "relative humidity, %,", spec.humidity_percent, 0, 100);
    if (spec.boundary == AerosolModel::desert) range("aerosol", "wind speed, m/s,", spec.wind_m_s, 0, 30);
  }
  for (std::size_t i = 0; i < spec.clouds.size(); ++i) {
    const CloudLayer& cloud = spec.clouds[i];
    const std::string element = "cloud " + std::to_string(i + 1);
    range(element, "base, km above the sea,", cloud.base_km, profile.ground_km(), profile.top_km());
    range(element, "top, km above the sea,", cloud.top_km, profile.ground_km(), profile.top_km());
    range(element, "optical depth at 0.55 um", cloud.optical_depth_550, 0, kMaxCloudDepth);
    if (!(cloud.base_km < cloud.top_km))
      problems.add({"", 0, 0, element}, "base must lie below top",
                   text(cloud.base_km) + " and " + text(cloud.top_km) + " km",
                   "exchange them or give the layer a thickness");
  }
  problems.throw_if_any();
}

}  // namespace

double relative_humidity_percent(const AirLevel& level) {
  const double vapour_hPa = 1e4 * kBoltzmann_J_per_K * level.gas(Gas::h2o) * level.temperature_K;
  return 100 * vapour_hPa / saturation_pressure_hPa(level.temperature_K);
}

AerosolColumn::AerosolColumn(const AerosolSpec& spec, const AirProfile& profile)
    : henyey_greenstein_(spec.henyey_greenstein),
      between_waves_(spec.lowtran_rules ? BetweenWaves::linear : BetweenWaves::power_law) {
  check(spec, profile);
  if (spec.boundary != AerosolModel::none) add_aerosols(spec, profile);
  add_own(spec, profile);
  add_clouds(spec);
}

void AerosolColumn::add_aerosols(const AerosolSpec& spec, const AirProfile& profile) {
  const double ground_km = profile.ground_km();
  const auto regions = [&](double visibility) {
    return aerosol_heights(visibility, spec.spring_summer, spec.stratosphere, ground_km);
  };
  visibility_km_ = spec.visibility_km;
  if (!(spec.aod_550 < 0))
    visibility_km_ = visibility_for_depth_km(spec.aod_550, spec.spring_summer, spec.stratosphere, ground_km);
  if (visibility_km_ > max_visibility_km()) {
    notices_.push_back("aerosol: visibility " + text(visibility_km_) +
                       " km; without aerosol in the boundary layer it is " + text(max_visibility_km()) +
                       " km, which is used");
    visibility_km_ = max_visibility_km();
  }
  AerosolHeights heights = regions(visibility_km_);
  const double least = total_depth(regions(max_visibility_km()));
  if (!(spec.aod_550 < 0) && spec.aod_550 < least) {
    notices_.push_back("aerosol: optical depth " + text(spec.aod_550) + " at 0.55 um is less than the " + text(least) +
                       " of air at its clearest; all heights are scaled by " + text(spec.aod_550 / least));
    for (HeightProfile& region : heights) region.scale(spec.aod_550 / least);
  }
  aod_550_ = total_depth(heights);
  humidity_percent_ = spec.humidity_percent;
  if (humidity_percent_ < 0)
    humidity_percent_ = spec.lowtran_rules ? mean_humidity_percent(heights[0], profile)
                                           : relative_humidity_percent(profile.levels()[0]);
  if (humidity_percent_ > kMaxHumidity_percent) {
    notices_.push_back("aerosol: relative humidity " + text(humidity_percent_) +
                       " % in the boundary layer; the figures end at 99 %, which is used");
    humidity_percent_ = kMaxHumidity_percent;
  }
  const double grade = spec.boundary == AerosolModel::desert ? spec.wind_m_s : humidity_percent_;
  components_.push_back({to_string(spec.boundary), heights[0], Substance(to_string(spec.boundary), grade), {}, {}});
  components_.push_back({"troposphere", heights[1], Substance("tropospheric", kTroposphericHumidity_percent), {}, {}});
  components_.push_back({"stratosphere", heights[2], Substance(volcanic_substance(spec.stratosphere), 0), {}, {}});
  components_.push_back({"upper air", heights[3], Substance("meteoric", 0), {}, {}});
  if (spec.boundary == AerosolModel::desert && !henyey_greenstein_)
    notices_.push_back(
        "desert aerosol: the figures hold no Mie function; Henyey-Greenstein is used, its backscatter is too low");
}

void AerosolColumn::add_own(const AerosolSpec& spec, const AirProfile& profile) {
  for (const scene::OwnAerosolSpec& aerosol : spec.own) {
    Component component{
        aerosol.name, own_heights(aerosol, profile.ground_km(), profile.top_km()), {}, {}, own_optics(aerosol)};
    for (const Component& other : components_)
      if (other.name == component.name)
        throw base::Error(
            base::Fault::input,
            "aerosol '" + component.name + "': another component of the air has that name; choose one of its own");
    const double depth_550 = aerosol.optical_depth / component.own->at(aerosol.at_um).extinction;
    if (!(depth_550 <= kMaxCloudDepth))
      throw base::Error(base::Fault::input, "aerosol '" + component.name + "': optical depth " + text(depth_550) +
                                                " at 0.55 um, to which depths are referred, is more than " +
                                                text(kMaxCloudDepth) +
                                                "; check optical_depth, wavelength_nm and the Angstrom exponent");
    component.heights.scale(depth_550 / component.heights.depth(profile.ground_km(), profile.top_km()));
    aod_550_ += depth_550;
    components_.push_back(std::move(component));
  }
}

void AerosolColumn::add_clouds(const AerosolSpec& spec) {
  for (const CloudLayer& cloud : spec.clouds) {
    const double extinction = cloud.optical_depth_550 / (cloud.top_km - cloud.base_km);
    Component component{cloud.droplets ? "droplets" : to_string(cloud.kind),
                        HeightProfile({{cloud.base_km, extinction}, {cloud.top_km, extinction}}),
                        {},
                        {},
                        {}};
    const bool ice = cloud.kind == CloudKind::cirrus_64um || cloud.kind == CloudKind::cirrus_4um;
    if (cloud.droplets)
      component.own = std::make_shared<const DropletOptics>(*cloud.droplets);
    else
      component.substance.emplace(to_string(cloud.kind), 0);
    if (component.substance && !component.substance->has_phase() && !ice)
      component.droplets = {Substance("fog_radiative", 0), Substance("fog_advective", 0)};
    else if (component.substance && ice && !henyey_greenstein_)
      notices_.push_back(
          component.name +
          ": the figures hold no phase function of ice; Henyey-Greenstein is used, no halo, backscatter too low");
    components_.push_back(std::move(component));
  }
}

double AerosolColumn::extinction_550_per_km(std::size_t component, double height_km) const {
  return components_.at(component).heights.extinction_per_km(height_km);
}

double AerosolColumn::depth_550(std::size_t component, double low_km, double high_km) const {
  return components_.at(component).heights.depth(low_km, high_km);
}

std::vector<double> AerosolColumn::level_km() const {
  std::vector<double> out;
  for (const Component& component : components_)
    for (const HeightProfile::Knot& knot : component.heights.knots()) out.push_back(knot.height_km);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

PhaseFunction AerosolColumn::phase(const Component& component, double wavelength_um, double asymmetry) const {
  if (henyey_greenstein_) return PhaseFunction::henyey_greenstein(asymmetry);
  if (component.own) return component.own->phase(wavelength_um);
  if (component.substance->has_phase()) return component.substance->phase(wavelength_um);
  if (component.droplets.empty()) return PhaseFunction::henyey_greenstein(asymmetry);
  // Water clouds: the Mie functions of the two fogs (droplets of the same order of size), mixed to the cloud's own
  // asymmetry.
  const PhaseFunction small = component.droplets[0].phase(wavelength_um),
                      large = component.droplets[1].phase(wavelength_um);
  const double g0 = small.asymmetry(), g1 = large.asymmetry();
  const double share = g0 == g1 ? 0.5 : std::clamp((asymmetry - g0) / (g1 - g0), 0.0, 1.0);
  return PhaseFunction::mixture(small, 1 - share, large, share);
}

void AerosolColumn::check_covers(double first_um, double last_um) const {
  base::Problems problems;
  for (const Component& one : components_) {
    const auto [from_um, to_um] = one.own ? one.own->covers_um() : std::pair(kMinAerosolWave_um, kMaxAerosolWave_um);
    if (!(from_um <= first_um && to_um >= last_um))
      problems.add({"", 0, 0, "aerosol '" + one.name + "'"},
                   "its optics cover " + text(from_um) + " to " + text(to_um) + " um, and the table more",
                   text(first_um) + " to " + text(last_um) + " um", "add rows, or narrow the bands");
  }
  problems.throw_if_any();
}

AerosolColumn::Optics AerosolColumn::optics(std::size_t component, double wavelength_um) const {
  const Component& one = components_.at(component);
  const SubstanceOptics at = one.own ? one.own->at(wavelength_um) : one.substance->at(wavelength_um, between_waves_);
  return {at.extinction, 1 - at.absorption / at.extinction, at.asymmetry,
          std::make_shared<const PhaseFunction>(phase(one, wavelength_um, at.asymmetry))};
}

double AerosolColumn::backscatter_per_sr(std::size_t component, double wavelength_um) const {
  const Optics at = optics(component, wavelength_um);
  return at.extinction_ratio * at.scattering_albedo * at.phase->value(-1) / (4 * std::numbers::pi);
}

}  // namespace raycube::atmos
