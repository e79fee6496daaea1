// In what unit uvspec writes, by what its input asks for. Sources: libRadtran's documentation of `source` and
// `output_process`; its get_unit_factor and the defaults of spectrum_unit (extraterrestrial.c, 2.0.2).
#pragma once

#include <string>

#include "atmos_tables/import/uvspec_input.h"

namespace raycube::atmos::imported {

struct UvspecAsked {
  bool thermal = false;
  std::string solar_file, file_unit;  ///< `source solar FILE UNIT`
  std::string gases;                  ///< mol_abs_param in small letters; empty: reptran
  bool thermal_bands = false;         ///< thermal_bandwidth other than 1 cm-1, or thermal_bands_file
  std::string process;                ///< output_process
  std::string filter;                 ///< filter_function_file
  bool filter_normalized = false;
  UvspecQuantity quantity = UvspecQuantity::radiometric;
};

struct UvspecTold {
  UvspecUnit unit;
  bool sun_of_reptran = false;
  std::string note;
  std::string problem, found, way_out;  ///< problem empty: the unit is known
};

/// A solar run is in the unit of its solar file, those of libRadtran being in mW m-2 nm-1 but for
/// atlas_plus_modtran_ph (photons s-1 cm-2 nm-1), and in W m-2 per band with kato and fu, whose files are their own. A
/// thermal run is in W: per cm-1 with REPTRAN, and with LOWTRAN and crs at their bandwidth of 1 cm-1, else per band.
UvspecTold uvspec_unit(const UvspecAsked& asked);

}  // namespace raycube::atmos::imported
