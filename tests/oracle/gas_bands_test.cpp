// Band models, grey gases and layers without reference files. Oracles: limits and series of the closed forms, Beer's
// law, the ray of a homogeneous column, values of LOWTRAN7 restated here by hand.
#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "atmos_tables/gas/layer_gases.h"
#include "atmos_tables/gas/trace_air.h"
#include "atmos_tables/optics/standard_air.h"
#include "host/base/error.h"
#include "tests/support/relative.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::test::relative;

namespace {

template <class Change>
AirProfile changed(const AirProfile& profile, Change&& change) {
  std::vector<AirLevel> levels = profile.levels();
  for (AirLevel& level : levels) change(level);
  return AirProfile(levels, "changed");
}

std::vector<double> levels_between(const AirProfile& profile, double low_km, double high_km) {
  std::vector<double> out;
  for (const AirLevel& level : profile.levels())
    if (level.height_km >= low_km && level.height_km <= high_km) out.push_back(level.height_km);
  return out;
}

std::vector<double> whole(const LayerGases& gases, double factor = 1) {
  return std::vector<double>(gases.layers(), factor);
}

double grey_column(const LayerGases& gases, double wavenumber) {
  double sum = 0;
  for (std::size_t i = 0; i < gases.layers(); ++i) sum += gases.grey_depth(wavenumber, i);
  return sum;
}

}  // namespace

TEST_CASE("S4.4 random bands: Beer's law for few molecules, square root for many, Malkmus' series between") {
  const double a1 = 3.2e-2, a2 = 0.11;
  for (double pressure : {0.01, 0.3, 1.0})
    for (auto depth : {goody_depth, malkmus_depth}) {
      CHECK(relative(depth(a1, a2, 1e-9, 1e-9 * pressure), a1 * 1e-9) <= 1e-7);
      CHECK(relative(depth(a1, a2, 1e9, 1e9 * pressure), std::sqrt(a1 * a2 * 1e9 * pressure)) <= 1e-3);
      CHECK(depth(a1, a2, 0, 0) == 0);
      CHECK(depth(a1, a2, 1, 0) == 0);
      CHECK(std::isfinite(depth(a1, a2, 1e300, 1e300 * pressure)));
      CHECK(depth(a1, a2, 1e-300, 1e-300 * pressure) >= 0);
    }
  // As the 6S papers print them, where no digits are lost.
  const double u = 4.0, up = 2.5;
  CHECK(relative(goody_depth(a1, a2, u, up), a1 * u / std::sqrt(1 + a1 / a2 * u * u / up)) <= 1e-14);
  CHECK(relative(malkmus_depth(a1, a2, u, up), a2 * up / (2 * u) * (std::sqrt(1 + 4 * a1 / a2 * u * u / up) - 1)) <=
        1e-12);
  CHECK(relative(power_law_depth(-1, 40, 0.5), 2.0) <= 1e-14);
  CHECK(power_law_depth(3, 0, 0.5) == 0);
}

TEST_CASE("S4.4 a bin of 6S by hand: water after Goody, carbon dioxide after Malkmus, at 280 K and 800 hPa") {
  AirLevel low;
  low.pressure_hPa = 800, low.temperature_K = 280, low.air_per_cm3 = 2.07e19;
  AirLevel high = low;
  high.height_km = 0.01, high.pressure_hPa = 799.9999;
  const double factor = 250, t = 280 - 250;  // of 10 m, and K above the fit's middle
  struct Bin {
    Gas gas;
    double wavenumber, per_cm3, g_mol, a1, a2, a3, a4, a5, a6;
  };
  // Figures of 6S (Vermote et al. 1997). At 2.02 and 2.22 um q is 1, so LOWTRAN7 does not enter.
  for (const Bin& bin : {Bin{Gas::h2o, 4505, 3e17, 18.0153, 2.23170e-03, 1.52290e-01, 1.25350e-02, -1.37950e-05,
                             1.08750e-02, -3.71230e-05},
                         Bin{Gas::co2, 4955, 8e15, 44.0095, 6.36400, 3.84630e-01, 2.42250e-03, -1.70140e-05,
                             5.11560e-03, -1.36770e-05}}) {
    low.gas_per_cm3 = {}, high.gas_per_cm3 = {};
    low.gas(bin.gas) = high.gas(bin.gas) = bin.per_cm3;
    const LayerGases gases(AirProfile({low, high}, "ten metres"), {0, 0.01});
    const double column = factor * 1e3 * bin.per_cm3 * bin.g_mol / 6.02214076e23;  // g cm-2
    const double u = column * std::exp(bin.a3 * t + bin.a4 * t * t),
                 up = column * std::exp(bin.a5 * t + bin.a6 * t * t) * 800 / 1013.25;
    const double weak = bin.a1 / bin.a2 * u * u / up;
    const double depth =
        bin.gas == Gas::h2o ? bin.a1 * u / std::sqrt(1 + weak) : bin.a2 * up / (2 * u) * (std::sqrt(1 + 4 * weak) - 1);
    // Shipped figures are rounded: 1.2e-4 of a1 and a2, less of the others.
    CHECK(relative(gases.line_depth(bin.wavenumber, whole(gases, factor)), depth) <= 3e-4);
  }
}

TEST_CASE("AIR 2 the blend: one number per band, ramps of 50 cm-1, LOWTRAN7 alone outside 2500 to 17250 cm-1") {
  const auto at_um = [](double um) { return blend_weight(1e4 / um); };
  CHECK(relative(at_um(0.70), 0.75) <= 1e-12);
  CHECK(relative(at_um(1.15), 0.65) <= 1e-12);
  CHECK(relative(at_um(1.50), 0.4) <= 1e-12);
  CHECK(relative(at_um(1.90), 0.6) <= 1e-12);
  CHECK(relative(at_um(2.20), 1.0) <= 1e-12);
  CHECK(relative(at_um(2.70), 0.5) <= 1e-12);
  CHECK(relative(at_um(3.20), 0.25) <= 1e-12);
  CHECK(relative(at_um(3.70), 0.5) <= 1e-12);
  CHECK(relative(at_um(2.0), 0.8) <= 1e-12);  // the middle of a ramp
  CHECK(blend_weight(2500) == 0);
  CHECK(std::abs(blend_weight(17250)) <= 1e-12);
  for (double v = 300; v < 20000; v += 1) {
    CHECK((blend_weight(v) >= 0 && blend_weight(v) <= 1 + 1e-12));
    CHECK(std::abs(blend_weight(v + 1) - blend_weight(v)) <= 0.75 / 50 + 1e-12);
  }
}

TEST_CASE("S4.4 columns: water 2.92 g cm-2 and ozone of midlatitude summer, whatever the layers") {
  const AirProfile air = afgl_profile(AfglModel::midlatitude_summer);
  CHECK(std::abs(air.water_g_cm2() - 2.92) <= 0.005);
  // LOWTRAN7 has 33 of the 50 levels and finds 0.3317 atm-cm with them; all levels hold 0.8 % more.
  CHECK(std::abs(air.ozone_atm_cm() - 0.3317) <= 0.01 * 0.3317);
  const LayerGases fine(air, levels_between(air, 0, 100)), coarse(air, {0, 3, 25, 100});
  for (double v : {900.0, 1040.0, 2145.0, 3000.0, 5000.0, 7300.0, 9000.0, 13100.0, 16500.0}) {
    CHECK(relative(coarse.line_depth(v, whole(coarse)), fine.line_depth(v, whole(fine))) <= 1e-9);
    CHECK(std::abs(grey_column(coarse, v) - grey_column(fine, v)) <= 1e-9 * grey_column(fine, v));
  }
  // Ozone is grey in the visible: Chappuis at 16600 cm-1 has 0.129 per atm-cm (LOWTRAN7's figure), and nothing else
  // absorbs there but the far wing of the water continuum.
  CHECK(std::abs(grey_column(fine, 16600) / air.ozone_atm_cm() - 0.129) <= 0.002);
}

TEST_CASE("S4.4 spot values of LOWTRAN7: vertical path of 3 km, midlatitude summer") {
  const AirProfile air = afgl_profile(AfglModel::midlatitude_summer);
  const LayerGases gases(air, {0, 1, 2, 3}, BandModel::lowtran);
  const AirProfile dry = changed(air, [](AirLevel& level) { level.gas(Gas::h2o) = 0; });
  // Product of the component transmittances of lines (water, mixed gases, ozone in the infrared, trace); its program
  // prints 5 digits.
  struct Spot {
    double wavenumber, lines, water_continuum;
  };
  for (const Spot& spot : {Spot{700, 0.00212, 0.41154}, Spot{820, 0.89424, 0.65799}, Spot{1000, 0.93401, 0.83253},
                           Spot{1250, 0.40201, 0.70334}, Spot{2145, 0.68259, 0.92388}, Spot{2500, 0.97131, 0.96737},
                           Spot{2980, 0.39541, 0.88504}, Spot{3300, 0.19797, 0.72128}, Spot{4320, 0.89260, 0.96745},
                           Spot{5900, 0.96625, 0.98798}, Spot{8820, 0.16394, 0.75962}, Spot{10600, 0.38519, 0.89835},
                           Spot{13100, 0.63795, 1.00000}, Spot{16500, 0.99977, 1.00000}}) {
    CAPTURE(spot.wavenumber);
    // The component tests of S3.2: 3.3e-4 water lines, 1.9e-4 mixed gases, 7e-5 ozone; 0.09 % in density from p / T
    // (gas_lowtran).
    CHECK(std::abs(gases.line_transmission(spot.wavenumber, spot.wavenumber, whole(gases)) - spot.lines) <= 6e-4);
    const double others =
        spot.wavenumber > 2000 && spot.wavenumber < 2800 ? grey_column(LayerGases(dry, {0, 3}), spot.wavenumber) : 0;
    CHECK(std::abs(std::exp(others - grey_column(gases, spot.wavenumber)) - spot.water_continuum) <= 2.5e-3);
  }
}

TEST_CASE("S4.4 limits: no water, no path, endless path") {
  const AirProfile air = afgl_profile(AfglModel::tropical);
  const AirProfile dry = changed(air, [](AirLevel& level) { level.gas(Gas::h2o) = 0; });
  for (BandModel model : {BandModel::blended, BandModel::lowtran}) {
    const LayerGases wet(air, {0, 1, 5, 20, 100}, model), none(dry, {0, 1, 5, 20, 100}, model);
    for (double v = 300; v < 18000; v += 55) {
      const double depth = wet.line_depth(v, whole(wet));
      CHECK(none.line_depth(v, whole(none)) <= depth);
      CHECK(wet.line_depth(v, whole(wet, 0)) == 0);
      CHECK(wet.line_transmission(v, v + 20, whole(wet, 0)) == 1);
      CHECK(std::isfinite(wet.line_depth(v, whole(wet, 1e30))));
      CHECK(std::isfinite(wet.mean_line_depth(v, v + 40, whole(wet, 1e30))));
      if (depth > 1e-3) CHECK(wet.line_transmission(v, v, whole(wet, 1e30)) == 0);
      CHECK(grey_column(none, v) <= grey_column(wet, v));
    }
    CHECK(none.line_depth(7150, whole(none)) == 0);  // 1.40 um belongs to water alone
  }
}

TEST_CASE("S4.4 more path never transmits more, and a longer path gains less than Beer's law would take") {
  const AirProfile air = afgl_profile(AfglModel::us_standard);
  const LayerGases gases(air, {0, 0.5, 2, 6, 12, 30, 80});
  for (double v = 340; v < 17860; v += 35) {
    const double once = gases.line_depth(v, whole(gases)), twice = gases.line_depth(v, whole(gases, 2));
    CHECK(twice >= once);
    CHECK(twice <= 2 * once * (1 + 1e-12));  // S5.3: T(sun and view) > T(sun) T(view)
    double before = 0;
    for (std::size_t top = 0; top <= gases.layers(); ++top) {
      std::vector<double> path(gases.layers(), 0.0);
      for (std::size_t i = 0; i < top; ++i) path[i] = 1.3;
      const double depth = gases.line_depth(v, path);
      CHECK(depth >= before);
      before = depth;
    }
  }
}

TEST_CASE("S4.4 bins: the mean lies between the ends' values, halves join to the whole, bins outside are clear") {
  const AirProfile air = afgl_profile(AfglModel::midlatitude_summer);
  const LayerGases gases(air, {0, 2, 10, 50});
  const auto mean = [&](double low, double high) { return gases.line_transmission(low, high, whole(gases)); };
  for (double low : {2001.0, 4317.5, 9871.3, 12987.0}) {
    const double joined = 0.4 * mean(low, low + 40) + 0.6 * mean(low + 40, low + 100);
    CHECK(std::abs(joined - mean(low, low + 100)) <= 2e-3);  // the trapezoid splits a step of 5 cm-1 at the joint
    CHECK(relative(mean(low, low), std::exp(-gases.line_depth(low, whole(gases)))) <= 1e-12);
  }
  CHECK(mean(18000, 19000) == 1);
  CHECK(mean(200, 320) == 1);
  const double over_edge = mean(17800, 17920);
  CHECK(relative(over_edge, 0.5 * mean(17800, 17860) + 0.5) <= 1e-12);
}

TEST_CASE("S4.4 grey gases: Beer's law, layers add up, nothing where no figures are") {
  const AirProfile air = afgl_profile(AfglModel::midlatitude_winter);
  const LayerGases one(air, {0, 100}), many(air, levels_between(air, 0, 100));
  for (double v : {350.0, 880.0, 1000.0, 1320.0, 1580.0, 2400.0, 4000.0, 16000.0, 20000.0, 30000.0, 33390.0, 33410.0,
                   38000.0, 45000.0}) {
    CHECK(grey_column(one, v) > 0);
    CHECK(relative(grey_column(many, v), one.grey_depth(v, 0)) <= 1e-9);
  }
  for (double v : {250.0, 25500.0, 51000.0}) CHECK(one.grey_depth(v, 0) == 0);
  // Twice the ozone, twice its depth; the water continuum by water grows with the square of water.
  const AirProfile ozone = changed(air, [](AirLevel& level) { level.gas(Gas::o3) *= 2; });
  CHECK(relative(LayerGases(ozone, {0, 100}).grey_depth(31000, 0), 2 * one.grey_depth(31000, 0)) <= 1e-12);
  const AirProfile wet = changed(air, [](AirLevel& level) { level.gas(Gas::h2o) *= 2; });
  const double growth = LayerGases(wet, {0, 100}).grey_depth(1000, 0) / one.grey_depth(1000, 0);
  CHECK((growth > 2 && growth < 4));
  // Hotter than the continuum's straight line in temperature allows: never below 0.
  const AirProfile hot = changed(air, [](AirLevel& level) { level.temperature_K = 900; });
  for (double v = 330; v < 17860; v += 10) CHECK(LayerGases(hot, {0, 1}).grey_depth(v, 0) >= 0);
}

TEST_CASE("S4.4 trace gases: the figures at their heights, exponential between, the ends beyond") {
  CHECK(relative(trace_air(0).so2_ppmv, 3e-4) <= 1e-12);
  CHECK(relative(trace_air(2).hno3_ppmv, 6.93e-5) <= 1e-12);
  CHECK(relative(trace_air(2.5).nh3_ppmv, std::sqrt(4.63e-4 * 3.8e-4)) <= 1e-12);
  CHECK(relative(trace_air(-0.5).no_ppmv, 3e-4) <= 1e-12);
  CHECK(relative(trace_air(130).no_ppmv, 10) <= 1e-12);
}

TEST_CASE("S4.4 layers that cannot be: every fault in one message; path factors that do not fit") {
  const AirProfile air = afgl_profile(AfglModel::tropical);
  const auto message = [&](const std::vector<double>& levels) -> std::string {
    try {
      LayerGases(air, levels);
    } catch (const base::Error& error) {
      return error.what();
    }
    return "";
  };
  const std::string text = message({-2, 5, 5, 200});
  CHECK(text.find("-2.0") != std::string::npos);
  CHECK(text.find("200.0") != std::string::npos);
  CHECK(text.find("ascend") != std::string::npos);
  CHECK(message({3}).find("at least 2") != std::string::npos);
  const LayerGases gases(air, {0, 1, 2});
  CHECK_THROWS_AS(gases.line_depth(5000, {1}), base::Error);
  CHECK_THROWS_AS(gases.line_depth(5000, {1, -1}), base::Error);
  CHECK_THROWS_AS(gases.line_transmission(5000, 4000, {1, 1}), base::Error);
}
