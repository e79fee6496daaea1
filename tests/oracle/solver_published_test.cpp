// The solver against published radiances and fluxes: DISORT problems 1 to 9 (van de Hulst 1980, Sweigart
// 1970, Garcia & Siewert 1985, Kylling & Stamnes 1992, Ozisik & Shouman 1980, Devaux et al. 1979).
// Tolerances: AIR 8, A-01 to A-04.
#include <doctest/doctest.h>

#include <cmath>
#include <iostream>

#include "tests/support/solver_cases.h"

using namespace raycube::atmos::solver;
using namespace raycube::test;

namespace {

/// Solves every case of the problems and checks the largest deviations, as parts of the case's largest value.
void compare(const std::string& problems, const char* test, double tolerance) {
  for (const BenchmarkCase& problem : disort_cases(problems, test)) {
    CAPTURE(problem.name);
    Options options;
    options.streams = problem.streams;
    const Deviation worst = disort_deviation(problem, solve_column(problem.column, options));
    std::cout << test << " case " << problem.name << ": flux " << worst.flux << " (" << worst.fluxes << "), radiance "
              << worst.radiance << " (" << worst.radiances << ") of the largest; allowed " << tolerance << "\n";
    CHECK(worst.fluxes > 0);
    CHECK(worst.flux <= tolerance);
    CHECK(worst.radiance <= tolerance);
  }
}

}  // namespace

TEST_CASE("S18 A-01 isotropic, Rayleigh and Henyey-Greenstein slabs: published tables to 1e-4") {
  compare("123", "A-01", 1e-4);
}

TEST_CASE("S18 A-02 Haze-L and Cloud C.1: published tables to 1e-3") { compare("45", "A-02", 1e-3); }

TEST_CASE("S18 A-03 beam alone, Lambertian ground, thermal sources: published tables to 1e-4") {
  compare("67", "A-03", 1e-4);
}

TEST_CASE("S18 A-04 inhomogeneous layers: published tables to 1e-4") { compare("89", "A-04", 1e-4); }

TEST_CASE("S18 A-01 four published slabs, restated") {
  // van de Hulst (1980) tables 12 and 37, Sweigart (1970) table 1: {depth, albedo, moments, mu0, flux,
  // diffuse down, up, up at zenith}.
  struct Slab {
    double depth, albedo;
    std::vector<double> moments;
    double mu0, flux, diffuse_down, up, zenith;
  };
  const double pi = 3.14159265358979;
  const Slab slabs[] = {
      {0.03125, 1, {1}, 0.1, 10 * pi, 0.420233, 0.422922, 0.0709192},
      {32, 1, {1}, 0.1, 10 * pi, 0.0676954, 3.0739, 0.797199},
      {5, 1, rayleigh_moments(), 0.080442, pi, 0.0268008, 0.225915, -1},
      {8, 1, henyey_greenstein_moments(0.75, 300), 1, pi, 1.54958, 1.59096, -1},
  };
  for (const Slab& slab : slabs) {
    CAPTURE(slab.depth);
    Column column;
    column.layers = {{slab.depth, slab.albedo, slab.moments}};
    column.beam = {slab.flux, slab.mu0, 0};
    const ColumnSolution solution = solve_column(column);
    CHECK(solution.fluxes(slab.depth, {}).diffuse_down == doctest::Approx(slab.diffuse_down).epsilon(1e-4));
    CHECK(solution.fluxes(0, {}).up == doctest::Approx(slab.up).epsilon(1e-4));
    if (slab.zenith >= 0) CHECK(solution.radiance(0, 1, 0, {}) == doctest::Approx(slab.zenith).epsilon(1e-4));
  }
}
