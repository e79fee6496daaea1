// A render table from what other codes computed. docs/import_formats.md says which runs are needed.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/import/imported.h"
#include "atmos_tables/render_table.h"

namespace raycube::atmos::imported {

/// What files do not say, or say otherwise.
struct TableRequest {
  std::optional<double> sun_zenith_deg, sun_azimuth_deg;
  std::optional<double> sensor_height_m;  ///< above z = 0
  std::optional<double> ground_height_m;  ///< z = 0 above the level the files count heights from
  std::vector<double>
      albedo;             ///< of the ground, per run that looks down, in the order of files; empty: as the runs say
  bool even_sky = false;  ///< where no sky was computed: diffuse irradiance / pi in every direction
  bool partial = false;   ///< keep what there is, though no render can use it
};

struct TableOfRuns {
  RenderTable table;
  std::vector<std::string> notices;  ///< assumptions made, rows left out
};

/// Throws Error(input) that lists all that is missing for a render, or the runs that contradict each other.
TableOfRuns table_of_runs(const std::vector<Imported>& files, const TableRequest& request);

}  // namespace raycube::atmos::imported
