// Unoccluded irradiance of the sky's maps on a plane of any tilt and azimuth.
#pragma once

#include <array>
#include <vector>

#include "host/plan/plan.h"

namespace raycube::plan {

/// Integrals I_m(n) = integral over the upper hemisphere of A_m(w) max(0, n.w) dOmega for maps that are linear between
/// nodes. In azimuth the integral is closed (piecewise linear times cosine); in zenith Gauss-Legendre per node
/// interval, split where the plane of the surface begins to cut the ring.
class SkyIrradiance {
 public:
  explicit SkyIrradiance(const SkyBasis& basis);

  /// tilt of the normal from the zenith (0..pi); azimuth of the normal relative to the sun. points: Gauss points per
  /// interval.
  std::array<double, 4> at(double tilt_rad, double azimuth_rad, int points = 4) const;

 private:
  /// A(phi) = a0 + a1 (phi - phi_j) in one cell of one ring, and the constants of its integrals from azimuth 0.
  struct Piece {
    std::array<double, 4> a0, a1, one, cosine, sine;
  };
  struct Moments {
    std::array<double, 4> one{}, cosine{}, sine{};
  };
  Moments moments_to(std::size_t ring, double fraction, double phi) const;

  std::vector<double> zenith_, azimuth_;
  std::vector<Piece> piece_;                                       ///< [ring][cell]
  std::vector<std::array<double, 4>> circle_one_, circle_cosine_;  ///< whole rings
};

/// Exact on a grid over tilt and azimuth, where the irradiance is smooth, and cubic between.
class IrradianceGrid {
 public:
  IrradianceGrid(const SkyIrradiance& exact, double sun_azimuth_rad);
  /// Normal x east, y north, z up; any length.
  std::array<double, 4> at(double x, double y, double z) const;

 private:
  double sun_azimuth_;
  std::vector<std::array<double, 4>> value_;
};

/// Map of odd `size`.
IrradianceMap make_irradiance_map(const IrradianceGrid& grid, int size);

/// What a map of this size would read at a normal, as the kernels read it (rc_octahedral_nodes).
std::array<double, 4> read_between_nodes(const IrradianceGrid& grid, int size, double x, double y, double z);

/// The map between its nodes.
std::array<double, 4> read_map(const IrradianceMap& map, double x, double y, double z);

/// Sizes the planner tries, ascending.
inline constexpr std::array<int, 4> kMapSizes = {129, 257, 513, 1025};

}  // namespace raycube::plan
