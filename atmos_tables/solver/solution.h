// The plane-parallel multiple-scattering solver: scalar radiative transfer by discrete ordinates (Stamnes,
// Tsay, Wiscombe & Jayaweera 1988, Appl. Opt. 27, 2502; atmosphere specification S4.6-S4.9). One solve serves
// every depth, direction and Lambertian ground.
//
// Conventions. Directions are those in which the light travels: cosine > 0 up (a sensor that looks down), < 0
// down (one that looks up); azimuth in degrees, in the same sense as Beam::azimuth_deg, equal to it on the
// forward-scattering side. Depth is the vertical extinction optical depth from the top, unscaled.
// Polarisation is left out: 1 to 11 % for Rayleigh light (AIR 0, fact 8).
#pragma once

#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "atmos_tables/solver/column.h"

namespace raycube::atmos::solver {

/// Irradiances on a horizontal plane, unit of Beam::flux. Direct is the beam unscattered by the true
/// (unscaled) column.
struct Fluxes {
  double direct_down = 0, diffuse_down = 0, up = 0;
  double net_down() const { return direct_down + diffuse_down - up; }
};

/// How a Lambertian ground of albedo rho couples to the air (S4.9): its upward radiance is
/// [rho (direct + diffuse) / pi + (1 - rho) B] / (1 - rho spherical_albedo).
struct GroundCoupling {
  double direct_irradiance = 0, diffuse_irradiance = 0;  ///< on a black ground
  double spherical_albedo = 0;                           ///< of the air from below, [0, 1]
};

/// Radiance at a place per unit isotropic radiance of the whole ground.
struct GroundTransmission {
  double direct = 0;   ///< exp(-depth / cosine) upward, 0 downward; of the true column
  double diffuse = 0;  ///< the rest. Upward T_dif; downward the t of the sky term, S = 2 int t mu dmu at the ground
};

/// A solved column. Cheap to copy; safe to read from many threads.
class ColumnSolution {
 public:
  double total_depth() const;
  /// Depth of level 0 ... layers; throws base::Error(Fault::input) for another index.
  double level_depth(std::size_t level) const;

  /// Depths must lie in [0, total_depth] (to 1e-9 relative), else base::Error(Fault::input); the same below.
  Fluxes fluxes(double depth, const Ground& ground) const;

  /// Diffuse radiance (the beam itself not in it), W m-2 sr-1 per unit of the beam's spectral interval, for
  /// each azimuth. |cosine| in [0, 1]; below 1e-9 it counts as 1e-9.
  std::vector<double> radiances(double depth, double cosine, const std::vector<double>& azimuth_deg,
                                const Ground& ground) const;
  double radiance(double depth, double cosine, double azimuth_deg, const Ground& ground) const;
  /// Many places and directions in one sweep through the layers, [depth][cosine][azimuth]: what depends on
  /// the layer, the direction or the azimuth order alone is found once. Same values as one by one, whatever
  /// is asked for together.
  std::vector<double> radiances(const std::vector<double>& depths, const std::vector<double>& cosines,
                                const std::vector<double>& azimuth_deg, const Ground& ground) const;

  /// Path radiance: the same over a black ground that emits nothing.
  double path_radiance(double depth, double cosine, double azimuth_deg) const;

  GroundCoupling ground_coupling() const;
  GroundTransmission ground_transmission(double depth, double cosine) const;
  /// [depth][cosine]
  std::vector<GroundTransmission> ground_transmissions(const std::vector<double>& depths,
                                                       const std::vector<double>& cosines) const;

  /// Number of azimuth terms kept.
  int azimuth_terms() const;

  struct Data;
  explicit ColumnSolution(std::shared_ptr<const Data> data) : data_(std::move(data)) {}

 private:
  std::shared_ptr<const Data> data_;
};

/// Throws base::Error(Fault::input) for a column or options outside their ranges (check_column); every column
/// inside them is solved: conservative, empty, without depth, of any depth, with the beam at a node or at an
/// eigenvalue.
ColumnSolution solve_column(const Column& column, const Options& options = {});

}  // namespace raycube::atmos::solver
