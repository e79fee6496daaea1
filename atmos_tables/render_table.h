// The one table format between atmosphere and renderer: self-describing rows over named axes. A row that is absent is
// absent by name; a reader that needs it says so. Wavelengths vacuum, um; heights km are not used here: metres above
// the scene's z = 0. Radiance W m-2 sr-1 um-1, irradiance W m-2 um-1. Azimuths relative to the sun, 0..180, 0 = sun's
// side.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace raycube::atmos {

/// An axis: strictly ascending node values.
struct Axis {
  std::string
      /// wavelength | target_height | view_zenith | relative_azimuth | sky_zenith | sky_azimuth | range_height | k
      name;
  std::string unit;
  std::vector<double> nodes;
};

/// A row of the table: dense array, last axis fastest, over the named axes (wavelength first in every spectral row).
struct Row {
  std::string name;
  std::string unit;
  std::string text;  ///< what it is, and its source
  std::vector<std::string> axes;
  std::vector<float> values;
};

/// Everything rendering needs for one sun position and one sensor height H.
/// Row names (docs/table_format.md has the whole list, S5.1 of the atmosphere specification):
///   solar_irradiance            (wavelength)                                 E0 after the earth-sun factor
///   sun_transmission            (wavelength, target_height)                  top of air to target, along the sun path
///   view_transmission           (wavelength, target_height, view_zenith)     target to sensor
///   two_way_factor              (wavelength, target_height, view_zenith)     T(sun-target-sensor) / (T_sun T_view)
///   path_radiance_solar         (wavelength, target_height, view_zenith, relative_azimuth)  upward, black ground
///   sky_radiance_solar          (wavelength, target_height, sky_zenith, sky_azimuth)        diffuse, disc excluded
///   sky_phase_mean, sky_scattering_depth: column-mean phase function and depth whose single-scatter shape divides the
///   sky
///                               between nodes (S5.2); without them the sky is interpolated as it stands
///   diffuse_irradiance          (wavelength, target_height)                  on a horizontal plane
///   direct_irradiance           (wavelength, target_height)                  on a horizontal plane
///   path_radiance_thermal       (wavelength, target_height, view_zenith)     emitted by the path from target to sensor
///   sky_radiance_thermal        (wavelength, target_height, sky_zenith)      emitted by the sky
///   two_way_factor_thermal      (wavelength, target_height, view_zenith)     of reflected thermal sky; absent = 1
///   spherical_albedo, diffuse_view_transmission, diffuse_return,
///   lidar_extinction, lidar_backscatter ...                                 absent until a later model fills them
struct RenderTable {
  int version = 1;
  std::string solar_source;       ///< name of the solar spectrum's file or paper
  std::string medium = "vacuum";  ///< of the wavelength axis
  std::string provenance_json;    ///< model, parameters, stated errors
  double sun_zenith_deg = 0;
  double sun_azimuth_deg = 0;  ///< clockwise from north; sky_azimuth nodes are relative to it
  double sensor_height_m = 0;  ///< H, above the scene's z = 0
  std::map<std::string, Axis> axes;
  std::map<std::string, Row> rows;

  bool has(const std::string& row) const { return rows.count(row) != 0; }
  /// The row, or Error(input) that names the row, what needs it and the model that lacks it.
  const Row& need(const std::string& row, const std::string& needed_by) const;
  const Axis& axis(const std::string& name) const;
};

}  // namespace raycube::atmos
