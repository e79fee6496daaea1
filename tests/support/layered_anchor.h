// What the comparisons of whole layered tables with other codes share: scenes, bands, and figures for the charts in
// docs/.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/render_table.h"
#include "scene_compiler/simulation.h"
#include "tests/support/anchor_rows.h"

namespace raycube::testing {

/// Midlatitude summer, rural aerosol of 23 km, ground at 0 km, CO2 330 ppmv: the scene of most reference runs.
scene::AtmosphereSpec summer_rural_air();
/// Distance factor 1 unless a day is given.
scene::Sun sun_at(double zenith_deg, int day_of_year = 0);
/// Below the horizon by so much that no solar row is filled.
inline constexpr double kNight_deg = 120;

struct Errors {
  double mean = 0, rms = 0, worst = 0;  ///< worst: largest by amount, with its sign
  int count = 0;
  void add(double error);
  void close();  ///< sums to means
};

/// Rows written as CSV to $RAYCUBE_CHARTS/<name>.csv when that is set (docs/gallery.md), nowhere otherwise.
class ChartRows {
 public:
  ChartRows(const std::string& name, const std::string& labels);
  ~ChartRows();
  void add(const std::vector<double>& values);

 private:
  std::string file_, text_;
};

}  // namespace raycube::testing
