// thermal light of paths and of the sky in whole tables with LOWTRAN7's bands and rules (gas_bands = "lowtran")
// against LOWTRAN7's own (anchors/lowtran7_paths_mwir_lwir.csv, lowtran7_sky_mwir_lwir.csv): 2 % + 1e-4 of Planck's law
// at the ground. Its rules are a mean temperature for every layer and scattered light counted as absorbed; raycube's
// own are graded layers and scattering by the solver. What lies between the two is shown below.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "atmos_tables/compiler/layered_air.h"
#include "atmos_tables/compiler/thermal_paths.h"
#include "atmos_tables/interpolate.h"
#include "host/base/planck.h"
#include "tests/support/layered_anchor.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

constexpr double kGround_K = 294.2;

/// Bins 10 cm-1 wide; the reference's points are 5 cm-1 apart, its outer two lie on the bin's ends.
struct Bins {
  explicit Bins(std::vector<testing::AnchorRow>& rows) {
    for (std::size_t i = 1; i + 1 < rows.size(); i += 2) at.push_back(i);
    std::reverse(at.begin(), at.end());  // the reference's wavenumbers rise
    for (std::size_t i : at) wavelength_um.push_back(1e4 / rows[i]["nu_cm1"]);
  }
  std::vector<std::size_t> at;
  std::vector<double> wavelength_um;
  static double mean(const std::vector<testing::AnchorRow>& rows, std::size_t i, const std::string& column) {
    return 0.25 * (rows[i - 1].at(column) + rows[i + 1].at(column)) + 0.5 * rows[i].at(column);
  }
};

}  // namespace

TEST_CASE("A-12 A-11 LOWTRAN7's rules: thermal paths and skies, their transmission, 2.5 to 29 um") {
  auto paths =
      testing::anchor_rows("anchors/lowtran7_paths_mwir_lwir.csv", "thermal paths were not compared with LOWTRAN7");
  auto skies =
      testing::anchor_rows("anchors/lowtran7_sky_mwir_lwir.csv", "thermal skies were not compared with LOWTRAN7");
  if (paths.empty() || skies.empty()) return;
  auto spec = testing::summer_rural_air();
  spec.layered->gas_bands = "lowtran";
  spec.layered->k_terms = 1, spec.layered->streams = 4;  // by its rules nothing here comes from the solver
  const Bins bins(paths);
  testing::ChartRows chart("lowtran_thermal", "um,path,reference_path,sky,reference_sky");
  std::vector<std::vector<double>> drawn(4);

  // worst: error over 2 % + 1e-4 of Planck's law; at most 1.
  const auto compare = [&](const std::vector<double>& found, const std::vector<testing::AnchorRow>& rows,
                           const std::string& column) {
    double worst = 0, place = 0;
    std::vector<double> reference;
    for (std::size_t k = 0; k < bins.at.size(); ++k) {
      reference.push_back(Bins::mean(rows, bins.at[k], column));
      const double bar = 0.02 * reference[k] + 1e-4 * base::planck_radiance(bins.wavelength_um[k], kGround_K);
      const double error = (found[k] - reference[k]) / bar;
      if (!(std::abs(error) <= std::abs(worst))) worst = error, place = bins.wavelength_um[k];
    }
    std::printf("%-13s worst %+.2f of the bar, at %.2f um\n", column.c_str(), worst, place);
    CAPTURE(column);
    CHECK(std::abs(worst) <= 1);
    return reference;
  };
  struct Path {
    double zenith_deg;
    const char* name;
  };
  for (double sensor_km : {0.61, 3.0, 100.0}) {
    const RenderTable table =
        build_layered(spec, testing::sun_at(testing::kNight_deg), 1000 * sensor_km, bins.wavelength_um, {0});
    const std::string height = sensor_km < 1 ? "0p61" : sensor_km < 50 ? "3p0" : "100";
    // Zenith angles at the ground; the reference's 150 degrees at 3 km are 29.98 there.
    for (const Path& path : {Path{0, "180"}, Path{30, "150"}}) {
      if (sensor_km > 50 && path.zenith_deg > 0) continue;
      const std::string name = height + "_" + path.name;
      const auto found = path_radiance_thermal(table, 0, path.zenith_deg);
      const auto reference = compare(found, paths, "Lth_" + name);
      if (name == "3p0_180") drawn[0] = found, drawn[1] = reference;
      // A-11's 0.003, and 0.001 for bins that hold band edges: mean of the model's points against linear between them.
      const auto transmission = view_transmission(table, 0, path.zenith_deg);
      double worst = 0;
      for (std::size_t k = 0; k < bins.at.size(); ++k)
        worst = std::max(worst, std::abs(transmission[k] - Bins::mean(paths, bins.at[k], "T_" + name)));
      CHECK(worst <= 0.004);
    }
    // A level at 0.61 km halves LOWTRAN7's lowest layer, and with it the sky's temperature in opaque bands.
    if (sensor_km < 1) continue;
    for (int zenith : {0, 30, 45, 60, 75, 85}) {
      if (sensor_km > 50 && zenith != 0) continue;
      const auto found = sky_radiance_thermal(table, 0, zenith);
      const auto reference = compare(found, skies, "Lth_" + std::to_string(zenith));
      if (zenith == 0) drawn[2] = found, drawn[3] = reference;
    }
  }
  for (std::size_t k = 0; k < bins.at.size(); ++k)
    chart.add({bins.wavelength_um[k], drawn[0][k], drawn[1][k], drawn[2][k], drawn[3][k]});
}

// The graded layers do not need LOWTRAN7's 1 km: with layers cut into eight, both rules must come to the same.
TEST_CASE("A-12 S4.8 graded layers are the limit of thin layers of one temperature") {
  auto spec = testing::summer_rural_air();
  spec.layered->aod_550 = 1e-4;  // the rules differ in scattered light by intention
  const AirStack coarse(*spec.layered, 0, {3});
  spec.layered->layering = 8;
  const AirStack fine(*spec.layered, 0, {3});
  for (double um : {2.7, 4.1, 4.6, 6.3, 10.0, 11.8, 15.0}) {
    CAPTURE(um);
    const SpectralBin bin = spectral_bins({um}).front();
    const SpectralAir thick(coarse, bin, 3), thin(fine, bin, 3);
    const auto emission = [](const SpectralAir& air, const AirStack& stack, LayerEmission rule, bool up) {
      const std::size_t low = stack.level_of(0), high = up ? stack.level_of(3) : stack.layers();
      return path_emission(air, stack, stack.path_factors(low, high, 40), low, high, up, rule);
    };
    for (bool up : {true, false}) {
      const double graded = emission(thick, coarse, LayerEmission::graded, up);
      // Against the fine layers' own graded sum: what the thickness of layers costs. Line centres see less far than the
      // mean, so a layer shows its near edge more than one exponential says: 2 % in the worst of these.
      CHECK(graded == doctest::Approx(emission(thin, fine, LayerEmission::graded, up)).epsilon(0.02));
      CHECK(graded == doctest::Approx(emission(thin, fine, LayerEmission::one_temperature, up)).epsilon(0.02));
    }
  }
}
