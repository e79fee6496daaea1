// transmittance of the whole air, LOWTRAN7 bands alone, against LOWTRAN7's paths to the ground, to the sky and to
// the sun (anchors/lowtran7_paths_*, sky_*, direct_*). Scene: its midlatitude summer, rural aerosol of 23 km by its
// rules, ground at 0 km; Rayleigh scattering is raycube's own. Limits of AIR 8: 0.003, above 75 degrees 0.005.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <vector>

#include "atmos_tables/aerosol/aerosol_column.h"
#include "atmos_tables/gas/layer_gases.h"
#include "atmos_tables/optics/rayleigh_air.h"
#include "tests/support/anchor_rows.h"
#include "tests/support/curved_path.h"
#include "tests/support/lowtran_air.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

struct Path {
  const char* column;
  double low_km, high_km, zenith_deg, at_km;
};

/// One path, its amounts summed over the layers.
class Amounts {
 public:
  Amounts(const AirProfile& air, const AerosolColumn& aerosol, const Path& path)
      : level_km_(levels(path)),
        gases_(air, level_km_, BandModel::lowtran),
        slope_(testing::curved_path_factors(air, level_km_, path.zenith_deg, path.at_km)),
        aerosol_550_(aerosol.components()) {
    for (std::size_t i = 0; i < slope_.size(); ++i) {
      molecules_ += slope_[i] * air.air_column_per_cm2(level_km_[i], level_km_[i + 1]);
      for (std::size_t c = 0; c < aerosol_550_.size(); ++c)
        aerosol_550_[c] += slope_[i] * aerosol.depth_550(c, level_km_[i], level_km_[i + 1]);
    }
  }
  double transmittance(double v, double rayleigh_cm2, const std::vector<double>& extinction_ratio) const {
    double depth = gases_.line_depth(v, slope_) + molecules_ * rayleigh_cm2;
    for (std::size_t i = 0; i < slope_.size(); ++i) depth += slope_[i] * gases_.grey_depth(v, i);
    for (std::size_t c = 0; c < aerosol_550_.size(); ++c) depth += aerosol_550_[c] * extinction_ratio[c];
    return std::exp(-depth);
  }

 private:
  /// So thin that a layer has one slope of the ray, also at 85 degrees.
  static std::vector<double> levels(const Path& path) {
    std::vector<double> out;
    for (double z = path.low_km; z < path.high_km - 1e-9; z += z < 5 ? 0.25 : z < 50 ? 1 : 5) out.push_back(z);
    out.push_back(path.high_km);
    return out;
  }
  std::vector<double> level_km_;
  LayerGases gases_;
  std::vector<double> slope_, aerosol_550_;
  double molecules_ = 0;
};

}  // namespace

TEST_CASE("A-11 LOWTRAN7 bands alone: transmittances of paths, skies and suns of LOWTRAN7, 0.3 to 30 um") {
  const AirProfile air = testing::lowtran_air();
  AerosolSpec spec;
  spec.lowtran_rules = true;
  const AerosolColumn aerosol(spec, air);
  const std::vector<Path> to_ground = {{"T_0p61_180", 0, 0.61, 180, 0.61}, {"T_0p61_150", 0, 0.61, 150, 0.61},
                                       {"T_0p61_135", 0, 0.61, 135, 0.61}, {"T_3p0_180", 0, 3, 180, 3},
                                       {"T_3p0_150", 0, 3, 150, 3},        {"T_3p0_135", 0, 3, 135, 3},
                                       {"T_100_180", 0, 100, 180, 100}};
  const std::vector<Path> to_sky = {{"T_0", 0, 100, 0, 0},   {"T_30", 0, 100, 30, 0}, {"T_45", 0, 100, 45, 0},
                                    {"T_60", 0, 100, 60, 0}, {"T_75", 0, 100, 75, 0}, {"T_85", 0, 100, 85, 0}};
  const std::vector<Path> to_sun = {
      {"T_0.0_s40", 0, 100, 40, 0}, {"T_0.61_s40", 0.61, 100, 40, 0.61}, {"T_3.0_s40", 3, 100, 40, 3}};
  struct File {
    const char* name;
    const std::vector<Path>& paths;
  };
  for (const File& file :
       {File{"paths_vnir_swir", to_ground}, File{"paths_mwir_lwir", to_ground}, File{"sky_vnir_swir", to_sky},
        File{"sky_mwir_lwir", to_sky}, File{"direct_vnir_swir", to_sun}, File{"direct_mwir_lwir", to_sun}}) {
    auto rows = testing::anchor_rows("anchors/lowtran7_" + std::string(file.name) + ".csv",
                                     "paths were not compared with LOWTRAN7");
    if (rows.empty()) return;
    std::vector<Amounts> amounts;
    for (const Path& path : file.paths) amounts.emplace_back(air, aerosol, path);
    std::vector<double> worst(file.paths.size(), 0.0), place = worst, ratio(aerosol.components());
    for (testing::AnchorRow& row : rows) {
      const double v = row["nu_cm1"], rayleigh_cm2 = rayleigh_cross_section_cm2(1e4 / v, 330);
      for (std::size_t c = 0; c < ratio.size(); ++c) ratio[c] = aerosol.optics(c, 1e4 / v).extinction_ratio;
      for (std::size_t p = 0; p < amounts.size(); ++p) {
        const double error = amounts[p].transmittance(v, rayleigh_cm2, ratio) - row.at(file.paths[p].column);
        if (!(std::abs(error) <= std::abs(worst[p]))) worst[p] = error, place[p] = v;
      }
    }
    for (std::size_t p = 0; p < amounts.size(); ++p) {
      std::printf("%s %s: worst %+.4f at %g cm-1\n", file.name, file.paths[p].column, worst[p], place[p]);
      CAPTURE(file.paths[p].column);
      CHECK(std::abs(worst[p]) <= (file.paths[p].zenith_deg == 85 ? 0.005 : 0.003));
    }
  }
}
