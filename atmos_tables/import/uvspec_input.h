// libRadtran's uvspec input file (.inp), as far as it decides the layout and units of the output.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/import/imported.h"

namespace raycube::atmos::imported {

enum class UvspecDensity { mW_per_nm, W_per_nm, W_per_cm, integrated_mW, integrated_W };
enum class UvspecQuantity { radiometric, transmittance, reflectivity, brightness };

struct UvspecInput {
  std::string file;
  bool two_stream = false;
  std::vector<double> umu, phi_deg;
  std::vector<Place> levels;  ///< zout: height above the ground, or the top of the air
  double phi0_deg = 0;
  std::optional<double> sun_zenith_deg, albedo;
  double first_nm = 0, last_nm = 0;      ///< 0, 0: not said
  std::vector<std::string> output_user;  ///< empty: the solver's own layout
  UvspecQuantity quantity = UvspecQuantity::radiometric;
  UvspecDensity density = UvspecDensity::mW_per_nm;
};

/// Throws base::Error(input), as file:line, for settings that would change the layout in ways this reader does not
/// know, and where the unit of the output cannot be told (a solar file that is none of libRadtran's own, say).
UvspecInput read_uvspec_input(const std::string& path);

}  // namespace raycube::atmos::imported
