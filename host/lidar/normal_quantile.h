// Inverse of the standard normal's distribution function: Wichura, Appl. Stat. 37 (1988) 477, AS 241, PPND16.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

namespace raycube::lidar {

constexpr double kQuantileMiddle = 0.425;  ///< so far to either side of 1/2 one ratio of polynomials holds

/// Ratio of two polynomials of degree 7, coefficients from the constant upwards.
inline __attribute__((always_inline)) double ratio_of_polynomials(double x, const std::array<double, 8>& above,
                                                                  const std::array<double, 8>& below) {
  const auto value = [x](const std::array<double, 8>& c) {
    return ((((((c[7] * x + c[6]) * x + c[5]) * x + c[4]) * x + c[3]) * x + c[2]) * x + c[1]) * x + c[0];
  };
  return value(above) / value(below);
}

/// Quantile of 1/2 + q, |q| <= kQuantileMiddle.
inline __attribute__((always_inline)) double normal_quantile_middle(double q) {
  return q * ratio_of_polynomials(
                 0.180625 - q * q,
                 {3.3871328727963666080e0, 1.3314166789178437745e2, 1.9715909503065514427e3, 1.3731693765509461125e4,
                  4.5921953931549871457e4, 6.7265770927008700853e4, 3.3430575583588128105e4, 2.5090809287301226727e3},
                 {1.0, 4.2313330701600911252e1, 6.8718700749205790830e2, 5.3941960214247511077e3,
                  2.1213794301586595867e4, 3.9307895800092710610e4, 2.8729085735721942674e4, 5.2264952788528545610e3});
}

/// log(x) of a normal number: 2^e times m, the series of artanh in (m - 1) / (m + 1), m from sqrt(1/2) to sqrt(2).
/// Relative error 3e-16. Of operations that vectors have.
inline __attribute__((always_inline)) double log_of(double x) {
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x) - 0x3fe6a09e667f3bcd;  // exponent 0 from sqrt(1/2) on
  const double exponent =
      std::bit_cast<double>((bits + 0x4000000000000000) >> 52 | 0x4330000000000000) - 0x1.00000000004p52;
  const double m = std::bit_cast<double>((bits & 0x000fffffffffffff) + 0x3fe6a09e667f3bcd);
  const double s = (m - 1) / (m + 1), s2 = s * s, s4 = s2 * s2;
  const double even = 1.0 / 3 + s4 * (1.0 / 7 + s4 * (1.0 / 11 + s4 * (1.0 / 15 + s4 * (1.0 / 19))));
  const double odd = 1.0 / 5 + s4 * (1.0 / 9 + s4 * (1.0 / 13 + s4 * (1.0 / 17 + s4 * (1.0 / 21))));
  return exponent * 0x1.62e42feep-1 + (2 * s + (2 * s * (s2 * (even + s2 * odd)) + exponent * 0x1.a39ef35793c76p-33));
}

/// Whether it lies so far out that a third ratio is needed: below exp(-25).
inline bool is_far(double u) { return std::min(u, 1 - u) < 1.3887943864964021e-11; }

/// Quantile of u beyond the middle, not far.
inline __attribute__((always_inline)) double normal_quantile_outer(double u) {
  const double beyond = u < 0.5 ? u : 1 - u;
  const double z = ratio_of_polynomials(
      std::sqrt(-log_of(beyond)) - 1.6,
      {1.42343711074968357734e0, 4.63033784615654529590e0, 5.76949722146069140550e0, 3.64784832476320460504e0,
       1.27045825245236838258e0, 2.41780725177450611770e-1, 2.27238449892691845833e-2, 7.74545014278341407640e-4},
      {1.0, 2.05319162663775882187e0, 1.67638483018380384940e0, 6.89767334985100004550e-1, 1.48103976427480074590e-1,
       1.51986665636164571966e-2, 5.47593808499534494600e-4, 1.05075007164441684324e-9});
  return u < 0.5 ? -z : z;
}

/// Quantile of u in (0, 1), relative error 1e-15.
inline double normal_quantile(double u) {
  if (std::abs(u - 0.5) <= kQuantileMiddle) return normal_quantile_middle(u - 0.5);
  if (!is_far(u)) return normal_quantile_outer(u);
  const double z = ratio_of_polynomials(
      std::sqrt(-log_of(std::min(u, 1 - u))) - 5,
      {6.65790464350110377720e0, 5.46378491116411436990e0, 1.78482653991729133580e0, 2.96560571828504891230e-1,
       2.65321895265761230930e-2, 1.24266094738807843860e-3, 2.71155556874348757815e-5, 2.01033439929228813265e-7},
      {1.0, 5.99832206555887937690e-1, 1.36929880922735805310e-1, 1.48753612908506148525e-2, 7.86869131145613259100e-4,
       1.84631831751005468180e-5, 1.42151175831644588870e-7, 2.04426310338993978564e-15});
  return u < 0.5 ? -z : z;
}

}  // namespace raycube::lidar
