// gas tables against LOWTRAN7's own component transmittances. Air: midlatitude summer as LOWTRAN7 has it, with 33
// of the 50 AFGL levels and densities from p / T. Paths: 3 km straight down, and 60 degrees from the ground to space
// (refracted). Tolerances are the figures of S3.2 for the same formulas programmed independently, unless said
// otherwise.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iostream>
#include <string>
#include <vector>

#include "atmos_tables/gas/layer_gases.h"
#include "tests/support/anchor_rows.h"
#include "tests/support/curved_path.h"
#include "tests/support/lowtran_air.h"

using namespace raycube;
using namespace raycube::atmos;
using testing::lowtran_air;

namespace {

/// What a set of gases adds to air that has none but trace gases and nitrogen.
class Component {
 public:
  Component(const std::vector<Gas>& gases, const std::vector<double>& level_km, const std::vector<double>& path)
      : with_(lowtran_air(gases), level_km, BandModel::lowtran),
        without_(lowtran_air({}), level_km, BandModel::lowtran),
        path_(path) {}
  double lines(double v) const { return with_.line_depth(v, path_) - (bare_ ? 0 : without_.line_depth(v, path_)); }
  double grey(double v) const {
    double sum = 0;
    for (std::size_t i = 0; i < path_.size(); ++i)
      sum += path_[i] * (with_.grey_depth(v, i) - (bare_ ? 0 : without_.grey_depth(v, i)));
    return sum;
  }
  Component& bare() { return bare_ = true, *this; }

 private:
  LayerGases with_, without_;
  std::vector<double> path_;
  bool bare_ = false;
};

struct Worst {
  double error = 0, wavenumber = 0;
};

template <class Depth, class Where>
Worst worst(std::vector<testing::AnchorRow>& rows, const char* column, Depth&& depth, Where&& where) {
  Worst out;
  for (testing::AnchorRow& row : rows) {
    const double v = row["nu_cm1"];
    if (!where(v)) continue;
    const double error = std::exp(-depth(v)) - row.at(column);
    if (!(std::abs(error) <= std::abs(out.error))) out = {error, v};
  }
  std::cout << column << ": " << out.error << " at " << out.wavenumber << " cm-1\n";
  return out;
}

}  // namespace

TEST_CASE("A-10 S3.2 components of LOWTRAN7, 330 to 33340 cm-1") {
  const AirProfile air = lowtran_air({});
  std::vector<double> all;
  for (double z = 0; z <= 100; z += z < 50 ? 1 : 5) all.push_back(z);  // so thin that a layer has one slope of the ray
  struct Path {
    const char* file;
    std::vector<double> level_km;
    double zenith_deg;
  };
  for (const Path& path : {Path{"anchors/lowtran7_components_3p0_180.csv", {0, 1, 2, 3}, 0},
                           Path{"anchors/lowtran7_components_sky_60.csv", all, 60}}) {
    auto rows = testing::anchor_rows(path.file, "gases were not compared with LOWTRAN7");
    if (rows.empty()) return;
    CAPTURE(std::string(path.file));
    const std::vector<double> factor = testing::curved_path_factors(air, path.level_km, path.zenith_deg, 0);
    const Component water({Gas::h2o}, path.level_km, factor), ozone({Gas::o3}, path.level_km, factor);
    const Component mixed({Gas::co2, Gas::n2o, Gas::co, Gas::ch4, Gas::o2}, path.level_km, factor);
    Component bare({}, path.level_km, factor);
    bare.bare();
    const auto everywhere = [](double) { return true; };
    const auto oxygen = [](double v) { return v > 1390 && v < 1765; };

    CHECK(std::abs(worst(
                       rows, "H2O_lines", [&](double v) { return water.lines(v); }, everywhere)
                       .error) <= 3.3e-4);
    const auto mixed_depth = [&](double v) { return mixed.lines(v) + mixed.grey(v); };
    CHECK(std::abs(worst(rows, "CO2plus", mixed_depth, [&](double v) { return !oxygen(v); }).error) <= 1.9e-4);
    // Oxygen's collision band: LOWTRAN7 takes one temperature per layer in the terms (T - 220 K); S3.2 leaves this band
    // out.
    CHECK(std::abs(worst(rows, "CO2plus", mixed_depth, oxygen).error) <= 4e-4);
    // One mean temperature per layer again: water lies low in a layer, where it is warm, so LOWTRAN7's continuum is up
    // to 0.6 % deeper. S3.2 has 1.5e-3 with another air density.
    CHECK(std::abs(worst(
                       rows, "H2O_cont", [&](double v) { return water.grey(v); }, everywhere)
                       .error) <= 2.3e-3);
    const auto ozone_depth = [&](double v) { return ozone.lines(v) + ozone.grey(v); };
    // 24200 to 24250 cm-1: LOWTRAN7 ends with a step, here the last figure fades out (depth 2e-4). On the slant path
    // 0.1 % of the airmass at 20 to 40 km, where LOWTRAN7 has layers of 5 km, is 3.7e-4 in T; straight down 7e-5 hold.
    const auto ozone_figures = [](double v) { return v < 24200 || v > 24250; };
    CHECK(std::abs(worst(rows, "O3", ozone_depth, ozone_figures).error) <= (path.zenith_deg > 0 ? 3.7e-4 : 7e-5));
    // The other gases have no figure in S3.2; that of ozone is asked of them.
    CHECK(std::abs(worst(
                       rows, "trace", [&](double v) { return bare.lines(v); }, everywhere)
                       .error) <= 7e-5);
    const auto nitrogen = [](double v) { return v > 2000 && v < 2800; };
    CHECK(std::abs(worst(
                       rows, "N2_cont", [&](double v) { return bare.grey(v); }, nitrogen)
                       .error) <= 7e-5);
    const auto acid = [](double v) { return v < 1800; };
    CHECK(std::abs(worst(
                       rows, "HNO3", [&](double v) { return bare.grey(v); }, acid)
                       .error) <= 7e-5);
  }
}
