// libRadtran's uvspec input file (.inp), as far as it decides the layout and units of the output. What it does not say
// is what uvspec takes: source solar, sza 0, phi0 0, disort, REPTRAN's gases, the surface as only level. Settings of
// the air and the surface are not looked at. A setting given twice holds as it stands last, also across included files.
// Source: libRadtran's user's guide and the documentation of its options (src_py), versions 2.0.2 to 2.0.4.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

/// What a number of the output counts, and over what it is a density.
enum class UvspecPower { mW, W, photons };   ///< photons: s-1 cm-2 instead of W m-2
enum class UvspecPer { nm, cm, band, all };  ///< all: summed or integrated over the run's range
struct UvspecUnit {
  UvspecPower power = UvspecPower::mW;
  UvspecPer per = UvspecPer::nm;
};
enum class UvspecQuantity { radiometric, transmittance, reflectivity, brightness };

struct UvspecInput {
  std::string file;
  bool two_stream = false, thermal = false;
  std::vector<double> umu, phi_deg;
  std::vector<Place> levels;  ///< zout: height above the ground, zout_sea: above the sea, or the top of the air
  double phi0_deg = 0;
  std::optional<double> sun_zenith_deg;  ///< by sunlight; empty where uvspec finds it by place and time
  std::optional<double> albedo, ground_height_m;
  std::optional<int> day_of_year;
  double first_nm = 0, last_nm = 0;      ///< 0, 0: not said
  std::vector<double> axis_nm;           ///< of `spline` or `spline_file`: the wavelengths of the output; empty: others
  std::vector<std::string> output_user;  ///< empty: the solver's own layout
  UvspecQuantity quantity = UvspecQuantity::radiometric;
  UvspecUnit unit;
  bool sun_of_reptran = false;     ///< no solar file: mW or W must be told by the size of the numbers
  std::vector<std::string> notes;  ///< what the numbers are: convolved, filtered
};

/// Throws base::Error(input), as file:line, for settings that would change the layout in ways this reader does not
/// know, for included files that are not there, and where the unit of the output cannot be told (a solar file that is
/// none of libRadtran's own, say); each names the way out. Included and spline files are looked for where they are
/// named, counted from the folder of the file that names them, and beside that file.
UvspecInput read_uvspec_input(const std::string& path);

}  // namespace raycube::atmos::imported
