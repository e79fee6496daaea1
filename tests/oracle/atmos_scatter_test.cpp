// Closed forms of the atmosphere's scattering. Oracles: the textbook formulas written plainly, quadrature, published
// figures.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <numbers>

#include "atmos_tables/rayleigh.h"
#include "atmos_tables/single_scatter.h"

using namespace raycube::atmos;

namespace {
constexpr double kPi = std::numbers::pi;

/// Midpoint rule of the layer's integral, the definition itself: int_0^depth exp(-t sun) exp(-s view) view dt.
double by_quadrature(double depth, double sun, double view, bool up) {
  const int steps = 200000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double t = depth * (i + 0.5) / steps;
    sum += std::exp(-t * sun - (up ? t : depth - t) * view);
  }
  return sum * view * depth / steps;
}
}  // namespace

TEST_CASE("S18 single scattering of a slab equals its integral, mu = mu0 and depth 0, 1e-6, 1, 700 included") {
  for (double depth : {0.0, 1e-6, 1.0, 20.0})
    for (double mu0 : {1.0, 0.5, 0.1})
      for (double mu : {1.0, 0.5, 0.50000001, 0.1}) {
        CAPTURE(depth);
        CAPTURE(mu0);
        CAPTURE(mu);
        // Midpoint error of exp(-k t): (k depth / n)^2 / 24, below 4e-8 for k depth = 400 (relative to the integral).
        const double up = by_quadrature(depth, 1 / mu0, 1 / mu, true),
                     down = by_quadrature(depth, 1 / mu0, 1 / mu, false);
        CHECK(std::abs(layer_scatter_up(depth, 1 / mu0, 1 / mu) - up) <= 2e-7 * up);
        CHECK(std::abs(layer_scatter_down(depth, 1 / mu0, 1 / mu) - down) <= 2e-7 * down);
      }
}

TEST_CASE("S18 single scattering of a slab equals the textbook formulas") {
  for (double depth : {0.3, 1.0, 5.0})
    for (double mu0 : {0.9, 0.4}) {
      const double mu = 0.7;
      const double up = mu0 / (mu0 + mu) * (1 - std::exp(-depth * (1 / mu + 1 / mu0)));
      const double down = mu0 / (mu0 - mu) * (std::exp(-depth / mu0) - std::exp(-depth / mu));
      CHECK(layer_scatter_up(depth, 1 / mu0, 1 / mu) == doctest::Approx(up).epsilon(1e-13));
      CHECK(layer_scatter_down(depth, 1 / mu0, 1 / mu) == doctest::Approx(down).epsilon(1e-12));
      CHECK(layer_scatter_down(depth, 1 / mu, 1 / mu) ==
            doctest::Approx(depth / mu * std::exp(-depth / mu)).epsilon(1e-14));
    }
}

TEST_CASE("S18 a slab of depth 700 neither overflows nor goes negative") {
  const double up = layer_scatter_up(700, 2, 1.5), down = layer_scatter_down(700, 2, 1.5);
  CHECK(up == doctest::Approx(1.5 / 3.5).epsilon(1e-14));
  CHECK(down >= 0);
  CHECK(down < 1e-300);
  CHECK(layer_scatter_down(700, 1, 1) == doctest::Approx(700 * std::exp(-700.0)).epsilon(1e-12));
}

TEST_CASE("S18 Rayleigh optical depth at 0.55 um is that of Bodhaine 1999") {
  // Cross-section 4.5105e-27 cm2 times the column 2.152e25 cm-2 of his fit (eq. 30): 0.09707, four digits.
  CHECK(rayleigh_depth(0.55, 1013.25) == doctest::Approx(0.09707).epsilon(2e-4));
  CHECK(rayleigh_depth(0.55, 506.625) == doctest::Approx(0.5 * rayleigh_depth(0.55, 1013.25)));
  // Hansen & Travis (1974), an independent fit; the two agree within 1 % from 0.4 to 1 um.
  for (double l : {0.4, 0.55, 0.7, 1.0}) {
    const double il2 = 1 / (l * l);
    CHECK(rayleigh_depth(l, 1013.25) ==
          doctest::Approx(0.008569 * il2 * il2 * (1 + 0.0113 * il2 + 0.00013 * il2 * il2)).epsilon(0.01));
  }
  // King factor 1.0488 and depolarisation 0.0283 at 0.55 um, 0.0297 at 0.4 um (Bodhaine 1999).
  CHECK(rayleigh_depolarization(0.55) == doctest::Approx(0.0283).epsilon(3e-3));
  CHECK(rayleigh_depolarization(0.40) == doctest::Approx(0.0297).epsilon(3e-3));
}

TEST_CASE("S18 phase functions integrate to 4 pi, HG with mean cosine g") {
  const auto integral = [](auto&& phase, bool times_cosine) {
    const int steps = 200000;
    double sum = 0;
    for (int i = 0; i < steps; ++i) {
      const double c = -1 + 2 * (i + 0.5) / steps;
      sum += phase(c) * (times_cosine ? c : 1);
    }
    return sum * 2 / steps * 2 * kPi;
  };
  const auto rayleigh = [](double c) { return phase_rayleigh(0.0283, c); };
  CHECK(integral(rayleigh, false) == doctest::Approx(4 * kPi).epsilon(1e-8));
  CHECK(std::abs(integral(rayleigh, true)) < 1e-8);
  for (double g : {0.0, 0.65, 0.9}) {
    const auto hg = [g](double c) { return phase_henyey_greenstein(g, c); };
    CHECK(integral(hg, false) == doctest::Approx(4 * kPi).epsilon(1e-6));
    CHECK(integral(hg, true) == doctest::Approx(4 * kPi * g).epsilon(1e-6));
  }
}
