#include "atmos_tables/environment_function.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "atmos_tables/rayleigh.h"

namespace raycube::atmos {

namespace {

/// F = 1 - molecule_near exp(-molecule_rate r) - (1 - molecule_near) exp(-0.08 r), and
/// F = 1 - aerosol_far exp(-aerosol_far_rate r) - (1 - aerosol_far) exp(-aerosol_near_rate r); r and rates in km, 1/km.
struct Node {
  double height_km, molecule_near, molecule_rate, aerosol_far, aerosol_far_rate, aerosol_near_rate;
};
constexpr Node kNodes[] = {{0.5, 0.730, 2.800, 0.239, 1.40, 9.17}, {1, 0.710, 1.510, 0.396, 1.20, 6.26},
                           {2, 0.656, 0.845, 0.588, 1.02, 5.48},   {3, 0.606, 0.634, 0.626, 0.86, 5.16},
                           {4, 0.560, 0.524, 0.612, 0.74, 4.74},   {5, 0.516, 0.465, 0.505, 0.56, 3.65},
                           {6, 0.473, 0.429, 0.454, 0.46, 3.24},   {7, 0.433, 0.405, 0.448, 0.42, 3.15},
                           {8, 0.395, 0.390, 0.444, 0.38, 3.07},   {10, 0.323, 0.386, 0.445, 0.34, 2.97},
                           {12, 0.258, 0.409, 0.444, 0.30, 2.88},  {14, 0.209, 0.445, 0.448, 0.28, 2.83},
                           {16, 0.171, 0.488, 0.448, 0.27, 2.83},  {18, 0.142, 0.545, 0.448, 0.27, 2.83},
                           {20, 0.122, 0.608, 0.448, 0.27, 2.83},  {60, 0.070, 0.868, 0.448, 0.27, 2.83}};
constexpr double kMoleculeFarRate = 0.08;
constexpr double kMoleculeScaleHeight_m = 8000;

Node node_at(double height_km) {
  if (height_km <= kNodes[0].height_km) return kNodes[0];
  if (height_km >= std::end(kNodes)[-1].height_km) return std::end(kNodes)[-1];
  const Node* above =
      std::find_if(std::begin(kNodes), std::end(kNodes), [&](const Node& n) { return n.height_km > height_km; });
  const Node &a = above[-1], &b = above[0];
  const double f = (height_km - a.height_km) / (b.height_km - a.height_km);
  const auto mix = [&](double x, double y) { return x + f * (y - x); };
  return {height_km,
          mix(a.molecule_near, b.molecule_near),
          mix(a.molecule_rate, b.molecule_rate),
          mix(a.aerosol_far, b.aerosol_far),
          mix(a.aerosol_far_rate, b.aerosol_far_rate),
          mix(a.aerosol_near_rate, b.aerosol_near_rate)};
}

double nadir(Scatterer scatterer, const Node& n, double r) {
  if (scatterer == Scatterer::molecules)
    return -n.molecule_near * std::expm1(-n.molecule_rate * r) -
           (1 - n.molecule_near) * std::expm1(-kMoleculeFarRate * r);
  return -n.aerosol_far * std::expm1(-n.aerosol_far_rate * r) -
         (1 - n.aerosol_far) * std::expm1(-n.aerosol_near_rate * r);
}

}  // namespace

double environment_function(Scatterer scatterer, double radius_km, double height_km, double cos_view) {
  const double lowest = kNodes[0].height_km;
  const double f =
      nadir(scatterer, node_at(height_km), height_km < lowest ? radius_km * lowest / height_km : radius_km);
  const double l = std::log(std::clamp(cos_view, 0.5, 1.0));
  if (scatterer == Scatterer::molecules) return f * (l * (1 - f) + 1);
  constexpr double a0 = 1.3347, b0 = 0.57757, a1 = -1.479, b1 = -1.5275;
  return f * (a0 * l + b0 * l * l + 1 + f * (a1 * l + b1 * l * l) + f * f * ((-a1 - a0) * l + (-b1 - b0) * l * l));
}

/// By the Illinois method (Dowell & Jarratt, BIT 11, 1971) in the logarithm of the radius, until F is right to 1e-13.
double environment_radius_km(Scatterer scatterer, double share, double height_km, double cos_view) {
  const auto beyond = [&](double log_km) {
    return environment_function(scatterer, std::exp(log_km), height_km, cos_view) - share;
  };
  double low = std::log(1e-7), high = std::log(1e3), below = beyond(low), above = beyond(high);
  if (below >= 0) return std::exp(low);
  if (above <= 0) return std::exp(high);
  for (int step = 0, side = 0; step < 200 && high - low > 1e-12; ++step) {
    const double at = (low * above - high * below) / (above - below), value = beyond(at);
    if (value == 0 || at <= low || at >= high) return std::exp(at);
    if (value < 0) {
      low = at, below = value;
      if (side < 0) above /= 2;
      side = -1;
    } else {
      high = at, above = value;
      if (side > 0) below /= 2;
      side = 1;
    }
    if (std::abs(value) < 1e-13) return std::exp(at);
  }
  return std::exp(high);
}

double molecular_diffuse_transmission(double wavelength_um, double pressure_hPa, double low_m, double high_m,
                                      double cos_view) {
  if (high_m <= low_m) return 0;
  const double depth = rayleigh_depth(wavelength_um, pressure_hPa) *
                       (std::exp(-low_m / kMoleculeScaleHeight_m) - std::exp(-high_m / kMoleculeScaleHeight_m));
  const double mu = cos_view, direct = std::exp(-depth / mu);
  return (2.0 / 3 + mu + (2.0 / 3 - mu) * direct) / (4.0 / 3 + depth) - direct;
}

}  // namespace raycube::atmos
