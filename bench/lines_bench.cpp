// Sums over spectral lines as a table of the air needs them: distant lines by polynomials of blocks of wavenumbers,
// against every profile at every wavenumber.
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "atmos_tables/lines/absorber.h"
#include "atmos_tables/lines/molecular_lines.h"
#include "atmos_tables/optics/standard_air.h"
#include "bench/cases.h"
#include "bench/timing.h"

namespace raycube::bench {
namespace {

/// Lines of methane at random between 2970 and 3030 cm-1, of five magnitudes of strength.
std::vector<atmos::SpectralLine> crowd(std::size_t count) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<atmos::SpectralLine> lines;
  for (std::size_t i = 0; i < count; ++i)
    lines.push_back({6, 1, 2970 + 60 * uniform(random), std::pow(10, -25 + 5 * uniform(random)),
                     0.03 + 0.07 * uniform(random), 0.09, 300, 0.7, -0.006});
  std::sort(lines.begin(), lines.end(),
            [](const auto& a, const auto& b) { return a.wavenumber_per_cm < b.wavenumber_per_cm; });
  return lines;
}

}  // namespace

void run_lines(const Settings&, Report& report) {
  const auto many = std::make_shared<const atmos::MolecularLines>(crowd(3000), atmos::LineOptions{},
                                                                  std::make_shared<atmos::PartitionSums>());
  std::vector<double> wavenumbers;
  for (int i = 0; i <= 4000; ++i) wavenumbers.push_back(2998 + 0.001 * i);
  const atmos::GasState ground{1000, 296, 1000 * 2e-6};
  const auto in_blocks = many->cross_section_cm2(wavenumbers, ground),
             whole = many->every_line_cm2(wavenumbers, ground);
  double worst = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) worst = std::max(worst, std::abs(in_blocks[i] / whole[i] - 1));
  report.validate("lines: sums in blocks against every profile, worst", worst, 1e-10);

  const Pairs sums = alternate([&] { many->every_line_cm2(wavenumbers, ground); },
                               [&] { many->cross_section_cm2(wavenumbers, ground); });
  report.add("lines_every_profile_s", spread_of(sums.reference_s), "s");
  report.add("lines_in_blocks_s", spread_of(sums.ours_s), "s");
  report.add("lines_blocks_over_every_profile", sums.ratio(), "");

  const std::vector<atmos::AbsorbingGas> gases = {{"ch4", atmos::Gas::ch4, 0, many}};
  const atmos::AirProfile air = atmos::afgl_profile(atmos::AfglModel::midlatitude_summer);
  const std::vector<double> levels_km = {0, 1, 2, 3, 4, 6, 8, 10, 15, 20, 30, 50, 100};
  std::vector<double> seconds;
  for (int run = 0; run < 3; ++run)
    seconds.push_back(seconds_of([&] { atmos::ResolvedGases(gases, air, levels_km, wavenumbers); }));
  report.add("lines_whole_air_s", spread_of(seconds), "s", Goal::at_most(10));
}

}  // namespace raycube::bench
