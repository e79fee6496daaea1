// Unoccluded irradiance of the sky's maps on a plane of any tilt and azimuth.
#pragma once

#include <array>
#include <span>
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
  /// The same, bit for bit, of planes of one tilt and many azimuths, into one quadruple each: what depends on the tilt
  /// alone is worked out once.
  void at(double tilt_rad, std::span<const double> azimuth_rad, std::span<std::array<double, 4>> out,
          int points = 4) const;

 private:
  /// A(phi) = a0 + a1 (phi - phi_j) in one cell of one ring, and the constants of its integrals from azimuth 0.
  struct Piece {
    std::array<double, 4> a0, a1, one, cosine, sine;
  };
  struct Moments {
    std::array<double, 4> one{}, cosine{}, sine{};
  };
  class Ring;
  std::size_t cells() const { return azimuth_.size() - 1; }

  std::vector<double> zenith_, azimuth_;
  std::vector<Piece> piece_;                                       ///< [ring][cell]
  std::vector<std::array<double, 4>> circle_one_, circle_cosine_;  ///< whole rings
};

/// Exact on a grid over tilt and azimuth, where the irradiance is smooth, and cubic between.
class IrradianceGrid {
 public:
  /// `tilts` (odd) from 0 to pi, half as many azimuths. On `threads` threads (0: as many as the machine has), the same
  /// on any number.
  IrradianceGrid(const SkyIrradiance& exact, double sun_azimuth_rad, std::size_t tilts, int threads = 0);
  /// Normal x east, y north, z up; any length.
  std::array<double, 4> at(double x, double y, double z) const;

 private:
  double sun_azimuth_;
  std::size_t tilts_, azimuths_;
  std::vector<std::array<double, 4>> value_;
};

/// Map of odd `size`, on any number of threads the same (0: as many as the machine has).
IrradianceMap make_irradiance_map(const IrradianceGrid& grid, int size, int threads = 0);

/// What a map of this size would read at a normal, as the kernels read it (rc_octahedral_nodes).
std::array<double, 4> read_between_nodes(const IrradianceGrid& grid, int size, double x, double y, double z);

/// The map between its nodes.
std::array<double, 4> read_map(const IrradianceMap& map, double x, double y, double z);

/// Tilts of the grids and sizes of the map that the planner tries, ascending.
inline constexpr std::array<std::size_t, 4> kGridTilts = {61, 101, 141, 201};
inline constexpr std::array<int, 4> kMapSizes = {129, 257, 513, 1025};

}  // namespace raycube::plan
