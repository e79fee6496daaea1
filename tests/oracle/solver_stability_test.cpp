// Points where naive discrete ordinates break: every one is solved, none aborts. Oracle: continuity, and laws
// that stay exact.
#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "atmos_tables/solver/quadrature.h"
#include "host/base/error.h"
#include "tests/support/solver_cases.h"

using namespace raycube::atmos::solver;
using namespace raycube::test;

namespace {
constexpr double kPi = std::numbers::pi;

double reflected(double depth, double albedo, double mu0, double mu) {
  Column column;
  column.layers = {{depth, albedo, henyey_greenstein_moments(0.7, 100)}};
  column.beam = {1, mu0, 0};
  return solve_column(column).radiance(0, mu, 30, {});
}
}  // namespace

TEST_CASE("S18 A-08 the beam at each node of 16 streams is an ordinary direction") {
  // Continuous to second order: the mean of two neighbours 1e-5 away differs by f''/2 (1e-5)^2, below 1e-7
  // for f'' < 1e3.
  for (double mu0 : gauss_half_range(8).cosine) {
    const double step = 1e-5 * mu0;
    const double mean = 0.5 * (reflected(1, 0.95, mu0 - step, 0.6) + reflected(1, 0.95, mu0 + step, 0.6));
    CHECK(reflected(1, 0.95, mu0, 0.6) == doctest::Approx(mean).epsilon(1e-7));
    // View at the node, beam at the node.
    CHECK(reflected(1, 0.95, mu0, mu0) ==
          doctest::Approx(0.5 * (reflected(1, 0.95, mu0, mu0 - step) + reflected(1, 0.95, mu0, mu0 + step)))
              .epsilon(1e-7));
  }
}

TEST_CASE("S18 A-08 the beam at an eigenvalue is an ordinary direction") {
  // Two streams, isotropic scattering: k = 2 sqrt(1 - omega), so mu0 = 1/k for omega = 1 - 1/(2 mu0)^2.
  Options options;
  options.streams = 2;
  for (double mu0 : {0.7, 0.95}) {
    const auto up = [&options](double cosine, double albedo) {
      Column column;
      column.layers = {{2, albedo, {}}};
      column.beam = {1, cosine, 0};
      return solve_column(column, options).fluxes(0, {}).up;
    };
    const double albedo = 1 - 1 / (4 * mu0 * mu0), exact = up(mu0, albedo);
    CHECK(exact > 0);
    for (double step : {1e-3, 1e-6, 1e-9, 1e-12, 1e-15}) {
      const double mean = 0.5 * (up(mu0 - step, albedo) + up(mu0 + step, albedo));
      CAPTURE(step);
      CHECK(exact == doctest::Approx(mean).epsilon(1e-12 + 10 * step * step));
    }
  }
}

TEST_CASE("S18 A-08 cos 30 degrees with 64 streams, where a node lies") {
  Column column;
  column.layers = {{0.5, 1, rayleigh_moments()}};
  Options options;
  options.streams = 64;
  column.beam = {1, std::cos(kPi / 6), 0};
  const ColumnSolution solution = solve_column(column, options);
  CHECK(std::abs(solution.fluxes(0, {}).net_down() - solution.fluxes(0.5, {}).net_down()) <= 1e-8);
}

TEST_CASE("S18 A-08 albedo 1 is the limit of albedo near 1") {
  for (double depth : {0.5, 30.0})
    for (double below : {1e-16, 1e-14, 1e-12, 1e-10}) {
      CAPTURE(below);
      CAPTURE(depth);
      // Absorbed part: of order depth^2 (1 - omega).
      const double allowed = 1e-9 + 10 * depth * depth * below;
      CHECK(reflected(depth, 1 - below, 0.6, 0.4) == doctest::Approx(reflected(depth, 1, 0.6, 0.4)).epsilon(allowed));
    }
  // Sums of optical depths may end a digit above 1.
  CHECK(reflected(1, 1 + 1e-12, 0.6, 0.4) == doctest::Approx(reflected(1, 1, 0.6, 0.4)).epsilon(1e-12));
}

TEST_CASE("S18 A-08 no layers, layers without depth") {
  for (std::size_t layers : {std::size_t{0}, std::size_t{1}, std::size_t{3}}) {
    Column column;
    column.layers.assign(layers, {0, 0.5, rayleigh_moments()});
    column.beam = {10, 0.5, 0};
    column.top_radiance = 2;
    const ColumnSolution solution = solve_column(column);
    const Ground ground{0.25, 8};
    const double from_ground = 0.25 * (5 / kPi + 2) + 0.75 * 8;
    CHECK(solution.radiance(0, 0.3, 0, ground) == doctest::Approx(from_ground).epsilon(1e-13));
    CHECK(solution.radiance(0, -0.3, 0, ground) == doctest::Approx(2).epsilon(1e-13));
    CHECK(solution.fluxes(0, ground).direct_down == doctest::Approx(5).epsilon(1e-14));
    CHECK(solution.fluxes(0, ground).diffuse_down == doctest::Approx(2 * kPi).epsilon(1e-13));
    CHECK(solution.fluxes(0, ground).up == doctest::Approx(kPi * from_ground).epsilon(1e-13));
    CHECK(solution.ground_transmission(0, 0.3).direct == 1);
    CHECK(std::abs(solution.ground_coupling().spherical_albedo) < 1e-14);
  }
}

TEST_CASE("S18 A-08 optical depth 700 and beyond: finite, positive, energy kept") {
  for (double depth : {700.0, 1e5})
    for (double albedo : {0.0, 0.5, 1 - 1e-12, 1.0}) {
      Column column;
      column.layers = {
          {depth, albedo, henyey_greenstein_moments(0.85, 300)}, {0, 1, {}}, {depth, albedo, rayleigh_moments()}};
      column.beam = {1, 0.02, 0};
      column.planck = {1, 1, 1, 1};
      const ColumnSolution solution = solve_column(column);
      for (double part : {0.0, 0.1, 0.5, 1.0})
        for (double mu : {-1.0, -1e-12, 0.0, 1e-3, 1.0}) {
          CAPTURE(depth);
          CAPTURE(albedo);
          CAPTURE(part);
          CAPTURE(mu);
          const double value = solution.radiance(part * solution.total_depth(), mu, 90, {0.5, 1});
          CHECK(std::isfinite(value));
          CHECK(value >= -1e-12);
          CHECK(value <= 2);
        }
      if (albedo == 1) CHECK(std::abs(solution.fluxes(0, {1, 0}).net_down()) <= 1e-8 * 0.02);
    }
}

TEST_CASE("S18 A-02 a phase function that is all forward peak is no scattering") {
  Column column;
  column.layers = {{2, 0.7, std::vector<double>(40, 1.0)}};
  column.beam = {1, 0.5, 0};
  Options options;
  options.intensity_correction = false;
  const ColumnSolution solution = solve_column(column, options);
  const Fluxes ground = solution.fluxes(2, {});
  CHECK(ground.direct_down + ground.diffuse_down == doctest::Approx(0.5 * std::exp(-0.6 / 0.5)).epsilon(1e-12));
  CHECK(std::abs(solution.fluxes(0, {}).up) < 1e-14);
}

TEST_CASE("S18 the pseudo-spherical beam: plane for a huge planet, Chapman's geometry for the Earth") {
  Column column;
  column.layers = {{0.1, 0.9, rayleigh_moments()}, {0.3, 0.9, rayleigh_moments()}};
  column.beam = {1, 0.2, 0};
  const double plane = solve_column(column).fluxes(0.4, {}).direct_down;
  column.level_height_m = {20e3, 5e3, 0};
  column.planet_radius_m = 1e12;
  CHECK(solve_column(column).fluxes(0.4, {}).direct_down == doctest::Approx(plane).epsilon(1e-6));
  column.planet_radius_m = 6371e3;
  // Chords of the two shells by Pythagoras from the ground.
  const double radius = 6371e3, foot = radius * 0.2, impact2 = radius * radius * 0.96;
  const double low = std::sqrt(6376e3 * 6376e3 - impact2) - foot,
               high = std::sqrt(6391e3 * 6391e3 - impact2) - foot - low;
  CHECK(solve_column(column).fluxes(0.4, {}).direct_down ==
        doctest::Approx(0.2 * std::exp(-0.1 * high / 15e3 - 0.3 * low / 5e3)).epsilon(1e-9));
  // Low sun over a thick layer with a thin one below: the slant depth falls with depth.
  column.layers = {{3, 0.9, rayleigh_moments()}, {1e-6, 0.9, rayleigh_moments()}};
  column.beam.cosine = 1e-4;
  const double value = solve_column(column).radiance(3, -0.5, 0, {});
  CHECK(std::isfinite(value));
  CHECK(value >= 0);
}

TEST_CASE("S18 a wrong column is refused with every fault named") {
  Column column;
  column.layers = {{-1, 1.5, {0.5, 2}}, {std::numeric_limits<double>::quiet_NaN(), 0.5, {}}};
  column.beam.cosine = 0;
  column.planck = {1};
  try {
    solve_column(column, {.streams = 7});
    FAIL("accepted");
  } catch (const raycube::base::Error& error) {
    const std::string text = error.what();
    CHECK(error.exit_status() == 2);
    for (const char* part : {"layer 0", "layer 1", "optical depth", "single-scattering albedo", "phase moment 0",
                             "[-1, 1]", "beam cosine", "Planck", "streams"})
      CHECK_MESSAGE(text.find(part) != std::string::npos, part);
  }
  column.layers = {{1, 0.5, {}}};
  column.beam.cosine = 0.5;
  column.planck.clear();
  const ColumnSolution solution = solve_column(column);
  CHECK_THROWS_AS(solution.fluxes(1.1, {}), raycube::base::Error);
  CHECK_THROWS_AS(solution.radiance(0.5, 1.1, 0, {}), raycube::base::Error);
  CHECK_THROWS_AS(solution.fluxes(0.5, {1.2, 0}), raycube::base::Error);
  CHECK_THROWS_AS(solution.level_depth(2), raycube::base::Error);
}
