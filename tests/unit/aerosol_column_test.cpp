// Aerosol columns. Oracles: Koschmieder's law, closed integrals, the stretch rule, MODTRAN 6's printed limits.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "atmos_tables/aerosol/aerosol_column.h"
#include "atmos_tables/aerosol/aerosol_heights.h"
#include "atmos_tables/optics/gauss_legendre.h"
#include "atmos_tables/optics/profile_scaling.h"
#include "atmos_tables/optics/standard_air.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"
#include "tests/support/relative.h"

using namespace raycube;
using namespace raycube::atmos;
using raycube::test::relative;
using raycube::testing::refusal;

namespace {

AirProfile summer() { return afgl_profile(AfglModel::midlatitude_summer); }

double total(const AerosolColumn& column, double low_km = -1, double high_km = 120) {
  double out = 0;
  for (std::size_t i = 0; i < column.components(); ++i) out += column.depth_550(i, low_km, high_km);
  return out;
}

}  // namespace

TEST_CASE("S4.5 aerosol: extinction at the ground follows Koschmieder's law at any visibility") {
  // The tables hold two to three digits (0.0662 for 0.06665 at 50 km, 0.77 for 0.7708 at 5 km): 0.7 %.
  for (double visibility : {0.2, 0.5, 2.0, 3.0, 5.0, 8.0, 10.0, 17.0, 23.0, 35.0, 50.0}) {
    AerosolSpec spec;
    spec.visibility_km = visibility;
    CAPTURE(visibility);
    CHECK(relative(AerosolColumn(spec, summer()).extinction_550_per_km(0, 0),
                   koschmieder_extinction_per_km(visibility)) <= 7e-3);
  }
  CHECK(koschmieder_extinction_per_km(23) == doctest::Approx(0.158497).epsilon(1e-5));
}

TEST_CASE("S4.5 aerosol: depths are exact integrals of the profile, and add up") {
  const AerosolColumn column(AerosolSpec{}, summer());
  REQUIRE(column.components() == 4);
  const auto exponential = [](double low, double high) { return (low - high) / std::log(low / high); };
  CHECK(column.depth_550(0, 0, 1) == doctest::Approx(exponential(0.158, 0.0991)).epsilon(1e-12));
  CHECK(column.depth_550(0, 1, 2) == doctest::Approx(exponential(0.0991, 0.0621)).epsilon(1e-12));
  CHECK(column.depth_550(0, 2, 3) == doctest::Approx(0.0621 / 2).epsilon(1e-12));  // falls linearly to 0
  CHECK(column.depth_550(1, 2, 3) == doctest::Approx(0.0346 / 2).epsilon(1e-12));  // and the next rises
  CHECK(column.depth_550(0, 2.25, 2.5) == doctest::Approx(0.25 * 0.0621 * (0.75 + 0.5) / 2).epsilon(1e-12));
  CHECK(column.depth_550(0, 3, 120) == 0);
  CHECK(column.extinction_550_per_km(2, 13) == doctest::Approx(5.17e-4));
  for (std::size_t i = 0; i < 4; ++i) {
    // Against a sum over thin slices of the extinction itself: midpoint rule, second order in 1 cm / scale height.
    double sum = 0;
    const double step = 0.002;
    for (double z = step / 2; z < 110; z += step) sum += step * column.extinction_550_per_km(i, z);
    CHECK(relative(column.depth_550(i, 0, 110), sum) <= 1e-4);
    CHECK(column.depth_550(i, 0, 110) ==
          doctest::Approx(column.depth_550(i, 0, 2.7) + column.depth_550(i, 2.7, 33) + column.depth_550(i, 33, 110))
              .epsilon(1e-12));
  }
}

TEST_CASE("S4.5 aerosol: a ground at 0.35 km moves the top of the boundary layer from 2 to 2.23 km; kinks are levels") {
  const AirProfile raised = cut_at_ground(summer(), 0.35);
  AerosolSpec spec;
  spec.clouds = {{1.0, 1.5, 2.0, CloudKind::stratus}};
  const AerosolColumn column(spec, raised);
  const std::vector<double> levels = column.level_km();
  CHECK(std::is_sorted(levels.begin(), levels.end()));
  CHECK(std::adjacent_find(levels.begin(), levels.end()) == levels.end());
  // MODTRAN 6 lists 1.2916667, 2.2333333, 3.1750000, 4.1166667, 5.0583333, 6 for this ground.
  for (double height : {0.35, 1.2916667, 2.2333333, 3.175, 4.1166667, 5.0583333, 6.0, 7.0, 10.0, 11.0, 25.0, 30.0, 35.0,
                        100.0, 1.0, 1.5})
    CHECK(std::any_of(levels.begin(), levels.end(), [&](double level) { return std::abs(level - height) <= 1e-6; }));
  CHECK(column.extinction_550_per_km(0, 0.35) == doctest::Approx(0.158));
  CHECK(column.extinction_550_per_km(0, 0.35 + 2 * 5.65 / 6) == doctest::Approx(0.0621));
  const AerosolColumn sea(AerosolSpec{}, summer());
  CHECK(column.depth_550(0, 0, 120) == doctest::Approx(sea.depth_550(0, 0, 120) * 5.65 / 6).epsilon(1e-12));
  CHECK(column.depth_550(2, 0, 120) == doctest::Approx(sea.depth_550(2, 0, 120)).epsilon(1e-12));
  CHECK(column.depth_550(4, 0, 120) == doctest::Approx(2).epsilon(1e-12));
  CHECK(column.depth_550(4, 1.1, 1.3) == doctest::Approx(0.8).epsilon(1e-12));
}

TEST_CASE(
    "S4.5 aerosol: an optical depth sets the visibility; below the least depth all heights are scaled, with a notice") {
  for (double wanted : {0.06, 0.1, 0.3247, 0.8, 3.0}) {
    AerosolSpec spec;
    spec.aod_550 = wanted;
    const AerosolColumn column(spec, summer());
    CHECK(relative(total(column), wanted) <= 1e-9);
    CHECK(column.notices().empty());
    AerosolSpec by_visibility;
    by_visibility.visibility_km = column.visibility_km();
    CHECK(relative(total(AerosolColumn(by_visibility, summer())), wanted) <= 1e-9);
  }
  // MODTRAN 6, ground 0.35 km: largest visibility 323.57751 km, least depth 0.039 (three digits).
  CHECK(max_visibility_km() == doctest::Approx(323.57751).epsilon(1e-6));
  AerosolSpec spec;
  spec.aod_550 = 0.01;
  const AerosolColumn column(spec, cut_at_ground(summer(), 0.35));
  CHECK(column.visibility_km() == max_visibility_km());
  CHECK(relative(total(column), 0.01) <= 1e-12);
  REQUIRE(column.notices().size() == 1);
  CHECK(column.notices()[0].find("less than the 0.0389") != std::string::npos);
  spec.aod_550 = 0;
  CHECK(total(AerosolColumn(spec, summer())) == 0);
  spec.aod_550 = -1, spec.visibility_km = 1000;
  CHECK(AerosolColumn(spec, summer()).notices().size() == 1);
}

TEST_CASE("S4.5 aerosol: optics between humidities are log-linear in ln(100 - RH), between wavelengths power laws") {
  const Substance low("rural", 70), high("rural", 80);
  const double middle = 100 - std::sqrt(30.0 * 20.0);  // the middle of 70 and 80 % in that coordinate
  const Substance between_two("rural", middle);
  for (double wave : {0.3, 0.55, 1.06, 2.0, 3.0, 10.0}) {  // nodes of the table
    const SubstanceOptics a = low.at(wave), b = high.at(wave), m = between_two.at(wave);
    CHECK(m.extinction == doctest::Approx(std::sqrt(a.extinction * b.extinction)).epsilon(1e-12));
    CHECK(m.absorption == doctest::Approx(std::sqrt(a.absorption * b.absorption)).epsilon(1e-12));
    CHECK(m.asymmetry == doctest::Approx(std::sqrt(a.asymmetry * b.asymmetry)).epsilon(1e-12));
  }
  CHECK(low.at(0.55).extinction == 1);
  CHECK(low.at(0.62215, BetweenWaves::linear).extinction == doctest::Approx((1 + 0.75316) / 2).epsilon(1e-12));
  // Angstrom's law through 0.55 and 0.6943 um.
  const double exponent = -std::log(0.75316) / std::log(0.6943 / 0.55);
  CHECK(low.at(0.6).extinction == doctest::Approx(std::pow(0.6 / 0.55, -exponent)).epsilon(1e-12));
  // Water grows on the particles: more scattering, less absorption, more forward.
  for (double humidity = 5; humidity <= 95; humidity += 10) {
    const SubstanceOptics dry = Substance("rural", humidity).at(0.55), wet = Substance("rural", humidity + 4).at(0.55);
    CHECK(wet.absorption < dry.absorption);
    CHECK(wet.asymmetry > dry.asymmetry);
  }
  const Substance calm("desert", 10), storm("desert", 30), half("desert", 20);
  CHECK(calm.at(0.55).extinction == doctest::Approx(1).epsilon(1e-12));
  CHECK(storm.at(0.55).extinction == doctest::Approx(1).epsilon(1e-12));
  CHECK(storm.at(0.4).absorption > calm.at(0.4).absorption);
  CHECK(!half.has_phase());
}

TEST_CASE("S4.5 aerosol: models, seasons and volcanoes") {
  for (AerosolModel model : {AerosolModel::rural, AerosolModel::urban, AerosolModel::maritime, AerosolModel::desert,
                             AerosolModel::tropospheric, AerosolModel::fog_advective, AerosolModel::fog_radiative}) {
    AerosolSpec spec;
    spec.boundary = model;
    CHECK(parse_aerosol(to_string(model)) == model);
    const AerosolColumn column(spec, summer());
    for (std::size_t i = 0; i < column.components(); ++i)
      for (double wave : {0.2, 0.4, 0.55, 1.6, 3.3, 10.0, 30.0, 200.0}) {
        const AerosolColumn::Optics at = column.optics(i, wave);
        CHECK(at.extinction_ratio > 0);
        CHECK(at.scattering_albedo >= 0);
        CHECK(at.scattering_albedo <= 1);
        CHECK(column.backscatter_per_sr(i, wave) >= 0);
        CHECK(std::abs(at.phase->moments(1)[0] - 1) <= 1e-12);
        if (wave == 0.55) CHECK(at.extinction_ratio == doctest::Approx(1).epsilon(1e-12));
      }
  }
  const auto depth = [](StratosphereModel model, bool spring_summer) {
    AerosolSpec spec;
    spec.stratosphere = model, spec.spring_summer = spring_summer;
    CHECK(parse_stratosphere(to_string(model)) == model);
    return AerosolColumn(spec, summer()).depth_550(2, 0, 120);
  };
  for (bool season : {true, false}) {
    CHECK(depth(StratosphereModel::background, season) < depth(StratosphereModel::moderate_volcanic, season));
    CHECK(depth(StratosphereModel::moderate_volcanic, season) < depth(StratosphereModel::high_volcanic, season));
    CHECK(depth(StratosphereModel::high_volcanic, season) < depth(StratosphereModel::extreme_volcanic, season));
  }
  AerosolSpec winter;
  winter.spring_summer = false;
  CHECK(AerosolColumn(winter, summer()).depth_550(1, 0, 120) <
        AerosolColumn(AerosolSpec{}, summer()).depth_550(1, 0, 120));
  AerosolSpec none;
  none.boundary = AerosolModel::none;
  CHECK(AerosolColumn(none, summer()).components() == 0);
  CHECK(AerosolColumn(none, summer()).level_km().empty());
}

TEST_CASE(
    "S4.5 fog and clouds: layers with their own depth; water clouds scatter back like droplets, not like "
    "Henyey-Greenstein") {
  AerosolSpec spec;
  spec.boundary = AerosolModel::none;
  for (std::size_t kind = 0; kind < kCloudNames.size(); ++kind)
    spec.clouds.push_back({1.0 + static_cast<double>(kind), 1.5 + static_cast<double>(kind),
                           0.1 * static_cast<double>(kind + 1), parse_cloud(kCloudNames[kind])});
  const AerosolColumn column(spec, summer());
  REQUIRE(column.components() == 9);
  CHECK(column.level_km().size() == 18);
  CHECK(column.notices().size() == 2);  // ice
  for (std::size_t i = 0; i < 9; ++i) {
    CAPTURE(column.name(i));
    CHECK(column.name(i) == kCloudNames[i]);
    CHECK(column.depth_550(i, 0, 120) == doctest::Approx(0.1 * static_cast<double>(i + 1)).epsilon(1e-12));
    const AerosolColumn::Optics at = column.optics(i, 0.532);
    CHECK(at.scattering_albedo > 0.99);
    CHECK(at.extinction_ratio ==
          doctest::Approx(1).epsilon(0.02));  // droplets far larger than the wavelength: extinction is grey
    if (i < 5) {
      CHECK(std::abs(at.phase->asymmetry() - at.asymmetry) <= 0.015);
      // Measured lidar ratio of water clouds at 0.532 um: 18.8 sr +- 0.8 (O'Connor et al. 2004, J. Atmos. Oceanic
      // Technol. 21, 777); the figures' droplets give 17.7 and 19.3.
      CHECK(std::abs(at.extinction_ratio / column.backscatter_per_sr(i, 0.532) - 18.8) <= 1.5);
    }
  }
}

TEST_CASE("S4.5 aerosol: bad figures are listed together") {
  AerosolSpec spec;
  spec.visibility_km = -3, spec.humidity_percent = 130, spec.boundary = AerosolModel::desert, spec.wind_m_s = 80;
  spec.clouds = {{2, 1, -1, CloudKind::cumulus},
                 {1, 300, std::numeric_limits<double>::quiet_NaN(), CloudKind::cumulus}};
  const std::string found = refusal([&] { AerosolColumn(spec, summer()); });
  for (const char* part : {"visibility", "-3", "humidity", "130", "wind", "80", "cloud 1", "base must lie below top",
                           "cloud 2", "300", "nan"})
    CHECK_MESSAGE(found.find(part) != std::string::npos, part, " in ", found);
  spec = {};
  spec.aod_550 = std::numeric_limits<double>::quiet_NaN();
  CHECK(refusal([&] { AerosolColumn(spec, summer()); }).find("optical depth") != std::string::npos);
  spec.aod_550 = 1e4;
  CHECK(refusal([&] { AerosolColumn(spec, summer()); }).find("at most") != std::string::npos);
  spec = {};
  const std::string high = refusal([&] { AerosolColumn(spec, cut_at_ground(summer(), 5.8)); });
  CHECK(high.find("ground altitude") != std::string::npos);
  CHECK(refusal([&] { AerosolColumn(AerosolSpec{}, summer()).optics(0, 0.1); }).find("0.2 to 200") !=
        std::string::npos);
  CHECK(refusal([] { parse_aerosol("smoke"); }).find("rural") != std::string::npos);
  AerosolSpec wet;
  wet.humidity_percent = 100;
  const AerosolColumn column(wet, summer());
  CHECK(column.humidity_percent() == 99);
  CHECK(column.notices().size() == 1);
}
