// The Voigt profile. Oracles: w to 40 digits by mpmath (exp(-z^2) erfc(-iz), restated), the Gaussian's and the
// Lorentzian's closed forms, area, and the fold of both by quadrature.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/lines/voigt.h"
#include "tests/support/relative.h"

using namespace raycube::atmos;
using raycube::test::relative;

namespace {
constexpr double kPi = std::numbers::pi;
}  // namespace

TEST_CASE("AIR 9 Voigt: Re w against 40 digits, every rule and their joints") {
  struct Case {
    double x, y, w;
  };
  const Case cases[] = {
      {0, 0.001, 0.99887262008115141},        {0, 1, 0.427583576155807},
      {0, 30, 0.018795888861416751},          {0.0001, 1e-07, 0.9999998771620956},
      {0.2, 0.3, 0.7138010529836519},         {0.256, 1e-09, 0.93656532881407762},
      {0.5, 0.1, 0.71758774215759441},        {1, 1, 0.30474420525691259},
      {1.28, 0.01, 0.19707322760722712},      {2, 0.001, 0.018547236370405553},
      {3, 0.5, 0.037126366054692345},         {3.8, 1e-06, 5.7963328777391902e-7},
      {5, 0.0001, 2.4080590081883778e-6},     {5.4, 2, 0.035388480247200284},
      {6.1, 1e-10, 1.5819701230682708e-12},   {6.28, 4e-06, 5.9550592428455274e-8},
      {7.9, 0.01, 9.2665396146907359e-5},     {8.1, 1e-08, 8.8036575266634788e-11},
      {5, 6.5, 0.054717547606310835},         {9.5, 3, 0.017284565097299618},
      {14.9, 1e-05, 2.5586465451899092e-8},   {15.1, 0.2, 0.00049808459935474281},
      {40, 25, 0.0063418824371397359},        {60, 1e-06, 1.5678467387475419e-10},
      {99, 1, 5.7567428254578186e-5},         {150, 0.001, 2.5076764459618273e-8},
      {900, 40, 2.7806339258051113e-5},       {2000, 0.01, 1.410474487762194e-9},
      {30000, 1e-08, 6.2687731609785808e-18}, {100000, 100000, 2.8209479178093051e-6},
  };
  double near = 0, far = 0;
  for (const Case& c : cases) {
    const double error = relative(faddeeva_real(c.x, c.y), c.w);
    (std::hypot(c.x, c.y) < 8 ? near : far) = std::max(std::hypot(c.x, c.y) < 8 ? near : far, error);
    CHECK(faddeeva_real(-c.x, c.y) == faddeeva_real(c.x, c.y));
  }
  MESSAGE("relative error: " << near << " within 8 of the origin, " << far << " beyond");
  CHECK(near <= 3e-14);
  CHECK(far <= 5e-11);
}

TEST_CASE("AIR 9 Voigt: rules agree where one hands over to the next, on circles of 8, 15, 100 and 1000") {
  double worst = 0;
  for (double radius : {8.0, 15.0, 100.0, 1000.0})
    for (double angle : {1e-7, 1e-3, 0.2, 0.5, 0.9, 1.2, 1.5, 1.57}) {
      const double inside =
          faddeeva_real(radius * (1 - 1e-13) * std::cos(angle), radius * (1 - 1e-13) * std::sin(angle));
      const double outside =
          faddeeva_real(radius * (1 + 1e-13) * std::cos(angle), radius * (1 + 1e-13) * std::sin(angle));
      worst = std::max(worst, relative(inside, outside));
    }
  CHECK(worst <= 5e-11);
}

TEST_CASE("AIR 9 Voigt: Gaussian without collisions, Lorentzian without motion, half values at the half widths") {
  const double doppler = 0.005;
  const VoigtProfile gauss(doppler, 0);
  for (double offset : {0.0, 0.001, 0.005, 0.01, 0.02}) {
    const double truth = std::sqrt(std::numbers::ln2 / kPi) / doppler *
                         std::exp(-std::numbers::ln2 * offset * offset / (doppler * doppler));
    CHECK(relative(gauss(offset), truth) <= 1e-12);
  }
  CHECK(relative(gauss(doppler), 0.5 * gauss(0)) <= 1e-12);
  const double lorentz = 0.07;
  const VoigtProfile collisions(1e-9, lorentz);
  for (double offset : {0.0, 0.01, 0.07, 1.0, 25.0}) {
    const double truth = lorentz / kPi / (offset * offset + lorentz * lorentz);
    // The Gaussian's second moment is left: (Doppler / Lorentz)^2 = 2e-16.
    CHECK(relative(collisions(offset), truth) <= 1e-10);
  }
}

TEST_CASE("AIR 9 Voigt: area 1 and the fold by quadrature") {
  for (double ratio : {1e-3, 0.1, 1.0, 10.0}) {
    const double doppler = 0.01, lorentz = ratio * doppler;
    const VoigtProfile voigt(doppler, lorentz);
    // offset = width tan(t) spreads the whole axis over -pi/2..pi/2; the rule is even and the integrand smooth.
    const double width = doppler + lorentz;
    const int points = 20000;
    double area = 0;
    for (int i = 0; i < points; ++i) {
      const double t = kPi * ((i + 0.5) / points - 0.5), cosine = std::cos(t);
      area += voigt(width * std::tan(t)) * width / (cosine * cosine) * kPi / points;
    }
    CHECK(std::abs(area - 1) <= 1e-10);
    if (ratio < 0.1) continue;
    for (double offset : {0.0, 0.003, 0.015, 0.08}) {
      // Lorentzian at offset - u under the Gaussian's weight, trapezoidal rule: exact to exp(-2 pi lorentz / step).
      const double step = lorentz / 8 < doppler / 8 ? lorentz / 8 : doppler / 8, reach = 8 * doppler;
      double sum = 0;
      for (double u = -reach; u <= reach; u += step)
        sum += step * std::sqrt(std::numbers::ln2 / kPi) / doppler *
               std::exp(-std::numbers::ln2 * u * u / (doppler * doppler)) * lorentz / kPi /
               ((offset - u) * (offset - u) + lorentz * lorentz);
      CHECK(relative(voigt(offset), sum) <= 1e-11);
    }
  }
}

TEST_CASE("AIR 9 Voigt: Doppler half width is v0 3.5812e-7 sqrt(T / M)") {
  CHECK(relative(doppler_half_width_per_cm(3057.7, 296, 16.0313), 3057.7 * 3.5812e-7 * std::sqrt(296 / 16.0313)) <=
        2e-5);
}
