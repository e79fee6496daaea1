// Measured reflectance by the angles of light and viewer, from a CSV.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "scene_compiler/compiled_scene.h"

namespace raycube::scene {

/// Tables of the shape `measured` (kernels/materials/measured.h), one for each wavelength; one, and no wavelength,
/// where the file has a single column of factors.
struct MeasuredTables {
  std::vector<double> wavelength_um;  ///< ascending
  std::vector<ShapeTable> table;
};

/// Columns light_zenith_deg, view_zenith_deg (0 .. below 90), relative_azimuth_deg (0: viewer on the light's side; left
/// and right are averaged), and factors: `factor`, or several named by their wavelengths ("550nm", "1.6um"), of which
/// the eight are kept between which the others lie most nearly on lines, where these hold them to 2 %. Every
/// combination of the angles once; at a zenith angle of 0 any azimuth will do. Null after reporting every problem.
std::optional<MeasuredTables> read_measured(const std::string& file, const base::Where& asked_by,
                                            base::Problems& problems);

/// Whether numbers are a table: counts that fit, ascending angles of their ranges, factors of 0 or more.
bool is_measured_table(const std::vector<float>& numbers);

}  // namespace raycube::scene
