// The rows of a layered table: geometry common to all wavelengths, and the filling of one wavelength.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "atmos_tables/compiler/spectral_air.h"
#include "atmos_tables/compiler/thermal_paths.h"
#include "atmos_tables/render_table.h"

namespace raycube::atmos {

/// Levels and paths of a table's nodes.
struct BinGeometry {
  /// view_zenith_deg: a user's; empty: the model's own.
  BinGeometry(const AirStack& stack, const scene::Sun& sun, double z0_km, double sensor_height_m,
              const std::vector<double>& target_height_m, const std::vector<double>& view_zenith_deg = {});

  const AirStack* stack;
  double sun_zenith_deg, sun_azimuth_deg;
  bool day;
  std::size_t sensor_level;
  std::vector<std::size_t> level;  ///< [height]
  /// Spaced so that light between nodes is right to 2 % (A-19): 5 degrees around the glory, 10 where Mie functions are
  /// steep.
  std::vector<double> view_zenith, view_azimuth, sky_zenith, sky_azimuth, scattering_angle;
  std::vector<std::vector<double>> sun_path;   ///< [height] path factors
  std::vector<std::vector<double>> view_path;  ///< [height * views + view]
  std::vector<std::vector<double>> sky_path;   ///< [height * sky zeniths + zenith]
};

class BinRows {
 public:
  /// Adds axes and rows to the table, which must outlive this.
  BinRows(RenderTable& table, const BinGeometry& geometry, bool thermal,
          LayerEmission emission = LayerEmission::graded);
  /// Fills everything at wavelength i. Different wavelengths may be filled from different threads.
  void fill(std::size_t i, const SpectralAir& air, int streams) const;

 private:
  void fill_paths(std::size_t i, const SpectralAir& air) const;
  void fill_scattering(std::size_t i, const SpectralAir& air, int streams) const;
  void fill_thermal(std::size_t i, const SpectralAir& air, int streams) const;
  /// Values of a row at wavelength i.
  std::span<float> row(const char* name, std::size_t i) const;

  RenderTable& table_;
  const BinGeometry& geometry_;
  bool thermal_;
  LayerEmission emission_;
};

}  // namespace raycube::atmos
