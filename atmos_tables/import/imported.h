// What an importer hands over, whatever the format: named columns over wavelength in the project's units and
// conventions. Sources: docs/conventions.md for angles; each reader's header names its format. Units are converted by
// conversions.h alone.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::atmos::imported {

/// Where in the air, and towards where, a column was computed. What is empty does not apply, or the file does not say.
struct Place {
  std::optional<double> height_m;  ///< of the level, above the ground or sea as the run says
  bool top_of_air = false;         ///< the level is the top of the atmosphere, whose height the file does not name
  std::optional<double>
      zenith_deg;  ///< towards the sensor (light going up) or the sky point (light coming down), 0..90
  std::optional<double> relative_azimuth_deg;  ///< of that direction minus that of the sun, folded to 0..180
  std::optional<int> k;                        ///< index of the k-term, from 1
};

/// One quantity along the run's wavelengths.
struct Column {
  std::string name;    ///< the project's: "transmittance", "path_radiance_solar"
  std::string unit;    ///< "1", "W m-2 sr-1 um-1", "W m-2 um-1", "W m-2", "K", "um"
  std::string source;  ///< the file's own name of it
  Place place;
  std::vector<double> values;
  std::vector<double> rounding;  ///< half a unit of the last printed digit, in `unit`; 0 where the file holds binary
};

/// Angles in degrees, heights and ranges in metres; empty where the file does not say.
struct Geometry {
  std::optional<double> sensor_height_m, path_end_height_m, path_length_m;
  std::optional<double> sight_zenith_deg;  ///< of the line of sight, at the sensor; 180 = straight down
  std::optional<double>
      view_zenith_deg;  ///< at the path's lower end, towards the sensor; sights below the horizon only
  /// At the sensor; where a listing or an input tells of a path down, at its end, whose light is computed.
  std::optional<double> sun_zenith_deg;
  /// Of the sensor seen from the target (sight below the horizon) or of the sky point, minus that of the sun, folded to
  /// 0..180.
  std::optional<double> relative_azimuth_deg;
  std::optional<double> sun_azimuth_deg;   ///< at the same place, clockwise from north, 0..360
  std::optional<double> ground_height_m;   ///< where the air ends below, counted as the other heights are
  std::optional<int> day_of_year;          ///< 1..366
  std::optional<double> earth_sun_factor;  ///< (mean distance / distance)^2, which the sun above the air holds
  std::optional<double> ground_albedo;     ///< Lambertian, the same at all wavelengths
};

/// One computation. Every column has one value per wavelength.
struct Run {
  std::string mode;  ///< "transmittance", "radiance", "direct irradiance", "channels", "fluxes", ...
  /// Vacuum, strictly ascending; channels stand in the order of their filter file. None where a file says what was
  /// asked for and not what came of it: a .tp6, an input.
  std::vector<double> wavelength_um;
  std::vector<Column> columns;
  Geometry geometry;
  std::vector<std::string> notes;  ///< what a user should know: columns left out, bands cut short
  /// The column of that name (the first, where several places share it), or null.
  const Column* find(const std::string& name) const;
  /// As find(), but an absent column is an Error that names it.
  const Column& at(const std::string& name) const;
};

struct Imported {
  std::string file, code, format;
  std::vector<Run> runs;
};

/// Checks what every format owes: finite values, none below 0, transmittances and albedos not above 1 by more than
/// their printed digits and `slack`, columns of one length, no two columns of one name and place. Adds to `problems`.
void check_run(const Run& run, const base::Where& where, base::Problems& problems, double slack = 1e-6);

/// Turns a run whose wavelengths descend (a wavenumber axis) so that they ascend.
void sort_ascending(Run& run);

}  // namespace raycube::atmos::imported
