#include "atmos_tables/row_registry.h"

#include <cmath>
#include <limits>
#include <sstream>

namespace raycube::atmos {

namespace {
constexpr double kAny = std::numeric_limits<float>::max();
constexpr const char* kRadiance = "W m-2 sr-1 um-1";
constexpr const char* kIrradiance = "W m-2 um-1";

std::string limit(double value) {
  if (value == kAny) return "";
  if (value == -kAny) return "";
  std::ostringstream out;
  out << value;
  return out.str();
}
}  // namespace

const std::vector<AxisSpec>& axis_registry() {
  static const std::vector<AxisSpec> list = {
      {"wavelength", "um", 0.05, 1000, "vacuum (or air, where the header's medium says so)"},
      {"target_height", "m", -1000, 200000, "of the point looked at or lit, above the scene's z = 0"},
      {"view_zenith", "deg", 0, 89.9, "at the target, of the direction towards the sensor"},
      {"relative_azimuth", "deg", 0, 180, "azimuth of the sensor minus that of the sun, folded; 0 = on the sun's side"},
      {"sky_zenith", "deg", 0, 90, "of the direction towards the sky point"},
      {"sky_azimuth", "deg", 0, 180, "azimuth of the sky point minus that of the sun, folded; 0 = on the sun's side"},
      {"scattering_angle", "deg", 0, 180, "between the directions the light travels before and after"},
      {"range_height", "m", -1000, 200000, "height of a lidar profile's node above the scene's z = 0"},
      {"k", "1", 0, 1e6, "index of the k-term; sums over k take the row k_weight"},
  };
  return list;
}

const std::vector<RowSpec>& row_registry() {
  static const std::vector<RowSpec> list = {
      {"solar_irradiance", kIrradiance, "wavelength", 0, kAny,
       "E0: exoatmospheric irradiance normal to the beam, after the earth-sun factor"},
      {"sun_transmission", "1", "wavelength [k] target_height", 0, 1,
       "top of the air to the target along the sun's path"},
      {"sun_optical_depth", "1", "wavelength [k] target_height", 0, kAny,
       "-ln sun_transmission, where a float transmission would round to 1 or 0"},
      {"view_transmission", "1", "wavelength [k] target_height view_zenith", 0, 1, "target to sensor"},
      {"view_optical_depth", "1", "wavelength [k] target_height view_zenith", 0, kAny, "-ln view_transmission"},
      {"two_way_factor", "1", "wavelength target_height view_zenith", 0, kAny,
       "R2 = T(sun to target to sensor) / (T_sun T_view): band transmittances do not multiply"},
      {"two_way_factor_thermal", "1", "wavelength target_height view_zenith", 0, kAny,
       "the same ratio for reflected sky emission"},
      {"path_radiance_solar", kRadiance, "wavelength target_height view_zenith relative_azimuth", 0, kAny,
       "sunlight scattered into the path from target to sensor, over black ground"},
      {"path_radiance_thermal", kRadiance, "wavelength target_height view_zenith", 0, kAny,
       "light emitted by the path from target to sensor"},
      {"sky_radiance_solar", kRadiance, "wavelength target_height sky_zenith sky_azimuth", 0, kAny,
       "sunlight scattered down to the target, the sun's disc excluded"},
      {"sky_radiance_thermal", kRadiance, "wavelength target_height sky_zenith", 0, kAny, "emitted by the sky"},
      {"sky_phase_mean", "1", "wavelength target_height scattering_angle", 0, kAny,
       "column-mean phase function above the target (sphere integral 4 pi); divides the sky between nodes"},
      {"sky_scattering_depth", "1", "wavelength target_height", 0, kAny,
       "vertical scattering depth above the target, for the single-scatter shape that divides the sky between nodes"},
      {"direct_irradiance", kIrradiance, "wavelength target_height", 0, kAny, "direct sun on a horizontal plane"},
      {"diffuse_irradiance", kIrradiance, "wavelength target_height", 0, kAny,
       "sky on a horizontal plane, the sun's disc excluded"},
      {"spherical_albedo", "1", "wavelength target_height", 0, 1, "S: of the air seen from below, isotropic light"},
      {"diffuse_view_transmission", "1", "wavelength target_height view_zenith", 0, 1,
       "T_dif: radiance at the sensor beside the direct path, per unit isotropic upward radiance of the ground at the "
       "target's level"},
      {"diffuse_return", "1", "wavelength target_height sky_zenith", 0, 1,
       "t: radiance that comes back down for unit isotropic upward radiance; S = 2 int t mu dmu"},
      {"air_temperature", "K", "range_height", 100, 400, "of the profile behind the thermal rows"},
      {"lidar_extinction_molecular", "m-1", "wavelength range_height", 0, kAny, "Rayleigh extinction profile"},
      {"lidar_extinction_aerosol", "m-1", "wavelength range_height", 0, kAny, "aerosol extinction profile"},
      {"lidar_extinction_gas", "m-1", "wavelength range_height", 0, kAny,
       "gas absorption profile: lines or cross-sections of a user's file, continua, ozone; absent without such a file"},
      {"lidar_backscatter_molecular", "m-1 sr-1", "wavelength range_height", 0, kAny, "Rayleigh backscatter profile"},
      {"lidar_backscatter_aerosol", "m-1 sr-1", "wavelength range_height", 0, kAny, "aerosol backscatter profile"},
      {"lidar_depolarization", "1", "wavelength range_height", 0, 1,
       "perpendicular over parallel backscatter of a linearly polarised beam"},
      {"k_weight", "1", "wavelength k", 0, 1, "weights of the k-terms; sum 1 at every wavelength"},
  };
  return list;
}

const AxisSpec* find_axis_spec(std::string_view name) {
  for (const AxisSpec& spec : axis_registry())
    if (name == spec.name) return &spec;
  return nullptr;
}

const RowSpec* find_row_spec(std::string_view name) {
  for (const RowSpec& spec : row_registry())
    if (name == spec.name) return &spec;
  return nullptr;
}

std::string registry_markdown() {
  std::ostringstream out;
  out << "| axis | unit | nodes from | to | what it is |\n|---|---|---|---|---|\n";
  for (const AxisSpec& spec : axis_registry())
    out << "| `" << spec.name << "` | " << spec.unit << " | " << limit(spec.min) << " | " << limit(spec.max) << " | "
        << spec.text << " |\n";
  out << "\n| row | unit | axes | least | most | what it is |\n|---|---|---|---|---|---|\n";
  for (const RowSpec& spec : row_registry())
    out << "| `" << spec.name << "` | " << spec.unit << " | " << spec.axes << " | " << limit(spec.min) << " | "
        << limit(spec.max) << " | " << spec.text << " |\n";
  return out.str();
}

}  // namespace raycube::atmos
