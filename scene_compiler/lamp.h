// Lamps that light a scene, as the file says them: what each sends, from where and which way.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace raycube::scene {

enum class LampShape { point, spot, rectangle, disc };

/// Which light a lamp sends: its spectral radiant flux over its radiant flux, 1/um, whose integral over all wavelengths
/// is 1. A table is linear between its nodes and zero outside; a black body has none.
struct LampSpectrum {
  std::vector<double> wavelength_um, per_um;
  double temperature_K = 0;  ///< of a black body; 0: a table
  bool operator==(const LampSpectrum&) const = default;

  double at(double um) const;
  /// Luminous flux over radiant flux, lm/W: 683 times the mean of the photopic efficiency V (CIE 018:2019, table 1).
  double efficacy_lm_W() const;
};

/// Intensity by direction over the largest one: linear in both angles (IES LM-63, type C).
struct LampDistribution {
  std::vector<double> vertical_deg;    ///< from the axis, ascending; none beyond the first and the last
  std::vector<double> horizontal_deg;  ///< 0 to 360, or the one 0 where it is the same all round
  std::vector<double> value;           ///< [horizontal][vertical]
  double largest_cd = 0;               ///< candelas that value 1 stands for
  bool empty() const { return value.empty(); }

  /// Its integral over all directions, sr: linear between nodes, exact in the vertical angle.
  double solid_angle_sr() const;
};

struct Lamp {
  std::string name;
  LampShape shape = LampShape::point;
  std::vector<std::array<double, 3>> position_m;  ///< scene frame; of several of its kind
  std::array<double, 3> axis{0, 0, -1};           ///< unit, which way it shines
  std::array<double, 3> across{0, 1, 0};          ///< unit, along a rectangle's width, towards C0 of a distribution
  std::array<double, 2> cone_deg{0, 0};           ///< of a spot: all of its light within, none without
  std::array<double, 2> size_m{0, 0};  ///< of a rectangle: along and across `across`; of a disc twice its width
  double flux_W = 0;                   ///< radiant flux of one of them, all wavelengths
  LampSpectrum spectrum;
  LampDistribution distribution;  ///< of a point; empty: the same everywhere
};

}  // namespace raycube::scene
