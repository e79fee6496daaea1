#include "tests/support/solver_cases.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace raycube::test {

using namespace atmos::solver;

std::vector<CsvRow> benchmark(const std::string& file, const std::string& test) {
  return testing::anchor_cells("rt_benchmarks/" + file, test + " was not compared with " + file);
}

double number(const CsvRow& row, const std::string& column) {
  const auto cell = row.find(column);
  return cell == row.end() || cell->second.empty() ? 0.0 : std::stod(cell->second);
}

std::vector<double> henyey_greenstein_moments(double asymmetry, int count) {
  std::vector<double> moments;
  double power = 1;
  for (int k = 0; k < count; ++k, power *= asymmetry) moments.push_back(power);
  return moments;
}

std::vector<double> rayleigh_moments(double depolarization) {
  return {1, 0, 0.1 * (1 - depolarization) / (1 + 0.5 * depolarization)};
}

double band_planck(double low_cm1, double high_cm1, double temperature_K) {
  if (temperature_K <= 0) return 0;
  const double c1 = 1.191042972e-8, c2 = 1.438776877;  // W m-2 sr-1 cm4, cm K (CODATA 2018)
  const double end = std::min(high_cm1, 60 * temperature_K / c2);
  const int steps = 4000;  // Simpson: error below 1e-9
  double sum = 0;
  for (int i = 0; i <= steps; ++i) {
    const double v = low_cm1 + (end - low_cm1) * i / steps;
    const double value = v > 0 ? v * v * v / std::expm1(c2 * v / temperature_K) : 0;
    sum += value * (i == 0 || i == steps ? 1 : (i % 2 == 1 ? 4 : 2));
  }
  return c1 * sum * (end - low_cm1) / steps / 3;
}

namespace {

std::vector<double> named_moments(const std::string& name, const CsvRow& layer, const std::vector<CsvRow>& tables) {
  if (name == "isotropic" || name == "none") return {1};
  if (name == "rayleigh") return rayleigh_moments();
  if (name.rfind("hg", 0) == 0) return henyey_greenstein_moments(number(layer, "g1"), 300);
  const std::string column = name == "see_moments" ? "disort_9b" : name;
  std::vector<double> moments;
  for (const CsvRow& row : tables)
    if (row.count(column) && !row.at(column).empty()) moments.push_back(number(row, column));
  return moments;
}

/// Moments 0 ... n the test program hands over, n its number of terms: 32 (problems 3, 4), the number of
/// streams (7).
std::size_t given_moments(const std::string& name, int streams) {
  if (name[0] == '3' || name[0] == '4') return 33;
  return name[0] == '7' ? static_cast<std::size_t>(streams) + 1 : 300;
}

}  // namespace

std::vector<BenchmarkCase> disort_cases(const std::string& problems, const std::string& test) {
  std::vector<BenchmarkCase> cases;
  const std::vector<CsvRow> rows = benchmark("disort_cases.csv", test);
  if (rows.empty()) return cases;
  const std::vector<CsvRow> layers = benchmark("disort_layers.csv", test),
                            tables = benchmark("disort_phase_moments.csv", test);
  for (const CsvRow& row : rows) {
    const std::string name = row.at("case");
    if (problems.find(name[0]) == std::string::npos || row.at("surface") != "lambert") continue;
    BenchmarkCase problem;
    problem.name = name;
    problem.streams = static_cast<int>(number(row, "nstr"));
    problem.column.beam = {number(row, "fbeam"), number(row, "umu0"), number(row, "phi0_deg")};
    problem.column.top_radiance = number(row, "fisot");
    problem.ground.albedo = number(row, "albedo");
    const bool thermal = row.at("thermal") == "1";
    const auto planck = [&row](double kelvin) {
      return band_planck(number(row, "wvnmlo_cm1"), number(row, "wvnmhi_cm1"), kelvin);
    };
    for (const CsvRow& layer : layers) {
      if (layer.at("case") != name) continue;
      std::vector<double> moments = named_moments(row.at("phase_function"), layer, tables);
      if (moments.size() > given_moments(name, problem.streams)) moments.resize(given_moments(name, problem.streams));
      problem.column.layers.push_back({number(layer, "dtau"), number(layer, "ssa"), moments});
      if (!thermal) continue;
      if (problem.column.planck.empty()) problem.column.planck.push_back(planck(number(layer, "T_top_K")));
      problem.column.planck.push_back(planck(number(layer, "T_bottom_K")));
    }
    if (thermal) {
      problem.column.top_radiance += number(row, "temis") * planck(number(row, "ttemp_K"));
      problem.ground.planck = planck(number(row, "btemp_K"));
    }
    cases.push_back(problem);
  }
  return cases;
}

Deviation disort_deviation(const BenchmarkCase& problem, const ColumnSolution& solution) {
  Deviation worst;
  double largest_flux = 0, largest_radiance = 0;
  for (const CsvRow& row : benchmark("disort_fluxes.csv", problem.name)) {
    if (row.at("case") != problem.name) continue;
    const Fluxes fluxes = solution.fluxes(number(row, "utau"), problem.ground);
    const std::pair<double, double> pairs[] = {{fluxes.direct_down, number(row, "rfldir")},
                                               {fluxes.diffuse_down, number(row, "rfldn")},
                                               {fluxes.up, number(row, "flup")}};
    for (const auto& [ours, published] : pairs) {
      largest_flux = std::max(largest_flux, published);
      worst.flux = std::max(worst.flux, std::abs(ours - published));
      ++worst.fluxes;
    }
  }
  for (const CsvRow& row : benchmark("disort_intensities.csv", problem.name)) {
    if (row.at("case") != problem.name) continue;
    const double published = number(row, "intensity");
    const double ours =
        solution.radiance(number(row, "utau"), number(row, "umu"), number(row, "phi_deg"), problem.ground);
    largest_radiance = std::max(largest_radiance, published);
    worst.radiance = std::max(worst.radiance, std::abs(ours - published));
    ++worst.radiances;
  }
  if (largest_flux > 0) worst.flux /= largest_flux;
  if (largest_radiance > 0) worst.radiance /= largest_radiance;
  return worst;
}

}  // namespace raycube::test
