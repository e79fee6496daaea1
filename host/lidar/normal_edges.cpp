#include "host/lidar/normal_edges.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "host/base/wide.h"

namespace raycube::lidar {
namespace {

constexpr double kFarthest = 10;
/// Of the fit, in rising powers of 1.4 (z - 4) / (z + 4) + 0.4, which runs from -1 to 1.
constexpr double kFit[] = {0.9653379972557827,      -0.6290264515412035,    0.2948694826750817,
                           -0.09465113608523278,    0.01710012278007854,    0.00016024405249198678,
                           -0.0007989297062801955,  6.863433007625121e-05,  4.067907837850982e-05,
                           -4.606255614303681e-06,  -2.681670850983291e-06, 1.6865838002621234e-07,
                           2.0176278659839656e-07,  7.14483662661225e-09,   -1.4133775413876898e-08,
                           -1.5940357522376397e-09, 6.685008098311036e-10};

constexpr double kExponential[] = {
    1.0,        1.0,         0.5,          1.0 / 6,       1.0 / 24,       1.0 / 120,       1.0 / 720,
    1.0 / 5040, 1.0 / 40320, 1.0 / 362880, 1.0 / 3628800, 1.0 / 39916800, 1.0 / 479001600, 1.0 / 6227020800};

/// Of every fourth coefficient, rising, from number `First` on, in powers of x^4.
template <std::size_t First, std::size_t Count>
inline __attribute__((always_inline)) double quarter(const double (&coefficients)[Count], double x4) {
  if constexpr (First + 4 < Count)
    return coefficients[First] + x4 * quarter<First + 4>(coefficients, x4);
  else
    return coefficients[First];
}

/// Without a loop, so that the one over places becomes vectors; as four sums side by side, since one waits for its last
/// term.
template <std::size_t Count>
inline __attribute__((always_inline)) double polynomial(const double (&rising)[Count], double x) {
  const double x2 = x * x, x4 = x2 * x2;
  return (quarter<0>(rising, x4) + x * quarter<1>(rising, x4)) +
         x2 * (quarter<2>(rising, x4) + x * quarter<3>(rising, x4));
}

/// exp(x) for -100 <= x <= 0: 2^n times the series of the rest, |rest| <= log(2) / 2.
inline __attribute__((always_inline)) double exp_of(double x) {
  constexpr double kRounding = 0x1.8p52;  // a sum with it is whole, its lowest bits are the number
  const double sum = x * std::numbers::log2e + kRounding, n = sum - kRounding;
  const double rest = (x - n * 0x1.62e42feep-1) - n * 0x1.a39ef35793c76p-33;
  return polynomial(kExponential, rest) * std::bit_cast<double>((std::bit_cast<std::uint64_t>(sum) + 1023u) << 52);
}

}  // namespace

RAYCUBE_WIDE void normal_edges(double first, double step, std::size_t count, double* tail, double* density) {
  for (std::size_t i = 0; i < count; ++i) {
    const double far = std::abs(first + static_cast<double>(static_cast<std::int32_t>(i)) * step);
    const double z = far < kFarthest ? far : kFarthest;
    const double nearness = 1 / (z + 4), place = 1.8 - 11.2 * nearness, fallen = exp_of(-0.5 * z * z);
    tail[i] = fallen * polynomial(kFit, place) * nearness;
    density[i] = fallen * (0.5 * std::numbers::inv_sqrtpi * std::numbers::sqrt2);
  }
}

}  // namespace raycube::lidar
