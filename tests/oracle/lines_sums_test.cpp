// S19: Sums over lines, strengths and layers. Oracles: area of a line, every profile at every wavenumber, rotational
// levels summed one by one, Beer's law in homogeneous air.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "atmos_tables/lines/molecular_lines.h"
#include "atmos_tables/lines/voigt.h"
#include "atmos_tables/optics/standard_air.h"
#include "tests/support/relative.h"

using namespace raycube::atmos;
using raycube::test::relative;

namespace {

std::shared_ptr<const PartitionSums> sums() { return std::make_shared<PartitionSums>(); }

SpectralLine line(double wavenumber, double intensity, double gamma_air = 0.07) {
  return {6, 1, wavenumber, intensity, gamma_air, 0.09, 300, 0.7, -0.006};
}

std::vector<SpectralLine> crowd(std::size_t count, double low, double high) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<SpectralLine> out;
  for (std::size_t i = 0; i < count; ++i)
    out.push_back(line(low + (high - low) * uniform(random), std::pow(10, -25 + 5 * uniform(random)),
                       0.03 + 0.07 * uniform(random)));
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return a.wavenumber_per_cm < b.wavenumber_per_cm; });
  return out;
}

std::vector<double> grid(double low, double high, double step) {
  std::vector<double> out;
  for (int i = 0; low + i * step <= high; ++i) out.push_back(low + i * step);
  return out;
}

}  // namespace

TEST_CASE(
    "AIR 9 lines: the area of a line is its strength, less what the cut wings hold; shift and self-broadening by "
    "pressure") {
  const MolecularLines one({line(3000, 1e-20)}, {}, sums());
  const GasState state{506.625, 296, 101.325};
  const std::vector<double> v = grid(2974, 3026, 0.0005), sigma = one.cross_section_cm2(v, state);
  double area = 0, centroid = 0;
  for (std::size_t i = 0; i < v.size(); ++i) area += 0.0005 * sigma[i], centroid += 0.0005 * sigma[i] * (v[i] - 3000);
  const double gamma = 0.07 * 0.4 + 0.09 * 0.1;  // 0.5 atm, a tenth of an atmosphere of its own
  // Beyond 25 cm-1 a Lorentzian holds 2/pi atan(gamma / 25).
  CHECK(relative(area, 1e-20 * (1 - 2 / 3.14159265358979 * std::atan(gamma / 25))) <= 1e-6);
  CHECK(std::abs(centroid / area + 0.003) <= 1e-5);
  CHECK(one.cross_section_cm2({2974.9, 2975.0}, state)[0] == 0);
  CHECK(one.cross_section_cm2({2974.9, 2975.0}, state)[1] > 0);
}

TEST_CASE("AIR 9 lines: blocks with Chebyshev wings give the sum of all profiles, from the ground to 60 km") {
  const std::vector<SpectralLine> lines = crowd(3000, 2970, 3030);
  double worst = 0;
  for (bool without_pedestal : {false, true}) {
    const MolecularLines all(lines, {25, without_pedestal, 0}, sums());
    const std::vector<double> v = grid(2999, 3001, 0.001);
    for (const GasState& state : {GasState{1013, 290, 2}, GasState{100, 220, 0.1}, GasState{0.2, 250, 0}}) {
      const std::vector<double> fast = all.cross_section_cm2(v, state), slow = all.every_line_cm2(v, state);
      for (std::size_t i = 0; i < v.size(); ++i) worst = std::max(worst, relative(fast[i], slow[i]));
    }
  }
  MESSAGE("worst relative difference " << worst);
  CHECK(worst <= 1e-11);
  // A short list of wavenumbers is summed point by point.
  const MolecularLines all(lines, {}, sums());
  const std::vector<double> few = {2999.5, 2999.50001, 3000.7};
  const GasState state{800, 280, 0};
  for (std::size_t i = 0; i < few.size(); ++i)
    CHECK(relative(all.cross_section_cm2(few, state)[i], all.every_line_cm2(few, state)[i]) <= 1e-13);
}

TEST_CASE("AIR 9 lines: the pedestal is the profile at the wing's end; the weakest lines can be left out") {
  const GasState state{1013.25, 296, 0};
  const MolecularLines with({line(3000, 1e-20)}, {}, sums()), without({line(3000, 1e-20)}, {25, true, 0}, sums());
  const std::vector<double> v = {3000, 3010, 3024.9939};
  const auto a = with.cross_section_cm2(v, state), b = without.cross_section_cm2(v, state);
  CHECK(relative(a[0] - b[0], a[2]) <= 1e-4);
  CHECK(relative(a[1] - b[1], a[2]) <= 1e-4);
  CHECK(b[2] <= 1e-4 * a[2]);
  const MolecularLines strong({line(3000, 1e-24), line(3001, 1e-20)}, {25, false, 1e-23}, sums());
  CHECK(strong.cross_section_cm2({3000.5}, state)[0] ==
        MolecularLines({line(3001, 1e-20)}, {}, sums()).cross_section_cm2({3000.5}, state)[0]);
}

TEST_CASE("AIR 9 lines: strength with temperature, and partition sums against rotational levels summed one by one") {
  // hc/k; rotational constants, cm-1 (NIST; Herzberg).
  const double c2 = 1.438776877;
  const auto linear = [&](double b, double t) {
    double q = 0;
    for (int j = 0; j < 400; ++j) q += (2 * j + 1) * std::exp(-c2 * b * j * (j + 1) / t);
    return q;
  };
  const auto spherical = [&](double b, double t) {
    double q = 0;
    for (int j = 0; j < 200; ++j) q += (2.0 * j + 1) * (2 * j + 1) * std::exp(-c2 * b * j * (j + 1) / t);
    return q;
  };
  const auto vibration = [&](std::initializer_list<std::pair<double, int>> modes, double t) {
    double q = 1;
    for (const auto& [v, g] : modes) q *= std::pow(1 - std::exp(-c2 * v / t), -g);
    return q;
  };
  const PartitionSums formula;
  double worst = 0;
  for (double t : {180.0, 220.0, 260.0, 330.0}) {
    const auto compare = [&](int molecule, double q296, double q) {
      worst = std::max(worst, relative(formula.ratio(molecule, 1, t), q296 / q));
    };
    const auto co = [&](double at) { return linear(1.9225, at) * vibration({{2143, 1}}, at); };
    const auto co2 = [&](double at) { return linear(0.3902, at) * vibration({{1333, 1}, {667, 2}, {2349, 1}}, at); };
    const auto n2o = [&](double at) { return linear(0.4190, at) * vibration({{2224, 1}, {1285, 1}, {589, 2}}, at); };
    const auto ch4 = [&](double at) {
      return spherical(5.241, at) * vibration({{2917, 1}, {1534, 2}, {3019, 3}, {1306, 3}}, at);
    };
    compare(5, co(296), co(t)), compare(2, co2(296), co2(t)), compare(4, n2o(296), n2o(t)),
        compare(6, ch4(296), ch4(t));
  }
  MESSAGE("classical rotation, worst ratio " << worst);
  // First quantum correction: linear B c2 / (3 T), spherical top B c2 / (4 T): 0.4 % for methane at 180 K.
  CHECK(worst <= 5e-3);
  // The line's own formula, in another arrangement: Boltzmann factors of both states.
  const SpectralLine l = line(3000, 1e-20);
  const double t = 220;
  const auto populations = [&](double at) { return std::exp(-c2 * 300 / at) - std::exp(-c2 * 3300 / at); };
  CHECK(relative(line_intensity(l, t, formula), 1e-20 * formula.ratio(6, 1, t) * populations(t) / populations(296)) <=
        1e-12);
  CHECK(relative(line_intensity(l, 296, formula), 1e-20) <= 1e-15);
}

TEST_CASE("AIR 9 layers: Beer's law in homogeneous air, sums over layers that do not depend on how it is cut") {
  // One kilometre of homogeneous air with 2 ppm of methane.
  AirLevel low;
  low.height_km = 0, low.pressure_hPa = 1000, low.temperature_K = 296, low.air_per_cm3 = 2.4e19,
  low.gas(Gas::ch4) = 4.8e13;
  AirLevel high = low;
  high.height_km = 1, high.pressure_hPa = 999.9999;
  const auto absorber =
      std::make_shared<MolecularLines>(std::vector<SpectralLine>{line(3000, 1e-20)}, LineOptions{}, sums());
  const std::vector<AbsorbingGas> gases = {{"ch4", Gas::ch4, 0, absorber}};
  const std::vector<double> v = {2999, 2999.994, 3000.2};
  const ResolvedGases whole(gases, AirProfile({low, high}, "test"), {0, 0.25, 1}, v);
  for (std::size_t i = 0; i < v.size(); ++i) {
    const double sigma = absorber->cross_section_cm2({v[i]}, {1000, 296, 1000 * 2e-6})[0];
    CHECK(relative(whole.depth(i, 0), 0.25e5 * 4.8e13 * sigma) <= 1e-6);
    CHECK(relative(whole.depth(i, 1), 0.75e5 * 4.8e13 * sigma) <= 1e-6);
  }
  // By mixing ratio.
  const std::vector<AbsorbingGas> mixed = {{"plume", {}, 2, absorber}};
  CHECK(relative(ResolvedGases(mixed, AirProfile({low, high}, "test"), {0, 1}, v).depth(1, 0),
                 whole.depth(1, 0) + whole.depth(1, 1)) <= 1e-12);

  const AirProfile air = afgl_profile(AfglModel::midlatitude_summer);
  const auto many = std::make_shared<MolecularLines>(crowd(3000, 2970, 3030), LineOptions{}, sums());
  const std::vector<AbsorbingGas> crowded = {{"ch4", Gas::ch4, 0, many}};
  const std::vector<double> at = {2999.3, 2999.81, 3000.05};
  const std::vector<double> levels = {0, 1, 2, 3, 4, 6, 8, 10, 15, 20, 30, 50, 100};
  const ResolvedGases coarse(crowded, air, levels, at);
  std::vector<double> fine_levels;
  for (int i = 0; i <= 200; ++i) fine_levels.push_back(0.5 * i);
  const ResolvedGases fine(crowded, air, fine_levels, at);
  double worst = 0;
  for (std::size_t i = 0; i < at.size(); ++i) {
    double a = 0, b = 0;
    for (std::size_t k = 0; k < coarse.layers(); ++k) a += coarse.depth(i, k);
    for (std::size_t k = 0; k < fine.layers(); ++k) b += fine.depth(i, k);
    worst = std::max(worst, relative(a, b));
  }
  MESSAGE("column by 12 layers against 200: " << worst);
  CHECK(worst <= 1e-4);
}
