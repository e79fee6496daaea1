#include "atmos_tables/single_scatter.h"

#include <cmath>

namespace raycube::atmos {

double slab_mean(double x) {
  if (x < 1e-8) return 1.0 - 0.5 * x;  // next term x^2/6 is below 2e-17
  return -std::expm1(-x) / x;
}

double layer_scatter_up(double depth, double sun_slope, double view_slope) {
  return view_slope * depth * slab_mean((sun_slope + view_slope) * depth);
}

double layer_scatter_down(double depth, double sun_slope, double view_slope) {
  // The smaller of the two slopes goes outside, so the argument of slab_mean is never negative and nothing overflows.
  const double smaller = sun_slope < view_slope ? sun_slope : view_slope;
  return view_slope * depth * std::exp(-smaller * depth) * slab_mean(std::abs(view_slope - sun_slope) * depth);
}

double layer_emission(double depth, double view_slope) { return -std::expm1(-depth * view_slope); }

double phase_henyey_greenstein(double asymmetry, double cos_angle) {
  const double g2 = asymmetry * asymmetry;
  return (1 - g2) / std::pow(1 + g2 - 2 * asymmetry * cos_angle, 1.5);
}

}  // namespace raycube::atmos
