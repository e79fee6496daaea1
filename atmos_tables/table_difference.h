// Two render tables side by side: what each says of one place and direction, and the difference per band.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "atmos_tables/render_table.h"

namespace raycube::atmos {

/// Where two spectra are weighed against each other: a box, or a Gaussian response. Lengths um.
struct DifferenceBand {
  double low_um = 0, high_um = 0;  ///< the box; of a Gaussian centre -+ 2.5 FWHM, where the response has fallen to 3e-8
  double center_um = 0, fwhm_um = 0;  ///< fwhm_um 0: a box
};

/// The atmosphere's windows and the bands between them, 0.3 to 30 um: 0.58-3.96 um as in ATMOSPHERE S3.2, 8-13 um as in
/// S3.1.
std::vector<DifferenceBand> atmospheric_windows();
/// Boxes of one width from first to last; the last one may be narrower. width > 0.
std::vector<DifferenceBand> even_bands(double first_um, double last_um, double width_um);
DifferenceBand gaussian_band(double center_um, double fwhm_um);

/// Where to read; a value outside what both tables cover is moved to the nearest that both do.
struct DifferenceChoice {
  std::optional<double> height_m;  ///< empty: the lowest that both have
  double view_zenith_deg = 45;     ///< of the slant path; the nadir path is always read
  double sky_zenith_deg = 60;      ///< of the slant sky; the zenith is always read
  double relative_azimuth_deg = 90;
  std::vector<DifferenceBand> bands = atmospheric_windows();
};

/// B - A in one band. The weight of a wavelength is the response times the step between the grid points around it.
struct BandDifference {
  DifferenceBand band;  ///< clipped to the common range
  double mean_a = 0, mean_b = 0;
  double mean = 0, rms = 0;
  double worst = 0, worst_um = 0;  ///< the largest, with its sign, where the response is at least half its peak
  /// The three over |mean of A|; empty for ratios (transmissions, albedos) and where A's mean is 0.
  std::optional<double> mean_relative, rms_relative, worst_relative;
};

struct QuantityDifference {
  std::string name;   ///< the row's: "path_radiance_solar"
  std::string where;  ///< "nadir", "view zenith 45 deg, azimuth 90 deg"; empty when it has no direction
  std::string unit;
  bool ratio = false;
  std::vector<double> a,
      b;  ///< NaN: left out (two_way_factor where T_sun T_view is below 0.001); on Comparison::wavelength_um
  std::vector<BandDifference> bands;
};

struct TableDifference {
  std::vector<std::string> differs;         ///< sun, sensor, axes: each a sentence
  std::vector<std::string> only_a, only_b;  ///< rows
  double height_m = 0;
  double first_um = 0, last_um = 0;   ///< common range
  std::vector<double> wavelength_um;  ///< both tables' nodes within it; between nodes spectra are linear
  std::vector<QuantityDifference> quantities;
};

/// Throws Error(input) when the tables have no wavelength, no height or no quantity in common, or no band lies in their
/// range.
TableDifference table_difference(const RenderTable& a, const RenderTable& b, const DifferenceChoice& choice = {});

struct TableNames {
  std::string a, b;
};
std::string difference_text(const TableDifference& difference, const TableNames& names);
/// One JSON document; `spectra`: with the spectra a chart needs.
std::string difference_json(const TableDifference& difference, const TableNames& names, bool spectra);

}  // namespace raycube::atmos
