#include "atmos_tables/solver/legendre.h"

#include <algorithm>
#include <cmath>

namespace raycube::atmos::solver {

std::vector<double> normalized_legendre(int order, int degree_end, double x) {
  std::vector<double> value;
  if (degree_end <= order) return value;
  value.resize(static_cast<std::size_t>(degree_end - order));
  const double sine2 = std::max(0.0, (1 - x) * (1 + x));
  double diagonal = 1;
  for (int i = 1; i <= order; ++i) diagonal *= std::sqrt((2.0 * i - 1) / (2.0 * i) * sine2);
  value[0] = diagonal;
  double before = 0;
  for (int l = order + 1; l < degree_end; ++l) {
    const auto at = static_cast<std::size_t>(l - order);
    const double down = std::sqrt(static_cast<double>(l - 1 - order) * (l - 1 + order));
    value[at] =
        ((2 * l - 1) * x * value[at - 1] - down * before) / std::sqrt(static_cast<double>(l - order) * (l + order));
    before = value[at - 1];
  }
  return value;
}

double legendre_series(const std::vector<double>& moments, std::size_t count, double x) {
  double sum = 0, previous = 0, value = 1;
  for (std::size_t k = 0; k < std::min(count, moments.size()); ++k) {
    const auto degree = static_cast<double>(k);
    sum += (2 * degree + 1) * moments[k] * value;
    const double next = ((2 * degree + 1) * x * value - degree * previous) / (degree + 1);
    previous = value;
    value = next;
  }
  return sum;
}

}  // namespace raycube::atmos::solver
