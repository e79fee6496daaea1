#include "atmos_tables/solver/quadrature.h"

#include <cmath>
#include <numbers>

namespace raycube::atmos::solver {

HalfRange gauss_half_range(int count) {
  HalfRange rule;
  rule.cosine.resize(static_cast<std::size_t>(count));
  rule.weight.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    // Newton's method from Tricomi's starting value; quadratic, so eight steps are plenty from an error below
    // 1e-2.
    double x = std::cos(std::numbers::pi * (i + 0.75) / (count + 0.5)), slope = 1;
    for (int step = 0; step < 8; ++step) {
      double previous = 0, value = 1;
      for (int l = 1; l <= count; ++l) {
        const double next = ((2 * l - 1) * x * value - (l - 1) * previous) / l;
        previous = value;
        value = next;
      }
      slope = count * (previous - x * value) / ((1 - x) * (1 + x));
      x -= value / slope;
    }
    const auto at = static_cast<std::size_t>(count - 1 - i);  // x falls with i
    rule.cosine[at] = 0.5 * (1 + x);
    rule.weight[at] = 1 / ((1 - x) * (1 + x) * slope * slope);
  }
  return rule;
}

}  // namespace raycube::atmos::solver
