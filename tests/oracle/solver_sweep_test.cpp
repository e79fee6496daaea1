// Many directions at once: the same answers as one by one; and the small matrices and integrals beneath.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>

#include "atmos_tables/solver/exp_differences.h"
#include "atmos_tables/solver/small_dense.h"
#include "tests/support/solver_cases.h"

using namespace raycube::atmos::solver;
using namespace raycube::test;

namespace {

/// Air, haze, an absorber without scattering, an empty layer, cloud and air that hardly exists.
Column many_layers(double mu0, bool emits) {
  Column column;
  column.layers = {{1e-8, 1, rayleigh_moments(0.029)},
                   {3e-4, 1, rayleigh_moments(0.029)},
                   {0.02, 0.97, henyey_greenstein_moments(0.7, 120)},
                   {0.4, 0, {}},
                   {0, 0, {}},
                   {0.09, 1, henyey_greenstein_moments(0.6, 64)},
                   {12, 0.995, henyey_greenstein_moments(0.85, 192)},
                   {0.3, 0.2, {}}};
  column.beam = {mu0 > 0 ? 1.7 : 0.0, mu0 > 0 ? mu0 : 1.0, 25};
  if (emits) column.planck = {0.1, 0.2, 0.25, 0.4, 0.8, 0.9, 1.2, 1.5, 1.6};
  column.top_radiance = emits ? 0.03 : 0;
  return column;
}

double largest(const std::vector<double>& values) {
  double out = 0;
  for (double value : values) out = std::max(out, std::abs(value));
  return out;
}

/// Largest difference of the sweep from single calls, as part of the largest radiance.
double sweep_error(const Column& column, const Options& options) {
  const ColumnSolution solution = solve_column(column, options);
  const double total = solution.total_depth();
  const std::vector<double> depths = {total, 0, 0.5 * total, solution.level_depth(3), 0.41, total - 0.2, total},
                            cosines = {1, -1, 0.7, -0.7, 0.3, -0.3, 0.05, -0.05, -0.0175, -1e-9, 0, 1e-9, -0.62},
                            azimuths = {0, 25, 40, 115, 180, 205, 300};
  const Ground ground{0.3, 0.5};
  const std::vector<double> swept = solution.radiances(depths, cosines, azimuths, ground);
  const std::vector<GroundTransmission> through = solution.ground_transmissions(depths, cosines);
  REQUIRE(swept.size() == depths.size() * cosines.size() * azimuths.size());
  double worst = 0;
  std::size_t i = 0, g = 0;
  for (double depth : depths)
    for (double cosine : cosines) {
      const GroundTransmission alone = solution.ground_transmission(depth, cosine);
      worst =
          std::max({worst, std::abs(alone.direct - through[g].direct), std::abs(alone.diffuse - through[g].diffuse)});
      ++g;
      for (double azimuth : azimuths)
        worst =
            std::max(worst, std::abs(swept[i++] - solution.radiance(depth, cosine, azimuth, ground)) / largest(swept));
    }
  return worst;
}

}  // namespace

TEST_CASE("S4.6 a sweep over levels, directions and azimuths equals single calls to 1e-12") {
  double worst = 0;
  for (int streams : {4, 8, 12, 16, 32})
    for (double mu0 : {0.766, 0.05, 0.0})
      for (bool emits : {false, true}) {
        if (mu0 <= 0 && !emits) continue;
        worst = std::max(worst, sweep_error(many_layers(mu0, emits), {.streams = streams}));
        worst = std::max(worst, sweep_error(many_layers(mu0, emits),
                                            {.streams = streams, .delta_m = false, .intensity_correction = false}));
      }
  Column spherical = many_layers(0.2, false);
  spherical.level_height_m = {60e3, 40e3, 20e3, 12e3, 10e3, 8e3, 3e3, 2e3, 0};
  worst = std::max(worst, sweep_error(spherical, {}));
  spherical.phase_values = [](double cos_angle) { return std::vector<double>(8, 1 + 0.5 * cos_angle); };
  worst = std::max(worst, sweep_error(spherical, {}));
  Column empty;
  empty.beam = {1, 0.5, 0};
  empty.top_radiance = 2;
  const ColumnSolution nothing = solve_column(empty);
  CHECK(nothing.radiances({0, 0}, {-0.5, 0.5}, {0}, {}) == std::vector<double>{2, 0, 2, 0});
  std::cout << "sweep against single calls: " << worst << " of the largest radiance; allowed 1e-12\n";
  CHECK(worst <= 1e-12);
}

TEST_CASE("S4.6 whole layers and parts of layers, by other formulas, give one radiance") {
  // A place 1e-9 of a layer above or below its face is looked at through path_integrals.h, the face itself
  // through the differences of known exponentials. Radiance changes by at most (source / cosine) 1e-9 depth
  // between.
  double worst = 0;
  for (double mu0 : {0.766, 0.05})
    for (int streams : {8, 16}) {
      const Column column = many_layers(mu0, true);
      const ColumnSolution solution = solve_column(column, {.streams = streams});
      const std::vector<double> cosines = {1, -1, 0.3, -0.3, 0.05, -0.05}, azimuths = {25, 115};
      for (std::size_t level = 1; level < column.layers.size(); ++level) {
        const double face = solution.level_depth(level), above = 1e-9 * column.layers[level - 1].optical_depth,
                     below = 1e-9 * column.layers[level].optical_depth;
        const std::vector<double> values =
            solution.radiances({face, face - above, face + below}, cosines, azimuths, {});
        const std::size_t size = cosines.size() * azimuths.size();
        for (std::size_t i = 0; i < size; ++i)
          for (std::size_t side : {1, 2})
            worst = std::max(worst, std::abs(values[side * size + i] - values[i]) / largest(values));
      }
    }
  // The thickest layer has 12 / 0.05 along the flattest ray: 240e-9 of the source.
  std::cout << "faces of layers against places 1e-9 beside them: " << worst << "; allowed 3e-7\n";
  CHECK(worst <= 3e-7);
}

TEST_CASE("differences of known exponentials equal those that find them") {
  const auto close = [](double a, double b) { return std::abs(a - b) <= 2e-14 * std::abs(b) + 1e-300; };
  const std::vector<double> at = {0, 1e-12, 1e-6, 1e-3, 0.03, 0.1, 0.1249, 0.1251, 0.2, 0.5, 1, 1.05, 3, 20, 200, 1e5};
  int wrong = 0;
  for (double x : at)
    for (double y : at) {
      const auto pair = [](double a, double b) { return exp_pair(a, b, std::exp(-a), std::exp(-b)); };
      wrong += close(pair(x, y), exp_difference(x, y)) ? 0 : 1;
      for (double z : at)
        wrong +=
            close(exp_triple({x, y, z}, {std::exp(-x), std::exp(-y), std::exp(-z)}, pair(x, y), pair(x, z), pair(y, z)),
                  exp_difference(x, y, z))
                ? 0
                : 1;
    }
  CHECK(wrong == 0);
}

namespace {
template <int N>
double dense_error(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto fill = [&](auto& matrix) { matrix = matrix.unaryExpr([&](double) { return uniform(random); }).eval(); };
  Square<N> a = Square<N>::Zero(), b = a, out = a, root = a, inverse = a;
  fill(a), fill(b);
  multiply<N>(a, b, out);
  double worst = (out - a * b).cwiseAbs().maxCoeff();
  const Square<N> positive = Square<N>::Identity() + a * a.transpose();
  Square<N> inverted = positive;
  invert_positive<N>(inverted);
  worst = std::max(worst, (inverted * positive - Square<N>::Identity()).cwiseAbs().maxCoeff());
  CHECK(triangular_root<N>(positive, root, inverse));
  worst = std::max({worst, (root * root.transpose() - positive).cwiseAbs().maxCoeff(),
                    (inverse * root - Square<N>::Identity()).cwiseAbs().maxCoeff(),
                    Square<N>(root.template triangularView<Eigen::StrictlyUpper>()).cwiseAbs().maxCoeff()});
  CHECK_FALSE(triangular_root<N>(-positive, root, inverse));
  Eigen::Matrix<double, N, 3> right;
  fill(right);
  a(0, 0) = 0;  // needs a pivot
  Eigen::Matrix<double, N + 3, N> augmented;
  augmented << a.transpose(), right.transpose();
  solve_augmented<N, 3>(augmented);
  const Eigen::Matrix<double, N, 3> answer = augmented.template bottomRows<3>().transpose();
  return std::max(worst, (a * answer - right).cwiseAbs().maxCoeff() / std::max(1.0, answer.cwiseAbs().maxCoeff()));
}
}  // namespace

TEST_CASE("small matrices: products, inverses, roots and solutions are what they claim") {
  std::mt19937 random(7);
  double worst = 0;
  for (int i = 0; i < 50; ++i)
    worst = std::max(
        {worst, dense_error<2>(random), dense_error<4>(random), dense_error<8>(random), dense_error<16>(random)});
  CHECK(worst <= 1e-11);  // condition numbers to a few thousand times 1e-16 times 16
}
