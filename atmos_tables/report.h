// What a render table says to people and to programs: `raycube atmos info`, and the figures behind `raycube atmos
// plot`.
#pragma once

#include <string>

#include "atmos_tables/render_table.h"

namespace raycube::atmos {

/// Header, axes, rows with their ranges, rows of the format that are absent, provenance.
std::string table_text(const RenderTable& table, const std::string& content_hash);
/// The same as one JSON document.
std::string table_json(const RenderTable& table, const std::string& content_hash);

struct PlotChoice {
  double target_height_m = 0;
  double view_zenith_deg = 0;
  double relative_azimuth_deg = 90;  ///< of the sensor, for the slanted path
  double sky_wavelength_um = 0.55;   ///< of the sky map; the nearest of the table is taken
};
/// Spectra and a sky map read through the table's interpolation, as JSON for plots/atmos_plot.py. Absent rows are left
/// out. Throws Error(input) when the choice lies outside the table.
std::string plot_json(const RenderTable& table, const PlotChoice& choice, const std::string& title);

}  // namespace raycube::atmos
