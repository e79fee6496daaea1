// transmittance of the whole air against MODTRAN 5.2.1 (anchors/modtran521_pybsm_mls_rural.csv). Scene: midlatitude summer,
// rural aerosol of 23 km, CO2 360 ppmv, paths straight down from 1, 2 and 20 km to the sea; triangular slit, 20 nm wide, every
// 10 nm. Limits: rms error of S3.2 times 1.3 for the blend (0.58 to 3.96 um); mean error of S3.1 plus 0.01 where LOWTRAN7 stands
// alone.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <initializer_list>
#include <vector>

#include "atmos_tables/aerosol/aerosol_column.h"
#include "atmos_tables/gas/layer_gases.h"
#include "atmos_tables/optics/profile_scaling.h"
#include "atmos_tables/optics/rayleigh_air.h"
#include "atmos_tables/optics/standard_air.h"
#include "tests/support/anchor_rows.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

/// The air below one height, looking straight down.
class Path {
 public:
  Path(const AirProfile& air, const AerosolColumn& aerosol, double top_km)
      : air_(air), aerosol_(aerosol), top_km_(top_km), gases_(air, levels(top_km)), once_(gases_.layers(), 1.0) {}

  double transmittance(double wavenumber) const {
    const double um = 1e4 / wavenumber;
    double depth = gases_.line_depth(wavenumber, once_);
    for (std::size_t i = 0; i < gases_.layers(); ++i) depth += gases_.grey_depth(wavenumber, i);
    depth += rayleigh_depth_above(air_, 0, um) - rayleigh_depth_above(air_, top_km_, um);
    for (std::size_t c = 0; c < aerosol_.components(); ++c) {
      const double depth_550 = aerosol_.depth_550(c, 0, top_km_);
      if (depth_550 > 0) depth += depth_550 * aerosol_.optics(c, um).extinction_ratio;
    }
    return std::exp(-depth);
  }

  /// Triangular slit of 20 nm full width at half maximum.
  double at_um(double um) const {
    constexpr double half_base = 0.02;
    const int points = std::max(16, 2 * static_cast<int>(half_base * 1e4 / (um * um) / 5));  // finer than the model's 5 cm-1
    double sum = 0, weights = 0;
    for (int k = 1 - points; k < points; ++k) {
      const double weight = points - std::abs(k);
      sum += weight * transmittance(1e4 / (um + k * half_base / points)), weights += weight;
    }
    return sum / weights;
  }

 private:
  static std::vector<double> levels(double top_km) {
    std::vector<double> out;
    for (double z = 0; z < top_km; z += 1) out.push_back(z);
    out.push_back(top_km);
    return out;
  }
  const AirProfile& air_;
  const AerosolColumn& aerosol_;
  double top_km_;
  LayerGases gases_;
  std::vector<double> once_;
};

struct Band {
  double from_um, to_um;
  std::array<double, 3> limit;  ///< at 1, 2, 20 km
};

struct Errors {
  double mean = 0, rms = 0;
};

}  // namespace

TEST_CASE("A-13 S3.1 S3.2 transmittance against MODTRAN 5.2.1 at 1, 2 and 20 km") {
  auto rows = testing::anchor_rows("anchors/modtran521_pybsm_mls_rural.csv", "gases were not compared with MODTRAN 5.2.1");
  if (rows.empty()) return;
  const AirProfile air = with_ground_mixing_ratio(afgl_profile(AfglModel::midlatitude_summer), Gas::co2, 360);
  const AerosolColumn aerosol(AerosolSpec{}, air);
  const Path paths[] = {{air, aerosol, 1}, {air, aerosol, 2}, {air, aerosol, 20}};
  const char* columns[] = {"T_h1000_g0_v23", "T_h2000_g0_v23", "T_h20000_g0p3_v23"};
  const auto errors = [&](const Band& band) {
    std::array<Errors, 3> out;
    for (std::size_t p = 0; p < 3; ++p) {
      int count = 0;
      for (testing::AnchorRow& row : rows) {
        const double um = row["wavelength_um"];
        if (um < band.from_um - 1e-6 || um > band.to_um - 1e-6) continue;
        const double error = paths[p].at_um(um) - row.at(columns[p]);
        out[p].mean += error, out[p].rms += error * error, ++count;
      }
      out[p].mean /= count, out[p].rms = std::sqrt(out[p].rms / count);
    }
    std::printf("%5.2f-%5.2f um: mean %+.4f %+.4f %+.4f rms %.4f %.4f %.4f\n", band.from_um, band.to_um, out[0].mean, out[1].mean,
                out[2].mean, out[0].rms, out[1].rms, out[2].rms);
    return out;
  };

  SUBCASE("blend") {
    for (const Band& band : {Band{0.58, 0.70, {.0015, .002, .003}}, Band{0.7, 1.0, {.004, .005, .007}}, Band{1.0, 1.3, {.006, .007, .014}},
                             Band{1.3, 1.5, {.014, .015, .017}}, Band{1.45, 1.75, {.009, .012, .015}}, Band{1.75, 2.0, {.012, .012, .015}},
                             Band{2.0, 2.4, {.011, .016, .022}}, Band{2.4, 3.0, {.013, .011, .010}}, Band{3.0, 3.4, {.030, .028, .026}},
                             Band{3.4, 3.96, {.026, .028, .029}}}) {
      const auto found = errors(band);
      CAPTURE(band.from_um);
      for (std::size_t p = 0; p < 3; ++p) CHECK(found[p].rms <= 1.3 * band.limit[p]);
    }
  }
  SUBCASE("thermal windows") {
    for (const Band& band : {Band{4.4, 4.6, {-.023, -.014, -.006}}, Band{4.6, 4.8, {-.028, -.026, -.012}}, Band{8.0, 8.5, {-.047, -.051, -.048}},
                             Band{8.5, 9.0, {-.002, -.007, -.015}}, Band{9.0, 9.4, {-.003, -.004, -.006}}, Band{9.4, 10, {-.021, -.022, .059}},
                             Band{10, 10.5, {-.006, -.002, -.007}}, Band{10.5, 11, {.012, .019, .023}}, Band{11, 11.5, {.018, .024, .026}},
                             Band{11.5, 12, {.020, .024, .027}}, Band{12, 12.5, {-.001, .001, -.003}}, Band{12.5, 13, {.036, .038, .030}},
                             Band{8, 13, {-.005, -.005, .005}}}) {
      const auto found = errors(band);
      CAPTURE(band.from_um);
      for (std::size_t p = 0; p < 3; ++p) CHECK(std::abs(found[p].mean) <= std::abs(band.limit[p]) + 0.01);
    }
  }
}
