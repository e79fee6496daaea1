// MODTRAN's labels, as tape7, .7sc, JSON and CSV spell them, and the project's names of the same quantities.
// Source: headers of MODTRAN 4 and 5 tape7 files; MODTRAN 6 JSON and CSV labels as public readers name them (pymod6).
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "atmos_tables/import/conversions.h"
#include "atmos_tables/import/imported.h"
#include "atmos_tables/import/text_lines.h"

namespace raycube::atmos::imported {

enum class Kind { ratio, radiance, irradiance, temperature };

struct Quantity {
  std::string name;
  Kind kind = Kind::ratio;
};

/// Upper case, all but letters and digits as single underscores: "BBODY_T[K]" is "BBODY_T_K".
std::string label_key(std::string_view label);

/// What a label means; `second` is the label's second header line where there is one ("TRANS", "CONT", "SCAT",
/// "abTRNS"). Empty: unknown. Transmittances of further gases are read by their pattern.
std::optional<Quantity> modtran_quantity(std::string_view label, std::string_view second = {});

/// An empty column for a quantity, its unit set.
Column modtran_column(const Quantity& quantity, std::string_view source);

/// Adds one number of the file to the column, converted.
void append_modtran(Column& column, Kind kind, const Number& number, AxisUnit unit, double wavelength_um);

/// The parts of TOTAL_RAD must add up to it within the printed digits. MODTRAN 4 and 5 have the scattered thermal light
/// inside PTH_THRML and the singly scattered sunlight inside SOL_SCAT; MODTRAN 6 may list thermal emission, thermal
/// scatter, multiple and single scatter apart. Which one a file holds is decided by its columns and, where both are
/// possible, by the sum itself. Adds path_radiance_thermal and path_radiance_solar where the file has their parts only.
/// `lines`: line of each row, or empty.
void settle_radiance(Run& run, const base::Where& where, const std::vector<int>& lines, base::Problems& problems);

}  // namespace raycube::atmos::imported
