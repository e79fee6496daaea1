// A user's profile from a CSV file.
//
// Lines that start with # and empty lines are skipped; the first other line names the columns, units in the names:
//   height_km | height_m, pressure_hPa | pressure_Pa, temperature_K | temperature_C    (needed)
//   air_per_cm3                                    (else pressure / (k temperature))
//   GAS_ppmv | GAS_per_cm3, h2o_g_per_m3, h2o_relative_humidity_percent                (GAS: h2o co2 o3 n2o co ch4 o2)
// A gas without a column is absent from the air. Levels ascend or descend in height. Relative humidity is over water.
#pragma once

#include <istream>
#include <string>

#include "atmos_tables/optics/air_profile.h"

namespace raycube::atmos {

/// Throws Error(environment) when the file cannot be read, Error(input) that lists every fault with file:line otherwise.
AirProfile read_profile_csv(const std::string& file);
/// The same from a stream; name stands for the file in messages.
AirProfile read_profile_csv(std::istream& in, const std::string& name);

}  // namespace raycube::atmos
