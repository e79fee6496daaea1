#include "host/reference/lidar_quadrature.h"

#include <cmath>

namespace raycube::reference {

namespace {

// Kronrod, "Nodes and Weights of Quadrature Formulas", 1965; as in QUADPACK's qk15.
constexpr double kNode[8] = {0.991455371120812639206854697526329, 0.949107912342758524526189684047851,
                             0.864864423359769072789712788640926, 0.741531185599394439863864773280788,
                             0.586087235467691130294144691693013, 0.405845151377397166906606412076961,
                             0.207784955007898467600689403773245, 0.0};
constexpr double kKronrod[8] = {0.022935322010529224963732008058970, 0.063092092629978553290700663189204,
                                0.104790010322250183839876322541518, 0.140653259715525918745189590510238,
                                0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
                                0.204432940075298892414161999234649, 0.209482141084727828012999174891714};
constexpr double kGauss[4] = {0.129484966168869693270611432679082, 0.279705391489276667901467771423780,
                              0.381830050505118944950369775488975, 0.417959183673469387755102040816327};

struct Pair {
  double kronrod = 0, gauss = 0;
};

Pair rule(const std::function<double(double)>& value, double from, double to) {
  const double middle = 0.5 * (from + to), half = 0.5 * (to - from);
  Pair out;
  for (int i = 0; i < 8; ++i) {
    const double sum = i == 7 ? value(middle) : value(middle - half * kNode[i]) + value(middle + half * kNode[i]);
    out.kronrod += kKronrod[i] * sum * half;
    if (i % 2 == 1) out.gauss += kGauss[i / 2] * sum * half;
  }
  return out;
}

double refine(const std::function<double(double)>& value, double from, double to, double absolute, int levels,
              const Pair& whole) {
  if (levels == 0 || std::abs(whole.kronrod - whole.gauss) <= absolute) return whole.kronrod;
  const double middle = 0.5 * (from + to);
  return refine(value, from, middle, 0.5 * absolute, levels - 1, rule(value, from, middle)) +
         refine(value, middle, to, 0.5 * absolute, levels - 1, rule(value, middle, to));
}

}  // namespace

double adaptive_integral(const std::function<double(double)>& value, const std::vector<double>& cuts, double relative) {
  std::vector<Pair> pieces;
  double whole = 0;
  for (std::size_t i = 1; i < cuts.size(); ++i)
    whole += std::abs(pieces.emplace_back(rule(value, cuts[i - 1], cuts[i])).kronrod);
  double sum = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i)
    sum += refine(value, cuts[i], cuts[i + 1], relative * whole / static_cast<double>(pieces.size()), 12, pieces[i]);
  return sum;
}

}  // namespace raycube::reference
