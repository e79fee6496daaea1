// The solver against closed forms: its numerical parts, pure absorption, the thin limit, black bodies, two
// streams.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/solver/exp_differences.h"
#include "atmos_tables/solver/legendre.h"
#include "atmos_tables/solver/path_integrals.h"
#include "atmos_tables/solver/quadrature.h"
#include "tests/support/solver_cases.h"

using namespace raycube::atmos::solver;
using namespace raycube::test;

namespace {
constexpr double kPi = std::numbers::pi;

Column slab(double depth, double albedo, const std::vector<double>& moments, const Beam& beam) {
  Column column;
  column.layers = {{depth, albedo, moments}};
  column.beam = beam;
  return column;
}
}  // namespace

TEST_CASE("S18 half-range Gauss nodes integrate x^p on [0, 1] exactly up to degree 2 n - 1") {
  for (int count : {1, 2, 8, 24, 64}) {
    const HalfRange rule = gauss_half_range(count);
    for (int power = 0; power < 2 * count; ++power) {
      double sum = 0;
      for (std::size_t i = 0; i < rule.cosine.size(); ++i) sum += rule.weight[i] * std::pow(rule.cosine[i], power);
      CHECK(sum == doctest::Approx(1.0 / (power + 1)).epsilon(1e-13));
    }
  }
}

TEST_CASE("S18 Legendre functions: closed forms of low degree and the addition theorem") {
  const double x = 0.3, s = std::sqrt(1 - x * x);
  CHECK(normalized_legendre(0, 4, x)[3] == doctest::Approx(0.5 * (5 * x * x * x - 3 * x)).epsilon(1e-14));
  CHECK(normalized_legendre(1, 3, x)[0] == doctest::Approx(s / std::sqrt(2)).epsilon(1e-14));
  CHECK(normalized_legendre(2, 3, x)[0] == doctest::Approx(3 * s * s / std::sqrt(24)).epsilon(1e-14));
  // P_l(cos angle) = sum over m of (2 - delta) Lambda(x) Lambda(y) cos(m phi)
  const double y = -0.7, phi = 1.1, cosine = x * y + s * std::sqrt(1 - y * y) * std::cos(phi);
  std::vector<double> only(61, 0.0);
  only[60] = 1 / 121.0;
  double sum = 0;
  for (int m = 0; m <= 60; ++m)
    sum += (m == 0 ? 1 : 2) * normalized_legendre(m, 61, x).back() * normalized_legendre(m, 61, y).back() *
           std::cos(m * phi);
  CHECK(sum == doctest::Approx(legendre_series(only, 61, cosine)).epsilon(1e-12));
}

TEST_CASE("S18 divided differences of exp: plain formulas where they hold, limits where points meet") {
  CHECK(exp_difference(1, 3) == doctest::Approx((std::exp(-1.0) - std::exp(-3.0)) / 2).epsilon(1e-14));
  CHECK(exp_difference(2, 2) == doctest::Approx(std::exp(-2.0)).epsilon(1e-15));
  CHECK(exp_difference(0, 1e9) == doctest::Approx(1e-9).epsilon(1e-14));
  const auto plain = [](double x, double y, double z) {
    return std::exp(-x) / ((y - x) * (z - x)) + std::exp(-y) / ((x - y) * (z - y)) + std::exp(-z) / ((x - z) * (y - z));
  };
  CHECK(exp_difference(0.5, 2, 7) == doctest::Approx(plain(0.5, 2, 7)).epsilon(1e-13));
  CHECK(exp_difference(7, 0.5, 2) == doctest::Approx(plain(0.5, 2, 7)).epsilon(1e-13));
  CHECK(exp_difference(1.3, 1.3, 1.3) == doctest::Approx(std::exp(-1.3) / 2).epsilon(1e-14));
  CHECK(exp_difference(1, 1, 2) == doctest::Approx(std::exp(-2.0)).epsilon(1e-14));  // (e^-1 - (e^-1 - e^-2)) / 1
  // Both branches agree across their border.
  for (double q : {0.299999999, 0.300000001}) {
    const double exact = (exp_mean(0.1) - exp_difference(0.1, q)) / q;
    CHECK(exp_difference(0, 0.1, q) == doctest::Approx(exact).epsilon(1e-13));
  }
}

TEST_CASE("S18 integrals along the line of sight equal their midpoint sums") {
  for (bool up : {true, false})
    for (double near : {0.0, 0.8, 2.0}) {
      const Sight sight{0.37, up, 2.0, near};
      const double low = up ? near : 0, high = up ? 2.0 : near;
      const int steps = 20000;
      double falling = 0, rising = 0, difference = 0, equal = 0, linear = 0, constant = 0;
      for (int i = 0; i < steps; ++i) {
        const double u = low + (high - low) * (i + 0.5) / steps;
        const double weight = std::exp(-std::abs(u - near) / 0.37) / 0.37 * (high - low) / steps;
        falling += weight * std::exp(-1.7 * u);
        rising += weight * std::exp(-1.7 * (2 - u));
        difference += weight * (std::exp(-1.7 * u) - std::exp(-2.2 * u)) / 0.5;
        equal += weight * u * std::exp(-1.7 * u);
        linear += weight * u;
        constant += weight;
      }
      // Midpoint rule: (2/20000 / 0.37)^2 / 24 of the integral, below 4e-9.
      CHECK(sight_falling(sight, 1.7) == doctest::Approx(falling).epsilon(1e-8));
      CHECK(sight_rising(sight, 1.7) == doctest::Approx(rising).epsilon(1e-8));
      CHECK(sight_difference(sight, 1.7, 2.2) == doctest::Approx(difference).epsilon(1e-8));
      CHECK(sight_difference(sight, 1.7, 1.7) == doctest::Approx(equal).epsilon(1e-8));
      CHECK(sight_linear(sight) == doctest::Approx(linear).epsilon(1e-8));
      CHECK(sight_constant(sight) == doctest::Approx(constant).epsilon(1e-8));
    }
}

TEST_CASE("S18 A-03 pure absorption: Beer's law for beam and ground, no diffuse light") {
  const ColumnSolution solution = solve_column(slab(0.9, 0, {}, {100, 0.4, 0}));
  const Ground ground{0.5, 0};
  const double at_ground = 40 * std::exp(-0.9 / 0.4);
  CHECK(solution.fluxes(0.9, ground).direct_down == doctest::Approx(at_ground).epsilon(1e-14));
  CHECK(std::abs(solution.fluxes(0.9, ground).diffuse_down) < 1e-12);
  CHECK(solution.radiance(0, 0.7, 20, ground) ==
        doctest::Approx(0.5 * at_ground / kPi * std::exp(-0.9 / 0.7)).epsilon(1e-12));
  CHECK(std::abs(solution.path_radiance(0, 0.7, 20)) < 1e-13);
  CHECK(solution.ground_transmission(0.2, 0.7).direct == doctest::Approx(std::exp(-1.0)).epsilon(1e-14));
  CHECK(std::abs(solution.ground_transmission(0.2, 0.7).diffuse) < 1e-13);
  CHECK(std::abs(solution.ground_coupling().spherical_albedo) < 1e-13);
}

TEST_CASE("S18 A-03 pure absorption: emission linear in depth has its closed form") {
  Column column = slab(1.5, 0, {}, {});
  column.planck = {2, 5};
  const ColumnSolution solution = solve_column(column);
  const double mu = 0.6, fade = std::exp(-1.5 / mu), slope = 2.0;
  CHECK(solution.radiance(0, mu, 0, {}) == doctest::Approx(2 + slope * mu - (5 + slope * mu) * fade).epsilon(1e-12));
  CHECK(solution.radiance(1.5, -mu, 0, {}) == doctest::Approx(5 - slope * mu - (2 - slope * mu) * fade).epsilon(1e-12));
}

TEST_CASE("S18 A-03 an isothermal cavity is a black body at every place and direction, whatever scatters in it") {
  Column column;
  column.layers = {{0.3, 0.9, henyey_greenstein_moments(0.7, 60)},
                   {2, 0.5, rayleigh_moments()},
                   {40, 0.999999, {}},
                   {1e-7, 0.2, {}}};
  column.planck.assign(5, 3.0);
  column.top_radiance = 3;
  const ColumnSolution solution = solve_column(column);
  const Ground ground{0.35, 3};
  for (double depth : {0.0, 0.1, 0.3, 1.7, 20.0, 42.3, 42.3000001})
    for (double mu : {-1.0, -0.4, -0.01, 0.02, 0.5, 1.0}) {
      CAPTURE(depth);
      CAPTURE(mu);
      CHECK(solution.radiance(depth, mu, 0, ground) == doctest::Approx(3).epsilon(1e-10));
    }
  CHECK(solution.fluxes(1, ground).up == doctest::Approx(3 * kPi).epsilon(1e-10));
  CHECK(std::abs(solution.fluxes(1, ground).net_down()) < 1e-10);
}

TEST_CASE("S18 A-01 a thin conservative layer scatters once") {
  // Second order is of relative size tau / mu: 1e-5 for tau 1e-7 and cosines above 0.05.
  const double depth = 1e-7, mu0 = 0.45, mu = 0.7;
  const std::vector<double> moments = henyey_greenstein_moments(0.6, 80);
  const ColumnSolution solution = solve_column(slab(depth, 1, moments, {2, mu0, 30}));
  const auto phase = [](double cosine) { return (1 - 0.36) / std::pow(1 + 0.36 - 1.2 * cosine, 1.5); };
  const double sines = std::sqrt((1 - mu * mu) * (1 - mu0 * mu0)), turn = std::cos(50 * kPi / 180);
  const double unit = 2 / (4 * kPi) * depth / mu;
  CHECK(solution.radiance(0, mu, 80, {}) == doctest::Approx(unit * phase(-mu * mu0 + sines * turn)).epsilon(1e-5));
  CHECK(solution.radiance(depth, -mu, 80, {}) == doctest::Approx(unit * phase(mu * mu0 + sines * turn)).epsilon(1e-5));
}

TEST_CASE("S18 A-01 two streams: closed forms of the conservative slab and of the half-space") {
  Options options;
  options.streams = 2;
  options.delta_m = false;
  for (double g : {0.0, 0.8, -0.5})
    for (double depth : {1e-6, 0.5, 30.0, 700.0}) {
      // One node at mu = 1/2: transmission of isotropic light 1 / (1 + (1 - 3/4 g) tau).
      Column column = slab(depth, 1, {1, g}, {});
      column.top_radiance = 1;
      const double transmission = 1 / (1 + (1 - 0.75 * g) * depth);
      const ColumnSolution solution = solve_column(column, options);
      CHECK(solution.fluxes(depth, {}).diffuse_down == doctest::Approx(kPi * transmission).epsilon(1e-11));
      CHECK(solution.fluxes(0, {}).up == doctest::Approx(kPi * (1 - transmission)).epsilon(1e-9));
      CHECK(solution.ground_coupling().spherical_albedo == doctest::Approx(1 - transmission).epsilon(1e-9));
    }
  for (double albedo : {0.3, 0.99}) {
    Column column = slab(700, albedo, {}, {});
    column.top_radiance = 1;
    const double root = std::sqrt(1 - albedo);
    CHECK(solve_column(column, options).fluxes(0, {}).up ==
          doctest::Approx(kPi * (1 - root) / (1 + root)).epsilon(1e-12));
  }
}
