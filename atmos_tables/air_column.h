// The air of the built-in clear sky in layers: how much of each constituent a layer holds, and how long a slanted path
// is in it. Heights in metres above the scene's z = 0. Profiles (fractions of the column above z = 0):
//   air        exp(-h / 8 km)
//   water      exp(-h / 2 km)
//   aerosol    exp(-h / 2 km); within 0.02 of MLS-rural's share below 0.61 and 3 km (LOWTRAN7)
//   ozone      (1 + exp(-20/5)) / (1 + exp((h - 20) / 5)), h in km above the sea (Lacis & Hansen 1974, eq. 17)
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::atmos {

inline constexpr double kTopOfAir_m = 100000;
inline constexpr double kAirScaleHeight_m = 8000;
inline constexpr double kWaterScaleHeight_m = 2000;
inline constexpr double kAerosolScaleHeight_m = 2000;
inline constexpr double kEarthRadius_m = 6371230;

/// Shares of the four columns along some path: 1 each for the vertical column above z = 0.
struct ColumnShare {
  double air = 0, aerosol = 0, water = 0, ozone = 0;
  ColumnShare& operator+=(const ColumnShare& o) {
    air += o.air, aerosol += o.aerosol, water += o.water, ozone += o.ozone;
    return *this;
  }
  friend ColumnShare operator+(ColumnShare a, const ColumnShare& b) { return a += b; }
  friend ColumnShare operator*(double s, ColumnShare a) { return {s * a.air, s * a.aerosol, s * a.water, s * a.ozone}; }
};

/// Layers between ascending levels; the last layer holds all that is left above it.
class AirColumn {
 public:
  /// Levels: heights_m and a fixed set up to the top of the air, united. ground_height_m: of z = 0 above the sea.
  AirColumn(std::vector<double> heights_m, double ground_height_m);

  const std::vector<double>& levels() const { return levels_; }
  std::size_t layers() const { return shares_.size(); }
  /// Vertical shares of layer i, between levels i and i + 1.
  const ColumnShare& share(std::size_t layer) const { return shares_[layer]; }
  /// Index of the level at a height the column was made with (the top level for heights above the air).
  std::size_t level_of(double height_m) const;
  /// Path length per layer thickness of a straight line that leaves level `from` upward at this zenith angle, for each
  /// layer above it (0 below): exact chords through spherical shells, no refraction.
  std::vector<double> slant(std::size_t from, double zenith_deg) const;

 private:
  std::vector<double> levels_;
  std::vector<ColumnShare> shares_;
};

}  // namespace raycube::atmos
