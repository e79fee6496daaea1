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

using namespace raycube;
using namespace raycube::atmos;

namespace {

double relative(double value, double truth) { return std::abs(value - truth) / std::abs(truth); }

AirProfile summer() { return afgl_profile(AfglModel::midlatitude_summer); }

double total(const AerosolColumn& column, double low_km = -1, double high_km = 120) {
  double out = 0;
  for (std::size_t i = 0; i < column.components(); ++i) out += column.depth_550(i, low_km, high_km);
  return out;
}

template <class Action>
std::string message(Action&& action) {
  try {
    action();
  } catch (const base::Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("S4.5 aerosol: extinction at the ground follows Koschmieder's law at any visibility") {
  // The tables hold two to three digits (0.0662 for 0.06665 at 50 km, 0.77 for 0.7708 at 5 km): 0.7 %.
  for (double visibility : {0.2, 0.5, 2.0, 3.0, 5.0, 8.0, 10.0, 17.0, 23.0, 35.0, 50.0}) {
    AerosolSpec spec;
    spec.visibility_km = visibility;
    CAPTURE(visibility);
    CHECK(relative(AerosolColumn(spec, summer()).extinction_550_per_km(0, 0), koschmieder_extinction_per_km(visibility)) <=
          7e-3);
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
  for (double height :
       {0.35, 1.2916667, 2.2333333, 3.175, 4.1166667, 5.0583333, 6.0, 7.0, 10.0, 11.0, 25.0, 30.0, 35.0, 100.0, 1.0, 1.5})
    CHECK(std::any_of(levels.begin(), levels.end(), [&](double level) { return std::abs(level - height) <= 1e-6; }));
  CHECK(column.extinction_550_per_km(0, 0.35) == doctest::Approx(0.158));
  CHECK(column.extinction_550_per_km(0, 0.35 + 2 * 5.65 / 6) == doctest::Approx(0.0621));
  const AerosolColumn sea(AerosolSpec{}, summer());
  CHECK(column.depth_550(0, 0, 120) == doctest::Approx(sea.depth_550(0, 0, 120) * 5.65 / 6).epsilon(1e-12));
  CHECK(column.depth_550(2, 0, 120) == doctest::Approx(sea.depth_550(2, 0, 120)).epsilon(1e-12));
  CHECK(column.depth_550(4, 0, 120) == doctest::Approx(2).epsilon(1e-12));
  CHECK(column.depth_550(4, 1.1, 1.3) == doctest::Approx(0.8).epsilon(1e-12));
}

TEST_CASE("S4.5 aerosol: an optical depth sets the visibility; below the least depth all heights are scaled, with a notice") {
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
