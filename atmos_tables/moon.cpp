#include "atmos_tables/moon.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "host/base/error.h"

namespace raycube::atmos {

namespace {

struct LunarNode {
  double at, value;
};
constexpr LunarNode kAlbedo[] = {
#include "atmos_tables/data/moon_albedo.inc"
    // LOWTRAN7, function SOURCE.
    {2.6, 0.339},
    {2.7, 0.345},
    {2.8, 0.350},
    {5.0, 0.400},
    {30.0, 0.400}};

/// Full moon 100, against the phase angle in degrees: LOWTRAN7, function SOURCE.
constexpr LunarNode kPhase[] = {{0, 100},   {10, 73.2}, {20, 57.8}, {30, 42.3}, {40, 32.0},   {50, 23.3},
                                {60, 16.7}, {70, 12.4}, {80, 8.7},  {90, 6.7},  {100, 4.7},   {110, 3.6},
                                {120, 2.4}, {130, 1.2}, {140, 0.9}, {150, 0.4}, {160, 0.002}, {180, 0}};

template <class Nodes>
double linear(const Nodes& nodes, double x) {
  const LunarNode* upper = std::lower_bound(std::begin(nodes) + 1, std::end(nodes) - 1, x,
                                            [](const LunarNode& node, double at) { return node.at < at; });
  const LunarNode &a = upper[-1], &b = *upper;
  return std::lerp(a.value, b.value, (x - a.at) / (b.at - a.at));
}

}  // namespace

double moon_over_sun(double phase_angle_deg, double wavelength_um) {
  if (!(phase_angle_deg >= 0 && phase_angle_deg <= 180))
    throw base::Error(base::Fault::input, "moon: the phase angle must lie in 0..180 degrees, 0 = full moon (found " +
                                              std::to_string(phase_angle_deg) + ")");
  if (!(wavelength_um >= 0.3 && wavelength_um <= 30))
    throw base::Error(base::Fault::input,
                      "moon: the albedo covers 0.3 to 30 um (found " + std::to_string(wavelength_um) + " um)");
  return 2.04472e-7 * linear(kPhase, phase_angle_deg) * linear(kAlbedo, wavelength_um);
}

std::string moon_source_name() { return "LOWTRAN7 (AFGL-TR-88-0177) lunar albedo and phase"; }

}  // namespace raycube::atmos
