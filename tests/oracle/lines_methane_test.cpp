// Methane's R(3) manifold near 3.27 um: cross-sections computed elsewhere from the same lines (reference lidar/),
// through a line list in HITRAN's format that the test writes.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "atmos_tables/lines/hitran_par.h"
#include "atmos_tables/lines/molecular_lines.h"
#include "tests/support/anchor_rows.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::testing::anchor_rows;
using raycube::testing::AnchorRow;

namespace {

constexpr const char* kNotShown = "methane's cross-sections near 3.27 um are not compared";

std::string record(const AnchorRow& row) {
  char text[200], self[16], air[16];
  std::snprintf(air, sizeof air, "%.4f", row.at("gamma_air"));
  std::snprintf(self, sizeof self, "%5.3f", row.at("gamma_self"));
  std::snprintf(text, sizeof text, "%2d1%12.6f%10.3E%10.3E%5s%5s%10.4f%4.2f%8.6f", 6, row.at("nu0_cm1"),
                row.at("S_296"), 1.0, air + 1, self, row.at("E_lower_cm1"), row.at("n_air"), row.at("delta_air"));
  std::string line = text;
  // -0.006109 takes 9 columns; HITRAN prints -.006109.
  const std::size_t shift = line.find("-0.", 59);
  if (shift != std::string::npos && line.size() == 68) line.erase(shift + 1, 1);
  line.resize(160, ' ');
  return line + "\n";
}

MolecularLines methane() {
  const testing::TestFolder folder;
  std::string text;
  for (const AnchorRow& row : anchor_rows("lidar/ch4_lines_3057cm1.csv", kNotShown)) text += record(row);
  folder.write("ch4.par", text);
  return MolecularLines(read_hitran_par(folder / "ch4.par", 3000, 3100).lines, {}, std::make_shared<PartitionSums>());
}

struct State {
  const char* column;
  GasState state;
};
const State kStates[] = {{"sigma_1atm_296K", {1013.25, 296, 0}},
                         {"sigma_0p69atm_280K", {0.69 * 1013.25, 280, 0}},
                         {"sigma_0p5atm_265K", {0.5 * 1013.25, 265, 0}}};

}  // namespace

TEST_CASE("AIR 9 methane R(3): the whole curve of 3056.5 to 3058.9 cm-1 at three states") {
  const std::vector<AnchorRow> rows = anchor_rows("lidar/ch4_xsec_3270nm.csv", kNotShown);
  if (rows.empty()) return;
  const MolecularLines lines = methane();
  std::vector<double> v;
  for (const AnchorRow& row : rows) v.push_back(row.at("nu_cm1"));
  for (const State& s : kStates) {
    const std::vector<double> sigma = lines.cross_section_cm2(v, s.state);
    double worst = 0, at = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const double truth = rows[i].at(s.column), error = std::abs(sigma[i] - truth) / truth;
      if (error > worst) worst = error, at = v[i];
    }
    MESSAGE(std::string(s.column) << ": worst relative difference " << worst << " at " << at << " cm-1");
    // The table prints 5 digits (5e-5); the partition sums of 280 and 265 K are another's.
    CHECK(worst <= 1.5e-4);
  }
}

TEST_CASE(
    "AIR 9 methane R(3): 2.02e-18 cm2 on line at 1 atm and 296 K, 2.63e-18 at 0.69 atm and 280 K, 1.94e-20 off line; "
    "100 "
    "ppm m") {
  if (anchor_rows("lidar/ch4_lines_3057cm1.csv", kNotShown).empty()) return;
  const MolecularLines lines = methane();
  std::vector<double> v;
  for (int i = 0; i <= 400; ++i) v.push_back(3057.6 + 0.0005 * i);
  const auto peak = [&](const GasState& state) {
    const std::vector<double> sigma = lines.cross_section_cm2(v, state);
    return *std::max_element(sigma.begin(), sigma.end());
  };
  const double ground = peak(kStates[0].state), higher = peak(kStates[1].state);
  MESSAGE("peaks " << ground << " and " << higher << " cm2, off line "
                   << lines.cross_section_cm2({3058.4}, kStates[0].state)[0]);
  CHECK(std::abs(ground - 2.02e-18) <= 0.005e-18);
  CHECK(std::abs(higher - 2.63e-18) <= 0.0065e-18);
  CHECK(std::abs(lines.cross_section_cm2({3058.4}, kStates[0].state)[0] - 1.94e-20) <= 0.005e-20);
  // 1 ppm m at 1 atm and 296 K: p / (k T) 1e-6 100 cm.
  const double ppm_m = 1e-4 * 101325 / (kBoltzmann_J_per_K * 296) * 1e-6;
  CHECK(std::abs(ppm_m - 2.48e15) <= 0.005e15);
  CHECK(std::abs(100 * ppm_m * ground - 0.50) <= 0.005);
}
