// What each imported run says of a render table's rows: spectra at places, on one wavelength axis.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/import/imported.h"
#include "atmos_tables/import/table_of_runs.h"

namespace raycube::atmos::imported {

using Spectrum = std::vector<double>;

/// A row's spectrum at one place; a coordinate that is empty does not matter or was not said.
struct Sample {
  std::string row;  ///< of the registry, or one of the helpers below
  std::optional<double> height_m, zenith_deg, azimuth_deg;
  Spectrum values;
};
/// Not rows themselves: T(sun to target to sensor), and all light on a horizontal plane over black ground.
inline constexpr const char *kTwoWay = "two_way_transmission", *kTotalIrradiance = "total_irradiance",
                            *kSunGroundDiffuse = "sun_ground_transmittance_diffuse",
                            *kIrradianceCosOverPi = "solar_irradiance_cos_over_pi";

struct Samples {
  Spectrum wavelength_um;
  std::vector<Sample> all;
  std::optional<double> sun_zenith_deg, sun_azimuth_deg, sensor_height_m, earth_sun_factor;
  std::optional<int> day_of_year;
  std::vector<std::string> notices;
};

/// Wavelengths are those of the first run that looks down from the sensor (else of the first run), within the range all
/// runs cover; other runs are linear between their nodes. Throws Error(input) on contradictions.
Samples samples_of(const std::vector<Imported>& files, const TableRequest& request);

}  // namespace raycube::atmos::imported
