#include "atmos_tables/solver/slant_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "atmos_tables/solver/quadrature.h"
#include "host/base/error.h"
#include "host/base/units.h"

namespace raycube::atmos::solver {
namespace {

/// Value between two levels, `part` of the way from the lower to the upper.
double between_levels(double lower, double upper, double part) {
  if (lower <= 0 || upper <= 0) return lower + (upper - lower) * part;
  return lower * std::exp(part * std::log(upper / lower));
}

void check_path(const RefractingAir& air, const std::vector<double>& density, double zenith_deg) {
  base::Problems problems;
  const auto need = [&problems](bool holds, const char* rule, double found, const char* way_out) {
    if (!holds) problems.add({"", 0, 0, "slant path"}, rule, std::to_string(found), way_out);
  };
  const std::size_t levels = air.height_m.size();
  need(levels >= 2, "at least two levels are needed", static_cast<double>(levels),
       "give the heights from the top down");
  need(density.size() == levels, "one density is needed per level", static_cast<double>(density.size()),
       "match the heights");
  need(air.refractivity.empty() || air.refractivity.size() == levels, "one refractivity is needed per level, or none",
       static_cast<double>(air.refractivity.size()), "match the heights");
  need(zenith_deg >= 0 && zenith_deg <= 90, "the zenith angle must be in [0, 90] degrees", zenith_deg,
       "rays that rise");
  need(air.planet_radius_m >= 1 && air.planet_radius_m <= 1e12, "planet radius must be in [1, 1e12] m",
       air.planet_radius_m, "use 6371.23e3");
  for (std::size_t i = 0; i < levels; ++i) {
    const bool falls = i == 0 || air.height_m[i] < air.height_m[i - 1];
    need(std::isfinite(air.height_m[i]) && air.height_m[i] > -air.planet_radius_m && falls,
         "heights must fall from level to level", air.height_m[i], "sort top to bottom");
  }
  for (double value : density)
    need(value >= 0 && std::isfinite(value), "density must be finite, not negative", value, "check it");
  for (double value : air.refractivity)
    need(value >= 0 && value <= 0.01, "refractivity n - 1 must be in [0, 0.01]", value,
         "2.8e-4 at sea level, in the visible");
  problems.throw_if_any();
}

/// Calls step(layer, part of the way from its lower to its upper level, m of the ray) at 24 nodes in every layer.
template <class Step>
void walk_ray(const RefractingAir& air, double zenith_deg, Step&& step) {
  static const HalfRange rule = gauss_half_range(24);
  const double ground_m = air.height_m.back(), ground_radius = air.planet_radius_m + ground_m;
  const auto refractivity = [&air](std::size_t upper, double part) {
    return air.refractivity.empty() ? 0.0 : between_levels(air.refractivity[upper + 1], air.refractivity[upper], part);
  };
  const double ground_refractivity = air.refractivity.empty() ? 0 : air.refractivity.back();
  const double sine = std::sin(base::rad_by_division(zenith_deg));
  const double short_of_one = 2 * std::pow(std::sin((90 - zenith_deg) * std::numbers::pi / 360), 2);  // 1 - sine
  const double bouguer = (1 + ground_refractivity) * ground_radius * sine;
  for (std::size_t i = 0; i + 1 < air.height_m.size(); ++i) {
    const double low = air.height_m[i + 1], high = air.height_m[i];
    // height = ground + w^2: dr = 2 w dw takes away the pole of ds at a horizontal start.
    const double w_low = std::sqrt(low - ground_m), w_high = std::sqrt(high - ground_m);
    for (std::size_t q = 0; q < rule.cosine.size(); ++q) {
      const double w = w_low + (w_high - w_low) * rule.cosine[q], above = w * w;
      const double part = (ground_m + above - low) / (high - low);
      const double n1 = refractivity(i, part), optical_radius = (1 + n1) * (ground_radius + above);
      // n r - c without the difference of two earth radii.
      const double excess = (n1 - ground_refractivity) * (ground_radius + above) + (1 + ground_refractivity) * above +
                            (1 + ground_refractivity) * ground_radius * short_of_one;
      const double cosine = std::sqrt(std::max(excess, 1e-300) * (optical_radius + bouguer)) / optical_radius;
      step(i, part, rule.weight[q] * (w_high - w_low) * 2 * w / cosine);
    }
  }
}

}  // namespace

double slant_amount(const RefractingAir& air, const std::vector<double>& density, double zenith_deg) {
  check_path(air, density, zenith_deg);
  double amount = 0;
  walk_ray(air, zenith_deg, [&](std::size_t layer, double part, double length_m) {
    amount += length_m * between_levels(density[layer + 1], density[layer], part);
  });
  return amount;
}

std::vector<double> slant_factors(const RefractingAir& air, double zenith_deg) {
  check_path(air, std::vector<double>(air.height_m.size(), 1.0), zenith_deg);
  std::vector<double> factor(air.height_m.size() - 1, 0.0);
  walk_ray(air, zenith_deg, [&](std::size_t layer, double, double length_m) {
    factor[layer] += length_m / (air.height_m[layer] - air.height_m[layer + 1]);
  });
  return factor;
}

double relative_airmass(const RefractingAir& air, const std::vector<double>& density, double zenith_deg) {
  const double vertical = slant_amount(air, density, 0);
  return vertical > 0 ? slant_amount(air, density, zenith_deg) / vertical : 1;
}

}  // namespace raycube::atmos::solver
