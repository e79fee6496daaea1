// A user's profile from a CSV file.
//
// Lines that start with # and empty lines are skipped; the first other line names the columns, units in the
// names:
//   height_km | height_m, pressure_hPa | pressure_Pa, temperature_K | temperature_C    (needed)
//   air_per_cm3                                    (else pressure / (k temperature))
//   GAS_ppmv | GAS_per_cm3, h2o_g_per_m3, h2o_relative_humidity_percent                (GAS: h2o co2 o3 n2o
//   co ch4 o2)
// Levels ascend or descend in height. Relative humidity is over water; where pressure is above 100 hPa air
// that holds more water than 105 % of saturation is refused, whatever the column's unit; relative humidity
// above 100 % (a sonde's error) is held there.
#pragma once

#include <array>
#include <istream>
#include <string>
#include <vector>

#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

struct ProfileFile {
  AirProfile air;                    ///< a gas without a column is 0
  std::array<bool, kGases> given{};  ///< has a column
  std::vector<std::string> notices;
};

/// Throws Error(environment) when the file cannot be read, Error(input) that lists every fault with file:line
/// otherwise.
ProfileFile read_profile_csv(const std::string& file);
/// The same from a stream; name stands for the file in messages.
ProfileFile read_profile_csv(std::istream& in, const std::string& name);

}  // namespace raycube::atmos
