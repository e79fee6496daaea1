#include "atmos_tables/import/modtran_names.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <sstream>

#include "host/base/text.h"

namespace raycube::atmos::imported {

namespace {

struct NamedRow {
  const char *key, *name;
  Kind kind;
};

constexpr NamedRow kRows[] = {
    {"TOT_TRANS", "transmittance", Kind::ratio},
    {"TOTAL_TRANSMITTANCE", "transmittance", Kind::ratio},
    {"COMBIN_TRANS", "transmittance", Kind::ratio},
    {"TRANS", "transmittance", Kind::ratio},
    {"PTH_THRML", "path_radiance_thermal", Kind::radiance},
    {"THRML_EM", "path_radiance_thermal_emitted", Kind::radiance},
    {"PATH_EMISSION", "path_radiance_thermal_emitted", Kind::radiance},
    {"THRML_SCT", "path_radiance_thermal_scattered", Kind::radiance},
    {"PATH_THERMAL_SCAT", "path_radiance_thermal_scattered", Kind::radiance},
    {"SURF_EMIS", "surface_emission", Kind::radiance},
    {"SURFACE_EMISSION", "surface_emission", Kind::radiance},
    {"SOL_SCAT", "path_radiance_solar", Kind::radiance},
    {"MULT_SCAT", "path_radiance_solar_multiple", Kind::radiance},
    {"PATH_MULTIPLE_SCAT", "path_radiance_solar_multiple", Kind::radiance},
    {"SING_SCAT", "path_radiance_solar_single", Kind::radiance},
    {"PATH_SINGLE_SCAT", "path_radiance_solar_single", Kind::radiance},
    {"GRND_RFLT", "ground_reflected", Kind::radiance},
    {"GROUND_REFLECT", "ground_reflected", Kind::radiance},
    {"DRCT_RFLT", "ground_reflected_direct", Kind::radiance},
    {"DIRECT_REFLECT", "ground_reflected_direct", Kind::radiance},
    {"TOTAL_RAD", "radiance", Kind::radiance},
    {"TOTAL_RADIANCE", "radiance", Kind::radiance},
    {"REF_SOL", "solar_irradiance_sun_ground_sensor", Kind::irradiance},
    {"REFERENCE_IRRADIANCE", "solar_irradiance_sun_ground_sensor", Kind::irradiance},
    {"SOL_OBS", "solar_irradiance_at_sensor", Kind::irradiance},
    {"SOL_AT_OBS", "solar_irradiance_at_sensor", Kind::irradiance},
    {"IRRADIANCE_AT_OBSERVER", "solar_irradiance_at_sensor", Kind::irradiance},
    {"SOL_TR", "solar_irradiance_transmitted", Kind::irradiance},
    {"SOLAR", "solar_irradiance", Kind::irradiance},
    {"TOA_SUN", "solar_irradiance", Kind::irradiance},
    {"TOA_RAD", "solar_irradiance", Kind::irradiance},
    {"TOP_OF_ATMOSPHERE_IRRADIANCE", "solar_irradiance", Kind::irradiance},
    {"DEPTH", "optical_depth", Kind::ratio},
    {"LOG_COMBIN", "optical_depth", Kind::ratio},
    {"NAT_LOG_PATH_TRANS", "optical_depth", Kind::ratio},
    {"DIR_EM", "surface_emissivity", Kind::ratio},
    {"DIRECTIONAL_EMISSIVITY", "surface_emissivity", Kind::ratio},
    {"BBODY_T_K", "brightness_temperature", Kind::temperature},
    {"BBODY_TK", "brightness_temperature", Kind::temperature},
    {"BRIGHTNESS_TEMP", "brightness_temperature", Kind::temperature},
    {"CONT_N2", "transmittance_n2_continuum", Kind::ratio},
    {"N2_CONT", "transmittance_n2_continuum", Kind::ratio},
    {"N2_TRANS", "transmittance_n2_continuum", Kind::ratio},
    {"CONT_H2O", "transmittance_h2o_continuum", Kind::ratio},
    {"H2O_CONT", "transmittance_h2o_continuum", Kind::ratio},
    {"H2OCNT_TRANS", "transmittance_h2o_continuum", Kind::ratio},
    {"MOLEC_SCAT", "transmittance_molecular_scattering", Kind::ratio},
    {"AER_CLD_TRANS", "transmittance_aerosol_cloud", Kind::ratio},
    {"TRANS_AERCLD", "transmittance_aerosol_cloud", Kind::ratio},
    {"AERCLD_TRANS", "transmittance_aerosol_cloud", Kind::ratio},
    {"AER_CLD_ABTRNS", "transmittance_aerosol_cloud_absorption", Kind::ratio},
    {"ABTRNS_AERCLD", "transmittance_aerosol_cloud_absorption", Kind::ratio},
    {"AERCLD_ABTRNS", "transmittance_aerosol_cloud_absorption", Kind::ratio},
};

std::string seven_digits(double value) {
  std::ostringstream out;
  out.precision(7);
  out << value;
  return out.str();
}

struct Sum {
  double value = 0, allowed = 0;
  void add(const Column* column, std::size_t row) {
    if (column) value += column->values[row], allowed += column->rounding[row];
  }
};

}  // namespace

std::string label_key(std::string_view label) {
  std::string out;
  for (const char c : label) {
    if (std::isalnum(static_cast<unsigned char>(c)))
      out += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out;
}

std::optional<Quantity> modtran_quantity(std::string_view label, std::string_view second) {
  std::string key = label_key(label);
  if (!second.empty()) key += "_" + label_key(second);
  for (const NamedRow& row : kRows)
    if (key == row.key) return Quantity{row.name, row.kind};
  // Every further gas: "CO2" over "TRANS" (tape7), "TRANS_CO2" (JSON), "CO2 trans" (CSV).
  constexpr std::string_view word = "TRANS";
  if (key.rfind("TRANS_", 0) == 0) return Quantity{"transmittance_" + base::lower_case(key.substr(6)), Kind::ratio};
  if (key.size() > word.size() + 1 && key.compare(key.size() - word.size() - 1, std::string::npos, "_TRANS") == 0)
    return Quantity{"transmittance_" + base::lower_case(key.substr(0, key.size() - word.size() - 1)), Kind::ratio};
  return std::nullopt;
}

Column modtran_column(const Quantity& quantity, std::string_view source) {
  Column column;
  column.name = quantity.name;
  column.source = std::string(source);
  column.unit = quantity.kind == Kind::radiance      ? "W m-2 sr-1 um-1"
                : quantity.kind == Kind::irradiance  ? "W m-2 um-1"
                : quantity.kind == Kind::temperature ? "K"
                                                     : "1";
  return column;
}

void append_modtran(Column& column, Kind kind, const Number& number, AxisUnit unit, double wavelength_um) {
  const bool density = kind == Kind::radiance || kind == Kind::irradiance;
  const auto converted = [&](double x) {
    return density ? W_per_m2_um_from_W_per_cm2_axis(x, unit, wavelength_um) : x;
  };
  column.values.push_back(converted(number.value));
  column.rounding.push_back(converted(number.rounding));
}

void settle_radiance(Run& run, const base::Where& where, const std::vector<int>& lines, base::Problems& problems) {
  const Column *thermal = run.find("path_radiance_thermal"), *emitted = run.find("path_radiance_thermal_emitted"),
               *scattered = run.find("path_radiance_thermal_scattered"), *solar = run.find("path_radiance_solar"),
               *single = run.find("path_radiance_solar_single"), *multiple = run.find("path_radiance_solar_multiple"),
               *total = run.find("radiance"), *surface = run.find("surface_emission"),
               *ground = run.find("ground_reflected");
  const std::size_t rows = run.wavelength_um.size();
  Column path_thermal, path_solar;
  if (!thermal && emitted) path_thermal = *emitted, path_thermal.name = "path_radiance_thermal";
  if (!solar && multiple && single) {
    path_solar = *multiple, path_solar.name = "path_radiance_solar", path_solar.source += " + " + single->source;
    for (std::size_t i = 0; i < rows; ++i)
      path_solar.values[i] += single->values[i], path_solar.rounding[i] += single->rounding[i];
  }
  const Column* sun = solar ? solar : path_solar.name.empty() ? nullptr : &path_solar;
  const Column* heat = thermal ? thermal : emitted ? &path_thermal : nullptr;
  const auto worst_row = [&](bool add_scattered) -> std::size_t {
    for (std::size_t i = 0; i < rows && total; ++i) {
      Sum sum;
      for (const Column* part : {heat, sun, surface, ground}) sum.add(part, i);
      if (add_scattered) sum.add(scattered, i);
      // MODTRAN adds in single precision: a few 6e-8 of the total beyond the printed digits.
      if (!(std::abs(sum.value - total->values[i]) <= sum.allowed + total->rounding[i] + 3e-7 * total->values[i]))
        return i;
    }
    return rows;
  };
  // Thermal scatter stands apart only where the file names emission alone (THRML_EM); PTH_THRML holds it.
  const bool may_stand_apart = !thermal && emitted && scattered;
  bool apart = may_stand_apart;
  std::size_t row = worst_row(apart);
  if (row < rows && may_stand_apart) {
    const std::size_t other = worst_row(false);
    if (other == rows) apart = false, row = rows;
  }
  if (row < rows) {
    base::Where here = where;
    if (!lines.empty())
      here.line = lines[row];
    else
      here.element = total->source + "[" + std::to_string(row) + "]";
    Sum sum;
    for (const Column* part : {heat, sun, surface, ground}) sum.add(part, row);
    if (apart) sum.add(scattered, row);
    problems.add(here, "the parts of " + total->source + " do not add up to it within the printed digits",
                 seven_digits(sum.value) + " against " + seven_digits(total->values[row]) + " W m-2 sr-1 um-1",
                 "columns have moved or a row is damaged");
  }
  if (apart)
    for (std::size_t i = 0; i < rows; ++i)
      path_thermal.values[i] += scattered->values[i], path_thermal.rounding[i] += scattered->rounding[i];
  if (apart) path_thermal.source += " + " + scattered->source;
  if (!path_thermal.name.empty()) run.columns.push_back(std::move(path_thermal));
  if (!path_solar.name.empty()) run.columns.push_back(std::move(path_solar));
}

}  // namespace raycube::atmos::imported
