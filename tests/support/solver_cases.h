// Benchmark columns of radiative transfer, read from $RAYCUBE_SHARED/reference/atmosphere/rt_benchmarks, and
// what the tests of the solver share.
#pragma once

#include <string>
#include <vector>

#include "atmos_tables/solver/solution.h"
#include "tests/support/anchor_rows.h"

namespace raycube::test {

/// One row of a CSV file: cell text by column name.
using CsvRow = testing::AnchorCells;

/// Rows of a benchmark file; empty, with a loud note on stderr, where RAYCUBE_SHARED is not set.
std::vector<CsvRow> benchmark(const std::string& file, const std::string& test);

/// The number in a cell; 0 for an empty one.
double number(const CsvRow& row, const std::string& column);

/// Moments chi_k, k < count.
std::vector<double> henyey_greenstein_moments(double asymmetry, int count);
std::vector<double> rayleigh_moments(double depolarization = 0);

/// Planck radiance between two wavenumbers (cm-1), W m-2 sr-1; 0 at temperature 0.
double band_planck(double low_cm1, double high_cm1, double temperature_K);

/// A benchmark: the column, its ground, and the number of streams it is stated for.
struct BenchmarkCase {
  std::string name;
  atmos::solver::Column column;
  atmos::solver::Ground ground;
  int streams = 16;
};

/// The DISORT test problems with Lambertian ground whose name starts with one of the digits given ("12" =
/// problems 1 and 2). The published radiances of problems 3, 4 and 7 belong to phase functions of 33, 33 and
/// streams + 1 moments (for problem 4 the data file says so; for 3 and 7 no other number of moments agrees,
/// and fluxes do not depend on it), so that is what they get here.
std::vector<BenchmarkCase> disort_cases(const std::string& problems, const std::string& test);

/// Largest deviations of a solution from the published answers, as parts of the case's largest flux and
/// radiance.
struct Deviation {
  double flux = 0, radiance = 0;
  int fluxes = 0, radiances = 0;  ///< how many were compared
};
Deviation disort_deviation(const BenchmarkCase& problem, const atmos::solver::ColumnSolution& solution);

}  // namespace raycube::test
