// Mie's series for one sphere. Oracles: printed tables (Bohren & Huffman 1983; Wiscombe 1979), the series in 60 to 160
// digits (mie_reference.py), limits for small and large spheres, and physical laws.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "atmos_tables/optics/mie.h"
#include "atmos_tables/optics/mie_angles.h"
#include "host/base/error.h"
#include "tests/support/relative.h"

using namespace raycube;
using namespace raycube::atmos;
using Complex = std::complex<double>;
using raycube::test::relative;

namespace {
constexpr double kPi = std::numbers::pi;
/// Bohren & Huffman's example: radius 0.525 um, wavelength 0.6328 um.
const double kBohrenSize = 2 * kPi * 0.525 / 0.6328;
}  // namespace

TEST_CASE("S18 Mie: Bohren & Huffman 1983, appendix A: efficiencies and angular intensities") {
  const MieSphere sphere(kBohrenSize, 1.55);
  CHECK(std::abs(sphere.efficiencies().extinction - 3.10543) <= 0.51e-5);
  CHECK(std::abs(sphere.efficiencies().scattering - 3.10543) <= 0.51e-5);
  CHECK(std::abs(sphere.efficiencies().backscatter - 2.92534) <= 0.51e-5);
  CHECK(std::abs(sphere.efficiencies().asymmetry - 0.63314) <= 0.51e-5);
  // S11 over its forward value at 0, 9, ... 180 degrees, six printed digits.
  const double printed[] = {1.00000,    0.785390,   0.356897,  0.0766119, 0.0355355,  0.0701845,  0.0574313,
                            0.0219660,  0.0125959,  0.0173750, 0.0124601, 0.00679093, 0.00954239, 0.00863419,
                            0.00227421, 0.00543998, 0.0160243, 0.0188852, 0.0195254,  0.0301676,  0.0383189};
  const double forward = mie_phase(sphere, 1);
  for (int i = 0; i < 21; ++i) {
    CAPTURE(i);
    // Half a unit of the sixth digit of 0.1ddddd.
    CHECK(relative(mie_phase(sphere, std::cos(i * kPi / 20)) / forward, printed[i]) <= 5e-6);
  }
}

TEST_CASE("S18 Mie: Wiscombe 1979 (NCAR/TN-140), printed to six decimals, size parameters 0.055 to 10000") {
  const double none = std::numeric_limits<double>::quiet_NaN();  // not used here
  struct Row {
    double n, k, x, extinction, scattering, asymmetry;
  };
  for (const Row& row : std::initializer_list<Row>{
           {1.5, 0, 10, 2.881999, 2.881999, 0.742913},     {1.5, 0, 100, 2.094388, 2.094388, 0.818246},
           {1.5, 0, 1000, 2.013945, 2.013945, 0.827882},   {1.5, 0, 5000, 2.008650, 2.008650, 0.829592},
           {1.5, 0.1, 10, 2.459791, 1.235144, 0.922350},   {1.5, 0.1, 100, 2.089822, 1.132134, 0.950392},
           {1.5, 0.1, 1000, 2.019703, 1.106932, 0.950880}, {1.5, 0.1, 5000, 2.006775, 1.099193, 0.950650},
           {0.75, 0, 0.099, 0.000007, 0.000007, 0.001448}, {0.75, 0, 0.101, 0.000008, 0.000008, 0.001507},
           {0.75, 0, 10, 2.232265, 2.232265, 0.896473},    {0.75, 0, 1000, 1.997908, 1.997908, 0.844944},
           {1.33, 1e-5, 1, none, 0.093923, 0.184517},      {1.33, 1e-5, 100, none, 2.096594, 0.868959},
           {1.33, 1e-5, 10000, none, 1.723857, 0.907840},  {1.5, 1, 0.055, 0.101491, 0.000011, 0.000491},
           {1.5, 1, 0.056, 0.103347, 0.000012, 0.000509},  {1.5, 1, 1, none, 0.663454, 0.192136},
           {1.5, 1, 100, 2.097502, 1.283697, 0.850252},    {1.5, 1, 10000, 2.004368, 1.236575, 0.846309},
           {10, 10, 1, none, 2.049405, -0.110664},         {10, 10, 100, none, 1.836785, 0.556215},
           {10, 10, 10000, none, 1.795393, 0.548194}}) {
    CAPTURE(row.n);
    CAPTURE(row.k);
    CAPTURE(row.x);
    const MieEfficiencies q = MieSphere(row.x, {row.n, row.k}).efficiencies();
    // Six printed decimals of a single-precision program: one unit of the last.
    if (!std::isnan(row.extinction)) CHECK(std::abs(q.extinction - row.extinction) <= 1.1e-6);
    CHECK(std::abs(q.scattering - row.scattering) <= 1.1e-6);
    CHECK(std::abs(q.asymmetry - row.asymmetry) <= 1.1e-6);
  }
}

TEST_CASE("S18 Mie: Wiscombe's amplitudes for x = 1, index 1.5 + i, every 30 degrees") {
  const double printed[7][4] = {{0.584080, 0.190515, 0.584080, 0.190515},   {0.565702, 0.187200, 0.500161, 0.145611},
                                {0.517525, 0.178443, 0.287964, 0.041054},   {0.456340, 0.167167, 0.0362285, -0.0618265},
                                {0.400212, 0.156643, -0.174875, -0.122959}, {0.362157, 0.149391, -0.305682, -0.143846},
                                {0.348844, 0.146829, -0.348844, -0.146829}};
  const MieSphere sphere(1, {1.5, 1});
  for (int i = 0; i < 7; ++i) {
    const MieAmplitudes s = mie_amplitudes(sphere, std::cos(i * kPi / 6));
    // His fields go as exp(+i omega t): the conjugates of ours.
    CHECK(std::abs(std::conj(s.s1) - Complex(printed[i][0], printed[i][1])) <= 1.1e-6);
    CHECK(std::abs(std::conj(s.s2) - Complex(printed[i][2], printed[i][3])) <= 1.1e-6);
  }
}

TEST_CASE("S18 Mie: the same series in 60 to 160 digits, size parameters 1e-4 to 1e5, from clear to metal") {
  struct Row {
    double n, k, x, extinction, scattering, absorption, backscatter, asymmetry;
  };
  for (const Row& row : std::initializer_list<Row>{
#include "tests/oracle/mie_reference.inc"
       }) {
    CAPTURE(row.n);
    CAPTURE(row.k);
    CAPTURE(row.x);
    const MieEfficiencies q = MieSphere(row.x, {row.n, row.k}).efficiencies();
    // Rounding: the argument itself is known to 1e-16, and phases of n terms shift by x 1e-16; a clear sphere's
    // resonances and an index near 1 multiply that.
    const double noise = 1e-12 + 2e-16 * row.x + 4e-16 / std::abs(Complex(row.n - 1, row.k));
    CHECK(relative(q.extinction, row.extinction) <= 10 * noise);
    CHECK(relative(q.scattering, row.scattering) <= 10 * noise);
    CHECK(std::abs(q.asymmetry - row.asymmetry) <= 10 * noise);
    CHECK(relative(q.backscatter, row.backscatter) <= 10 * noise);
    if (row.k > 0)
      CHECK(relative(q.absorption, row.absorption) <= 10 * noise);
    else
      CHECK(q.absorption == 0);
  }
}

TEST_CASE("S18 Mie: small spheres scatter as Rayleigh's formula says, also with weak and strong absorption") {
  for (Complex m : {Complex(1.33, 0), Complex(1.33, 1e-9), Complex(1.5, 0.5), Complex(3, 5)})
    for (double x : {1e-5, 1e-4, 1e-3, 1e-2}) {
      CAPTURE(x);
      CAPTURE(m.imag());
      const Complex polarizability = (m * m - 1.0) / (m * m + 2.0);
      const MieEfficiencies q = MieSphere(x, m).efficiencies();
      // The next term of the series is of order (|m| x)^2 (Bohren & Huffman eq. 5.4).
      const double next = 2 * std::norm(m) * x * x + 1e-13;
      CHECK(relative(q.scattering, 8.0 / 3 * std::pow(x, 4) * std::norm(polarizability)) <= next);
      CHECK(relative(q.backscatter, 4 * std::pow(x, 4) * std::norm(polarizability)) <= next);
      CHECK(std::abs(q.asymmetry) <= next);
      if (m.imag() > 0) CHECK(relative(q.absorption, 4 * x * polarizability.imag()) <= next);
      CHECK(mie_phase(MieSphere(x, m), 0.5) == doctest::Approx(0.75 * 1.25).epsilon(3 * next));
    }
}

TEST_CASE("S18 Mie: large spheres remove twice their area (extinction paradox) and mirror at 180 degrees") {
  for (double x : {1e3, 1e4, 1e5})
    for (Complex m : {Complex(1.5, 1), Complex(1.33, 0.3), Complex(10, 10)}) {
      CAPTURE(x);
      const MieEfficiencies q = MieSphere(x, m).efficiencies();
      // Nussenzveig & Wiscombe (1980), Phys. Rev. Lett. 45, 1490, opaque spheres: edge terms; the next is of order
      // x^(-5/3) and grows with the index.
      const double edge = 2 + 1.9923861 * std::pow(x, -2.0 / 3) +
                          2 / x * ((m * m + 1.0) / std::sqrt(m * m - 1.0)).imag() - 0.7153537 * std::pow(x, -4.0 / 3);
      CHECK(std::abs(q.extinction - edge) <= 3 * std::pow(std::abs(m), 3) * std::pow(x, -5.0 / 3));
      // An opaque sphere reflects its central ray by Fresnel's formula; the curved face adds terms of order 1/x^2.
      CHECK(relative(q.backscatter, std::norm((m - 1.0) / (m + 1.0))) <= 10 / (x * x) + 1e-8);
    }
}

TEST_CASE("S18 Mie: energy, optical theorem, normalisation and moments hold for every sphere") {
  for (Complex m : {Complex(1.33, 0), Complex(1.5, 0.01), Complex(0.8, 0), Complex(1.75, 0.44), Complex(10, 10)})
    for (double x : {1e-4, 0.05, 1.0, 7.3, 60.0, 700.0}) {
      CAPTURE(x);
      CAPTURE(m.real());
      const MieSphere sphere(x, m);
      const MieEfficiencies& q = sphere.efficiencies();
      CHECK(q.scattering > 0);
      CHECK(q.scattering <= q.extinction);
      if (m.imag() == 0) CHECK(q.scattering == q.extinction);
      const MieAmplitudes ahead = mie_amplitudes(sphere, 1), behind = mie_amplitudes(sphere, -1);
      CHECK(std::abs(ahead.s1 - ahead.s2) <= 1e-12 * std::abs(ahead.s1));
      // Extinction is absorption plus scattering here, summed without S(0); a clear small sphere's S(0) has next to no
      // real part.
      const double theorem = 4 / (x * x) * ahead.s1.real();
      CHECK(std::abs(theorem - q.extinction) <= 1e-11 * q.extinction + 4 / (x * x) * 1e-14 * std::abs(ahead.s1));
      CHECK(relative(4 / (x * x) * std::norm(behind.s1), q.backscatter) <= 1e-9);
      CHECK(mie_phase(sphere, 1) >= x * x * q.extinction * q.extinction / (4 * q.scattering) * (1 - 1e-10));
      // All moments that are not zero: intensity is a polynomial of degree 2 N in the cosine.
      const std::vector<double> moments = mie_moments(sphere, 2 * sphere.terms());
      CHECK(std::abs(moments[0] - 1) <= 1e-10);
      CHECK(std::abs(moments[1] - q.asymmetry) <= 1e-10);
      for (double cosine : {-1.0, -0.7, 0.0, 0.3, 0.99, 1.0})
        CHECK(std::abs(legendre_series(moments, cosine) - mie_phase(sphere, cosine)) <= 1e-10 * mie_phase(sphere, 1));
    }
}

TEST_CASE("S18 Gauss-Legendre rules integrate even powers exactly and sum to 2, to 4000 nodes") {
  for (std::size_t n : {1u, 2u, 3u, 10u, 101u, 4000u}) {
    const GaussRule rule = gauss_legendre_rule(n);
    for (std::size_t power = 0; power <= std::min<std::size_t>(2 * n - 1, 40); power += 2) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i) sum += rule.weight[i] * std::pow(rule.node[i], static_cast<double>(power));
      CHECK(sum == doctest::Approx(2.0 / (static_cast<double>(power) + 1)).epsilon(1e-12));
    }
    CHECK(std::is_sorted(rule.node.begin(), rule.node.end()));
  }
}

TEST_CASE("S18 Mie: bad figures are refused by name") {
  const auto message = [](double x, Complex m) -> std::string {
    try {
      MieSphere sphere(x, m);
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  CHECK(message(0, 1.5).find("size parameter") != std::string::npos);
  CHECK(message(std::nan(""), 1.5).find("size parameter") != std::string::npos);
  CHECK(message(1, {1.5, -0.1}).find("k >= 0") != std::string::npos);
  CHECK(message(1, 1.0).find("differ from the medium") != std::string::npos);
  CHECK(message(1e5, {1000, 1000}).find("1e7") != std::string::npos);
}
