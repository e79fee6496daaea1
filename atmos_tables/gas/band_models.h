// Transmittance of a band of many lines, as -ln T: three closed forms.
#pragma once

#include <cmath>
#include <cstddef>

namespace raycube::atmos {

/// Gases with lines, in the order of the data: those of optics/air_profile.h, then LOWTRAN7's trace gases.
enum class LineGas : std::size_t { h2o, co2, o3, n2o, co, ch4, o2, no, so2, no2, nh3 };
inline constexpr std::size_t kLineGases = 11;

/// Pierluissi & Maragoudakis (1986), AFGL-TR-86-0272: (C W)^a with 10^log10_c = C; W the scaled amount >= 0, 0 < a < 1.
inline double power_law_depth(double log10_c, double amount, double exponent) {
  return amount > 0 ? std::exp(exponent * (2.302585092994046 * log10_c + std::log(amount))) : 0.0;
}

/// Goody (1952), exponential line strengths: a1 u / sqrt(1 + (a1/a2) u^2 / up). u, up >= 0: amount, and amount times
/// pressure in atmospheres (g cm-2); up 0 means no line width, hence no absorption. Weak a1 u, strong sqrt(a1 a2 up).
/// Written so that neither very large nor very small amounts overflow.
inline double goody_depth(double a1, double a2, double amount, double amount_pressure) {
  const double weak = a1 * amount, strong2 = a1 * a2 * amount_pressure;
  if (!(weak > 0 && strong2 > 0)) return 0;
  return 1 / std::sqrt(1 / weak / weak + 1 / strong2);
}

/// Malkmus (1967): (a2 up / 2u) (sqrt(1 + 4 (a1/a2) u^2 / up) - 1), written without the difference of like numbers.
/// Same limits.
inline double malkmus_depth(double a1, double a2, double amount, double amount_pressure) {
  const double weak = a1 * amount, strong2 = a1 * a2 * amount_pressure;
  if (!(weak > 0 && strong2 > 0)) return 0;
  return 2 / (1 / weak + std::sqrt(1 / weak / weak + 4 / strong2));
}

}  // namespace raycube::atmos
