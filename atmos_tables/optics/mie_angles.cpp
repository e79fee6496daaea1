#include "atmos_tables/optics/mie_angles.h"

namespace raycube::atmos {

MieAmplitudes mie_amplitudes(const MieSphere& sphere, double cosine) {
  MieAmplitudes out;
  double pi_before = 0, pi_here = 1;  // angular functions of orders 0 and 1, Bohren & Huffman eq. 4.47
  for (std::size_t i = 0; i < sphere.terms(); ++i) {
    const double n = static_cast<double>(i + 1), weight = (2 * n + 1) / (n * (n + 1));
    const double tau = n * cosine * pi_here - (n + 1) * pi_before;
    out.s1 += weight * (sphere.a()[i] * pi_here + sphere.b()[i] * tau);
    out.s2 += weight * (sphere.a()[i] * tau + sphere.b()[i] * pi_here);
    const double pi_next = ((2 * n + 1) * cosine * pi_here - (n + 1) * pi_before) / n;
    pi_before = pi_here, pi_here = pi_next;
  }
  return out;
}

void add_mie_intensity(const MieSphere& sphere, const std::vector<double>& cosine, double weight,
                       std::vector<double>& forward, std::vector<double>& backward) {
  const std::size_t terms = sphere.terms();
  // c (a + b) and c (a - b) with c = (2n + 1) / (n (n + 1)); S1 +- S2 = sum c (a +- b)(pi +- tau). Going to -mu turns
  // pi +- tau into (-1)^(n-1) (pi -+ tau).
  struct Term {
    double sum_re, sum_im, difference_re, difference_im, grow, shrink, order;
  };
  std::vector<Term> list(terms);
  for (std::size_t i = 0; i < terms; ++i) {
    const double n = static_cast<double>(i + 1), c = (2 * n + 1) / (n * (n + 1));
    const auto sum = c * (sphere.a()[i] + sphere.b()[i]), difference = c * (sphere.a()[i] - sphere.b()[i]);
    list[i] = {sum.real(), sum.imag(), difference.real(), difference.imag(), (2 * n + 1) / n, (n + 1) / n, n};
  }
  for (std::size_t j = 0; j < cosine.size(); ++j) {
    const double mu = cosine[j];
    double plus_re = 0, plus_im = 0, minus_re = 0, minus_im = 0;                      // S1 + S2, S1 - S2 at mu
    double back_plus_re = 0, back_plus_im = 0, back_minus_re = 0, back_minus_im = 0;  // the same at -mu
    double pi_before = 0, pi_here = 1, sign = 1;
    for (const Term& term : list) {
      const double tau = term.order * mu * pi_here - (term.order + 1) * pi_before;
      const double add = pi_here + tau, subtract = pi_here - tau;
      plus_re += term.sum_re * add, plus_im += term.sum_im * add;
      minus_re += term.difference_re * subtract, minus_im += term.difference_im * subtract;
      back_plus_re += sign * term.sum_re * subtract, back_plus_im += sign * term.sum_im * subtract;
      back_minus_re += sign * term.difference_re * add, back_minus_im += sign * term.difference_im * add;
      const double pi_next = term.grow * mu * pi_here - term.shrink * pi_before;
      pi_before = pi_here, pi_here = pi_next, sign = -sign;
    }
    // |S1|^2 + |S2|^2 = (|S1 + S2|^2 + |S1 - S2|^2) / 2
    forward[j] += weight * 0.25 * (plus_re * plus_re + plus_im * plus_im + minus_re * minus_re + minus_im * minus_im);
    backward[j] += weight * 0.25 *
                   (back_plus_re * back_plus_re + back_plus_im * back_plus_im + back_minus_re * back_minus_re +
                    back_minus_im * back_minus_im);
  }
}

double mie_phase(const MieSphere& sphere, double cosine) {
  const MieAmplitudes s = mie_amplitudes(sphere, cosine);
  const double x = sphere.size_parameter();
  return 2 * (std::norm(s.s1) + std::norm(s.s2)) / (x * x * sphere.efficiencies().scattering);
}

std::size_t mie_nodes(std::size_t terms, std::size_t last) {
  // S1 and S2 are polynomials of degree `terms`; n nodes are exact to degree 2n - 1. Even: no node at 0.
  const std::size_t nodes = terms + last / 2 + 1;
  return nodes + nodes % 2;
}

std::vector<double> mie_moments(const MieSphere& sphere, std::size_t last) {
  const GaussRule rule = gauss_legendre_rule(mie_nodes(sphere.terms(), last));
  const std::size_t half = rule.node.size() / 2;
  const std::vector<double> cosine(rule.node.begin() + static_cast<std::ptrdiff_t>(half), rule.node.end());
  std::vector<double> forward(half, 0.0), backward(half, 0.0), value(2 * half);
  const double x = sphere.size_parameter();
  add_mie_intensity(sphere, cosine, 4 / (x * x * sphere.efficiencies().scattering), forward, backward);
  for (std::size_t i = 0; i < half; ++i) value[half + i] = forward[i], value[half - 1 - i] = backward[i];
  return legendre_moments(rule, value, last);
}

}  // namespace raycube::atmos
