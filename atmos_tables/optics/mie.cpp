#include "atmos_tables/optics/mie.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "host/base/error.h"

namespace raycube::atmos {

namespace {

using Complex = std::complex<double>;

std::string text(double value) {
  std::string out(32, '\0');
  out.resize(static_cast<std::size_t>(std::snprintf(out.data(), out.size(), "%.9g", value)));
  return out;
}

void check(double x, Complex m) {
  base::Problems problems;
  const base::Where where{"", 0, 0, "Mie sphere"};
  if (!(x >= kMinSizeParameter && x <= kMaxSizeParameter))
    problems.add(where, "size parameter must lie in 1e-6 to 2e5", text(x),
                 "smaller spheres: Rayleigh; larger ones: geometric optics");
  if (!(m.real() > 0 && m.imag() >= 0 && std::isfinite(m.real()) && std::isfinite(m.imag())))
    problems.add(where, "refractive index n + ik needs n > 0, k >= 0, finite",
                 text(m.real()) + " + i " + text(m.imag()), "give k as a positive number when the sphere absorbs");
  else if (!(std::abs(m - 1.0) >= 1e-6))
    problems.add(where, "the sphere must differ from the medium", text(m.real()) + " + i " + text(m.imag()),
                 "leave out a sphere that scatters nothing");
  else if (!(std::abs(m) * x <= 1e7))
    problems.add(where, "|index| times size parameter must not exceed 1e7", text(std::abs(m) * x),
                 "lower k: such a sphere already reflects like a metal");
  problems.throw_if_any();
}

/// Orders past the argument after which a downward recurrence has forgotten its wrong start: there the wanted solution
/// has fallen by exp(-(4/3) (2^(1/3) 8)^(3/2)) ~ 1e-18 against the other (Airy's form of the Bessel functions).
std::size_t order_beyond(double argument) {
  return static_cast<std::size_t>(std::ceil(argument + 8 * std::cbrt(argument))) + 16;
}

/// D_n(z) = psi_n'(z) / psi_n(z), n = 0..last, by downward recurrence D_(n-1) = n/z - 1/(D_n + n/z): stable for every
/// z.
std::vector<Complex> log_derivatives(Complex z, std::size_t last) {
  const std::size_t start = std::max(last + 16, order_beyond(std::abs(z)));
  const Complex inverse = 1.0 / z;
  std::vector<Complex> out(last + 1);
  Complex d = 0;
  for (std::size_t n = start; n >= 1; --n) {
    const Complex ratio = static_cast<double>(n) * inverse;
    Complex sum = d + ratio;
    if (sum == 0.0)
      sum = 1e-300;  // z is a zero of psi_(n-1): the next value is infinite, the one after it finite again
    d = ratio - 1.0 / sum;
    if (n - 1 <= last) out[n - 1] = d;
  }
  return out;
}

/// psi_n(x) = x j_n(x), n = 0..last, by Miller's downward recurrence, scaled by the larger of psi_0 and psi_1.
std::vector<double> riccati_psi(double x, std::size_t last) {
  // Far above x a step grows by (2n + 1)/x: few orders suffice there, and more would overflow for tiny x.
  const std::size_t start = std::max(last + 1, x < 1 ? last + 8 : order_beyond(x));
  std::vector<double> out(last + 1);
  double above = 0, here = 1e-250;
  for (std::size_t n = start; n >= 1; --n) {  // here = psi_n
    const double below = static_cast<double>(2 * n + 1) / x * here - above;
    above = here, here = below;
    if (n - 1 <= last) out[n - 1] = here;
  }
  // psi_1 = sin x / x - cos x loses its digits for small x; psi_0 is the larger one there.
  const double psi0 = std::sin(x), psi1 = psi0 / x - std::cos(x);
  const double scale = x < 1 || std::abs(psi0) >= std::abs(psi1) ? psi0 / out[0] : psi1 / out[1];
  for (double& value : out) value *= scale;
  return out;
}

}  // namespace

std::size_t mie_terms(double x) { return static_cast<std::size_t>(x + 7 * std::cbrt(x) + 3); }

MieSphere::MieSphere(double size_parameter, Complex index) : size_parameter_(size_parameter) {
  check(size_parameter, index);
  const double x = size_parameter;
  const std::size_t terms = mie_terms(x);
  const std::vector<Complex> derivative = log_derivatives(index * x, terms);
  const std::vector<double> psi = riccati_psi(x, terms);
  a_.resize(terms), b_.resize(terms);

  // chi_n = -x y_n, upward (stable); xi_n = psi_n - i chi_n. Bohren & Huffman eq. 4.88 with c = D/m + n/x (a) or m D +
  // n/x (b): coefficient = (c psi_n - psi_(n-1)) / (c xi_n - xi_(n-1)).
  double chi_before = -std::sin(x), chi = std::cos(x);  // orders -1 and 0
  double scattered = 0, absorbed = 0;
  Complex back = 0;
  for (std::size_t n = 1; n <= terms; ++n) {
    const double order = static_cast<double>(n), chi_next = (2 * order - 1) / x * chi - chi_before;
    chi_before = chi, chi = chi_next;
    const double weight = 2 * order + 1;
    const auto coefficient = [&](Complex c) {
      const Complex top = c * psi[n] - psi[n - 1];
      const Complex bottom = top - Complex(0, 1) * (c * chi - chi_before);
      // Re q - |q|^2 of the quotient q, with the Wronskian psi_n chi_(n-1) - psi_(n-1) chi_n = -1: no cancellation.
      scattered += weight * (std::norm(top) / std::norm(bottom));
      absorbed += weight * (-c.imag() / std::norm(bottom));
      return top / bottom;
    };
    a_[n - 1] = coefficient(derivative[n] / index + order / x);
    b_[n - 1] = coefficient(derivative[n] * index + order / x);
    back += (n % 2 ? -weight : weight) * (a_[n - 1] - b_[n - 1]);
  }
  double forward = 0;  // Bohren & Huffman p. 120
  for (std::size_t i = 0; i < terms; ++i) {
    const double n = static_cast<double>(i + 1);
    forward += (2 * n + 1) / (n * (n + 1)) * (a_[i] * std::conj(b_[i])).real();
    if (i + 1 < terms)
      forward += n * (n + 2) / (n + 1) * (a_[i] * std::conj(a_[i + 1]) + b_[i] * std::conj(b_[i + 1])).real();
  }
  const double area = x * x;
  efficiencies_.scattering = 2 * scattered / area;
  efficiencies_.absorption = std::max(0.0, 2 * absorbed / area);
  efficiencies_.extinction = efficiencies_.scattering + efficiencies_.absorption;
  efficiencies_.backscatter = std::norm(back) / area;
  efficiencies_.asymmetry = 2 * forward / scattered;
}

}  // namespace raycube::atmos
