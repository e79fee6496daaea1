#include "atmos_tables/lines/voigt.h"
#include "host/base/units.h"

#include <cmath>
#include <numbers>

namespace raycube::atmos {

namespace {

/// Re w is y sum_k weight_k (x^2 + y^2 + t_k^2) / ((x^2 - y^2 - t_k^2)^2 + 4 x^2 y^2) for the rules used here: nodes
/// +-t_k.
template <std::size_t N>
struct PairedRule {
  std::array<double, N> weight, node2;
  double sum(double x2, double y2) const {
    const double size = x2 + y2, difference = x2 - y2, cross = 4 * x2 * y2;
    double total = 0;
    for (std::size_t k = 0; k < N; ++k) {
      const double a = difference - node2[k];
      total += weight[k] * (size + node2[k]) / (a * a + cross);
    }
    return total;
  }
};

constexpr int kVoigtNodes = 12;
const double kStep = std::sqrt(base::kPi / kVoigtNodes);

/// first: 0.5 for the midpoint rule, 0 for the trapezoidal one.
PairedRule<kVoigtNodes> even_rule(double first) {
  PairedRule<kVoigtNodes> rule{};
  for (int k = 0; k < kVoigtNodes; ++k) {
    const double node = (k + first) * kStep;
    rule.node2[static_cast<std::size_t>(k)] = node * node;
    // At the node 0 both of a pair are the same point.
    rule.weight[static_cast<std::size_t>(k)] = (node > 0 ? 2 : 1) * kStep / base::kPi * std::exp(-node * node);
  }
  return rule;
}

// Abscissas and weights of Gauss-Hermite quadrature (Abramowitz & Stegun 1964, table 25.10): weight 2 w / pi, t^2.
constexpr PairedRule<1> kHermite2{{2 / base::kPi * 0.8862269254527580}, {0.5}};
constexpr PairedRule<2> kHermite4{{2 / base::kPi * 8.049140900055128e-1, 2 / base::kPi * 8.131283544724518e-2},
                                  {0.5246476232752903 * 0.5246476232752903, 1.650680123885785 * 1.650680123885785}};
constexpr PairedRule<3> kHermite6{
    {2 / base::kPi * 7.246295952243925e-1, 2 / base::kPi * 1.570673203228566e-1, 2 / base::kPi * 4.530009905508846e-3},
    {0.4360774119276165 * 0.4360774119276165, 1.335849074013697 * 1.335849074013697,
     2.350604973674492 * 2.350604973674492}};
constexpr PairedRule<4> kHermite8{{2 / base::kPi * 6.611470125582413e-1, 2 / base::kPi * 2.078023258148919e-1,
                                   2 / base::kPi * 1.707798300741348e-2, 2 / base::kPi * 1.996040722113676e-4},
                                  {0.3811869902073221 * 0.3811869902073221, 1.157193712446780 * 1.157193712446780,
                                   1.981656756695843 * 1.981656756695843, 2.930637420257244 * 2.930637420257244}};

double near_origin(double x, double y) {
  static const PairedRule<kVoigtNodes> midpoint = even_rule(0.5), trapezoid = even_rule(0);
  const double phase = x / kStep - std::floor(x / kStep);
  // The rule whose nodes are further away.
  const bool between = phase >= 0.25 && phase <= 0.75;
  double value = y * (between ? trapezoid : midpoint).sum(x * x, y * y);
  if (y < base::kPi / kStep) {
    // Residue: Re 2 exp(-z^2) / (1 +- exp(-2 i pi z / h)).
    const double sign = between ? -1 : 1, grown = std::exp(2 * base::kPi * y / kStep), turn = 2 * base::kPi * x / kStep;
    const double re = 1 + sign * grown * std::cos(turn), im = -sign * grown * std::sin(turn);
    value += 2 * std::exp(y * y - x * x) * (std::cos(2 * x * y) * re - std::sin(2 * x * y) * im) / (re * re + im * im);
  }
  return value;
}

}  // namespace

double faddeeva_real(double x, double y) {
  x = std::abs(x);
  const double x2 = x * x, y2 = y * y, size = x2 + y2;
  if (size < 64) return near_origin(x, y);
  if (size < 225) return y * kHermite8.sum(x2, y2);
  if (size < 1e4) return y * kHermite6.sum(x2, y2);
  if (size < 1e6) return y * kHermite4.sum(x2, y2);
  return y * kHermite2.sum(x2, y2);
}

VoigtProfile::VoigtProfile(double doppler, double lorentz)
    : scale_(std::sqrt(std::numbers::ln2) / doppler), y_(lorentz * scale_), factor_(scale_ / std::sqrt(base::kPi)) {}

double doppler_half_width_per_cm(double wavenumber_per_cm, double temperature_K, double molar_mass_g) {
  // sqrt(2 ln2 N_A k 1000 g/kg) / c, SI 2019.
  static const double constant = std::sqrt(2 * std::numbers::ln2 * 8.31446261815324 * 1000) / 299792458.0;
  return wavenumber_per_cm * constant * std::sqrt(temperature_K / molar_mass_g);
}

}  // namespace raycube::atmos
