// The solver against 64-stream answers for a 49-layer midlatitude summer, solar and thermal, and
// against the scalar columns of the Rayleigh benchmarks (A-07: Natraj, Li & Yung 2009; Natraj & Hovenier
// 2012; Kokhanovsky et al. 2010; Emde et al. 2015; Kotchenova et al. 2006). Tolerances: atmosphere
// AIR 8.
#include <doctest/doctest.h>

#include <cmath>
#include <iostream>
#include <map>
#include <numbers>

#include "tests/support/solver_cases.h"

using namespace raycube::atmos::solver;
using namespace raycube::test;

namespace {

constexpr double kPi = std::numbers::pi;

/// Layers of a layered case; heights of the levels come out beside it.
Column layered_column(const std::string& name, const std::vector<CsvRow>& rows, std::vector<double>& height_km) {
  Column column;
  for (const CsvRow& row : rows) {
    if (row.at("case") != name) continue;
    const double rayleigh = number(row, "tau_ray"), aerosol = number(row, "tau_aer_sca");
    const double scatter = rayleigh + aerosol,
                 depth = scatter + number(row, "tau_aer_abs") + number(row, "tau_gas_abs");
    Layer layer{depth, depth > 0 ? scatter / depth : 0, {}};
    if (scatter > 0) {
      layer.phase_moments = henyey_greenstein_moments(number(row, "g"), 600);
      const std::vector<double> molecules = rayleigh_moments(0.029);
      for (std::size_t k = 0; k < layer.phase_moments.size(); ++k)
        layer.phase_moments[k] = (aerosol * layer.phase_moments[k] + rayleigh * (k < 3 ? molecules[k] : 0)) / scatter;
    }
    column.layers.push_back(layer);
    if (height_km.empty()) height_km.push_back(number(row, "z_top"));
    height_km.push_back(number(row, "z_bottom"));
    if (row.count("T_top") == 0 || row.at("T_top").empty()) continue;
    if (column.planck.empty()) column.planck.push_back(band_planck(999.5, 1000.5, number(row, "T_top")));
    column.planck.push_back(band_planck(999.5, 1000.5, number(row, "T_bottom")));
  }
  return column;
}

/// Depth at a height: linear in height inside a layer.
double depth_at(double z_km, const std::vector<double>& height_km, const ColumnSolution& solution) {
  for (std::size_t i = 0; i + 1 < height_km.size(); ++i)
    if (z_km >= height_km[i + 1]) {
      const double part = (height_km[i] - z_km) / (height_km[i] - height_km[i + 1]);
      return solution.level_depth(i) + part * (solution.level_depth(i + 1) - solution.level_depth(i));
    }
  return solution.total_depth();
}

void compare_layered(const std::vector<std::string>& names, const char* test, const Ground& ground, double beam,
                     double flux_tolerance, double radiance_tolerance) {
  const std::vector<CsvRow> layers = benchmark("layered_layers.csv", test);
  if (layers.empty()) return;
  for (const std::string& name : names) {
    CAPTURE(name);
    std::vector<double> height_km;
    Column column = layered_column(name, layers, height_km);
    column.beam = {beam, 0.766044443, 0};
    const ColumnSolution solution = solve_column(column);
    double flux_error = 0, radiance_error = 0;
    for (const CsvRow& row : benchmark("layered_fluxes.csv", test)) {
      if (row.at("case") != name) continue;
      const double depth = depth_at(number(row, "z_km"), height_km, solution);
      CHECK(depth == doctest::Approx(number(row, "tau")).epsilon(1e-6));
      const Fluxes fluxes = solution.fluxes(depth, ground);
      const std::pair<double, double> pairs[] = {{fluxes.direct_down, number(row, "direct_down")},
                                                 {fluxes.diffuse_down, number(row, "diffuse_down")},
                                                 {fluxes.up, number(row, "up")}};
      for (const auto& [ours, reference] : pairs)
        if (reference > 1e-6) flux_error = std::max(flux_error, std::abs(ours / reference - 1));
    }
    int count = 0;
    for (const CsvRow& row : benchmark("layered_radiances.csv", test)) {
      if (row.at("case") != name || number(row, "radiance") <= 1e-9) continue;
      const double depth = depth_at(number(row, "z_km"), height_km, solution);
      const double ours = solution.radiance(depth, number(row, "umu"), number(row, "phi_deg"), ground);
      radiance_error = std::max(radiance_error, std::abs(ours / number(row, "radiance") - 1));
      ++count;
    }
    std::cout << test << " " << name << ": fluxes " << flux_error << " (allowed " << flux_tolerance << "), " << count
              << " radiances " << radiance_error << " (allowed " << radiance_tolerance << "), relative\n";
    CHECK(count > 20);
    CHECK(flux_error <= flux_tolerance);
    CHECK(radiance_error <= radiance_tolerance);
  }
}

/// Rayleigh slab of 64 streams.
ColumnSolution rayleigh_slab(double depth, double depolarization, double mu0, double flux) {
  Column column;
  column.layers = {{depth, 1, rayleigh_moments(depolarization)}};
  column.beam = {flux, mu0, 0};
  Options options;
  options.streams = 64;
  return solve_column(column, options);
}

double cosine_of(double degrees) { return std::cos(degrees * kPi / 180); }

}  // namespace

TEST_CASE("S18 A-05 49-layer summer, sun: 16 streams within 2e-4 in flux and 1e-3 in radiance of 64 streams") {
  compare_layered({"S450", "S550", "S870"}, "A-05", {0.3, 0}, 1, 2e-4, 1e-3);
}

TEST_CASE("S18 A-06 49-layer summer, thermal: 16 streams within 2e-4 of 64 streams") {
  compare_layered({"T1000", "T1000thick"}, "A-06", {0.03, band_planck(999.5, 1000.5, 294.2)}, 0, 2e-4, 2e-4);
}

TEST_CASE("S18 A-07 Rayleigh slabs of Natraj, Li & Yung and of Natraj & Hovenier: scalar column to 1e-4") {
  double worst = 0;
  int count = 0;
  std::map<std::string, ColumnSolution> solved;
  const auto compare = [&](const CsvRow& row, double depth, double mu0, double albedo, bool up) {
    const std::string key = std::to_string(depth) + "/" + std::to_string(mu0);
    const auto found = solved.try_emplace(key, rayleigh_slab(depth, 0, mu0, kPi)).first;
    const double mu = number(row, "mu");
    const double ours = found->second.radiance(up ? 0 : depth, up ? mu : -mu, number(row, "phi_deg"), {albedo, 0});
    worst = std::max(worst, std::abs(ours / number(row, "I_scalar_disort") - 1));
    ++count;
  };
  for (const CsvRow& row : benchmark("natraj_selected.csv", "A-07"))
    compare(row, number(row, "tau"), number(row, "mu0"), number(row, "albedo"), row.at("level") == "top_up");
  for (const CsvRow& row : benchmark("natraj2009_tau0p5_mu0p2_A0_up.csv", "A-07")) compare(row, 0.5, 0.2, 0, true);
  std::cout << "A-07 Natraj: " << count << " radiances, worst " << worst << " relative; allowed 1e-4\n";
  CHECK(worst <= 1e-4);
}

TEST_CASE("S18 A-07 Rayleigh layer of Kokhanovsky et al.: scalar column to 1e-4") {
  const std::vector<CsvRow> rows = benchmark("kokhanovsky2010_molecular.csv", "A-07");
  if (rows.empty()) return;
  const ColumnSolution slab = rayleigh_slab(0.3262, 0, 0.5, 1);
  double worst = 0;
  for (const CsvRow& row : rows) {
    const bool up = row.at("light") == "reflected";
    const double mu = cosine_of(number(row, "vza_deg"));
    const double ours = kPi / 0.5 * slab.radiance(up ? 0 : 0.3262, up ? mu : -mu, number(row, "phi_deg"), {});
    worst = std::max(worst, std::abs(ours / number(row, "I_scalar_disort") - 1));
  }
  std::cout << "A-07 Kokhanovsky: worst " << worst << " relative; allowed 1e-4\n";
  CHECK(worst <= 1e-4);
}

TEST_CASE("S18 A-07 IPRT cases A1 and A2, depolarised and over Lambertian ground: scalar column to 1e-4") {
  double worst = 0;
  int count = 0;
  for (const char* file : {"iprt_a1_rayleigh.csv", "iprt_a2_lambert.csv"}) {
    const bool second = std::string(file).find("a2") != std::string::npos;
    for (const CsvRow& row : benchmark(file, "A-07")) {
      const double depth = second ? 0.1 : 0.5;
      const ColumnSolution slab = rayleigh_slab(depth, number(row, "depol"), cosine_of(number(row, "sza")), 1);
      const bool up = row.at("level") == "top_up";
      const double ours = slab.radiance(up ? 0 : depth, -cosine_of(number(row, "vza")),
                                        number(row, "vaa") - number(row, "saa"), {second ? 0.3 : 0.0, 0});
      const double error = std::abs(ours / number(row, "I_scalar_disort") - 1);
      CAPTURE(number(row, "vza"));
      CHECK(error <= 1e-4);
      worst = std::max(worst, error);
      ++count;
    }
  }
  std::cout << "A-07 IPRT: " << count << " radiances, worst " << worst << " relative; allowed 1e-4\n";
}

TEST_CASE("S18 A-07 6SV's Rayleigh table: scalar column to 1e-4 and its last digit") {
  double worst = 0;
  std::map<std::string, ColumnSolution> solved;
  for (const CsvRow& row : benchmark("sixsv_rayleigh_toa_reflectance.csv", "A-07")) {
    const double mu0 = cosine_of(number(row, "sza_deg")), depth = number(row, "tau");
    const auto found =
        solved.try_emplace(row.at("tau") + "/" + row.at("sza_deg"), rayleigh_slab(depth, 0, mu0, 1)).first;
    const double ours = kPi / mu0 *
                        found->second.radiance(0, cosine_of(number(row, "vza_deg")), number(row, "azimuth_deg"),
                                               {number(row, "surface_albedo"), 0});
    // Printed with five decimals.
    worst = std::max(worst, (std::abs(ours - number(row, "R_scalar_disort")) - 5e-6) / number(row, "R_scalar_disort"));
  }
  std::cout << "A-07 6SV: worst " << worst << " relative beyond the printed digit; allowed 1e-4\n";
  CHECK(worst <= 1e-4);
}

TEST_CASE("S18 A-07 scalar Rayleigh radiances, restated") {
  // Scalar answers of 64-stream runs for the slab of Natraj, Li & Yung (2009), depth 0.5, mu0 0.2, flux pi,
  // black ground.
  const ColumnSolution slab = rayleigh_slab(0.5, 0, 0.2, kPi);
  CHECK(slab.radiance(0, 0.1, 0, {}) == doctest::Approx(0.33139947).epsilon(1e-4));
  CHECK(slab.radiance(0, 0.52, 90, {}) == doctest::Approx(0.09956021).epsilon(1e-4));
  CHECK(slab.radiance(0, 1, 0, {}) == doctest::Approx(0.05835771).epsilon(1e-4));
  CHECK(slab.radiance(0.5, -0.2, 180, {}) == doctest::Approx(0.13570329).epsilon(1e-4));
}
