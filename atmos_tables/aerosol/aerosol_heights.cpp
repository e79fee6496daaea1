#include "atmos_tables/aerosol/aerosol_heights.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <vector>

#include "host/base/error.h"

namespace raycube::atmos {

namespace {

#include "atmos_tables/aerosol/data/lowtran7_heights.inc"

constexpr double kVisibility_km[] = {50, 23, 10, 5, 2};  ///< of the columns of kBoundary
constexpr double kStretchTop_km = 6;

/// Linear in 1 / V through two tabulated visibilities.
double in_inverse(double visibility_km, double v0_km, double value0, double v1_km, double value1) {
  return std::lerp(value0, value1, (1 / visibility_km - 1 / v0_km) / (1 / v1_km - 1 / v0_km));
}

double boundary_extinction(const double* row, double visibility_km) {
  std::size_t j = 1;
  while (j + 1 < std::size(kVisibility_km) && visibility_km < kVisibility_km[j]) ++j;
  return std::max(0.0, in_inverse(visibility_km, kVisibility_km[j - 1], row[j], kVisibility_km[j], row[j + 1]));
}

double stretched_km(double height_km, double ground_km) {
  return height_km < kStretchTop_km ? ground_km + height_km * (kStretchTop_km - ground_km) / kStretchTop_km : height_km;
}

}  // namespace

double max_visibility_km() {
  const double* at_2km = kBoundary[2];
  const double slope = (at_2km[2] - at_2km[1]) / (1 / kVisibility_km[1] - 1 / kVisibility_km[0]);
  return 1 / (1 / kVisibility_km[0] - at_2km[1] / slope);
}

double koschmieder_extinction_per_km(double visibility_km) { return 3.912 / visibility_km - 0.01159; }

AerosolHeights aerosol_heights(double visibility_km, bool spring_summer, StratosphereModel stratosphere,
                               double ground_km) {
  const auto at = [&](double height_km, double extinction) {
    return HeightProfile::Knot{stretched_km(height_km, ground_km), extinction};
  };
  std::vector<HeightProfile::Knot> boundary, troposphere{at(2, 0)}, strato{at(10, 0)}, upper{at(30, 0)};
  for (const auto& row : kBoundary) boundary.push_back(at(row[0], boundary_extinction(row, visibility_km)));
  boundary.push_back(at(3, 0));
  const std::size_t season = spring_summer ? 0 : 1, kind = static_cast<std::size_t>(stratosphere);
  for (const auto& row : kTroposphere) {
    const double clear = row[1 + 2 * season], hazy = row[2 + 2 * season];
    troposphere.push_back(
        at(row[0], visibility_km <= 23 ? hazy : std::max(0.0, in_inverse(visibility_km, 50, clear, 23, hazy))));
  }
  troposphere.push_back(at(11, 0));
  for (const auto& row : kStratosphere) strato.push_back(at(row[0], row[1 + 4 * season + kind]));
  strato.push_back(at(35, 0));
  for (const auto& row : kUpper)
    upper.push_back(at(row[0], row[stratosphere == StratosphereModel::background ? 1 : 2]));
  return {HeightProfile(boundary), HeightProfile(troposphere), HeightProfile(strato), HeightProfile(upper)};
}

double total_depth(const AerosolHeights& heights) {
  double out = 0;
  for (const HeightProfile& region : heights) out += region.total_depth();
  return out;
}

double visibility_for_depth_km(double depth_550, bool spring_summer, StratosphereModel stratosphere, double ground_km) {
  const auto depth = [&](double inverse) {
    return total_depth(aerosol_heights(1 / inverse, spring_summer, stratosphere, ground_km));
  };
  double low = 1 / max_visibility_km(), high = 1 / kMinVisibility_km;
  if (depth_550 <= depth(low)) return max_visibility_km();
  if (depth_550 > depth(high))
    throw base::Error(base::Fault::input, "aerosol optical depth at 0.55 um: at most " + std::to_string(depth(high)) +
                                              " (visibility 0.02 km; found " + std::to_string(depth_550) +
                                              "); give a cloud or fog layer its own optical depth instead");
  // The depth grows with 1 / V. Halving the bracket until it no longer shrinks.
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    (depth(middle) < depth_550 ? low : high) = middle;
  }
  return 2 / (low + high);
}

}  // namespace raycube::atmos
