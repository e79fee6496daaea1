// Planck's law against its integral and REQUIREMENTS' golden numbers; thermal rows read between their nodes (S4.8,
// S5.1).
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "atmos_tables/interpolate.h"
#include "atmos_tables/synthetic.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"
#include "host/base/planck.h"

using namespace raycube;
using base::planck_radiance;

TEST_CASE("S4.8 Planck: golden numbers, limits, and pi times its integral is sigma T^4") {
  // printed digits of REQUIREMENTS section 3
  CHECK(std::abs(planck_radiance(10, 300) - 9.92403) < 5e-6);
  CHECK(std::abs(planck_radiance(4, 300) - 0.721976) < 5e-7);
  CHECK(planck_radiance(10, 0) == 0);
  CHECK(planck_radiance(0.3, 3) == 0);  // exp overflows: no light, no NaN
  // Rayleigh-Jeans 2 c k T / l^4 where h c << l k T: relative error x / 2
  const double l = 1e6, jeans = base::kFirstRadiationConstant / base::kSecondRadiationConstant * 300 / (l * l * l * l);
  CHECK(planck_radiance(l, 300) == doctest::Approx(jeans).epsilon(3e-5));
  for (const double kelvin : {3.0, 200.0, 300.0, 6000.0}) {
    double sum = 0;  // Simpson in ln l, x = c2 / (l T) from 1e-3 to 100; the tails are below 1e-9
    constexpr int n = 4000;
    const double lo = std::log(base::kSecondRadiationConstant / kelvin / 100),
                 hi = std::log(base::kSecondRadiationConstant / kelvin / 1e-3);
    for (int i = 0; i <= n; ++i) {
      const double at = std::exp(lo + (hi - lo) * i / n);
      sum += (i == 0 || i == n ? 1 : i % 2 ? 4 : 2) * at * planck_radiance(at, kelvin);
    }
    CHECK(std::numbers::pi * sum * (hi - lo) / (3 * n) ==
          doctest::Approx(5.670374419e-8 * std::pow(kelvin, 4)).epsilon(1e-8));
  }
}

TEST_CASE("S5.1 thermal path: L/(1 - T) between nodes is exact in isothermal air at any height and slant") {
  const auto table = atmos::isothermal_table(
      280, [](double um) { return 0.2 + 0.1 * (um - 8); }, 3000, atmos::wavelength_grid(8, 12, 0.5));
  for (const double z : {0.0, 77.0, 1234.0, 2999.0})
    for (const double zenith : {0.0, 33.0, 61.0, 79.0}) {
      const auto path = atmos::path_radiance_thermal(table, z, zenith), t = atmos::view_transmission(table, z, zenith);
      for (std::size_t i = 0; i < path.size(); ++i)  // 2e-6: T = 0.96 stored in float carries 6e-8 into 1 - T
        CHECK(path[i] ==
              doctest::Approx(planck_radiance(atmos::wavelengths(table)[i], 280) * (1 - t[i])).epsilon(1e-5));
    }
  CHECK(atmos::path_radiance_thermal(table, 3000, 20)[0] == doctest::Approx(0));
}

TEST_CASE("S5.1 thermal sky: against the airmass, guarded at the horizon") {
  // thin air is linear in airmass: B (1 - exp(-tau m)), tau m up to 0.04
  const auto table = atmos::isothermal_table(280, [](double) { return 1e-3; }, 1000, {8, 9, 10});
  for (const double zenith : {0.0, 17.0, 52.0, 78.0, 89.0, 90.0}) {
    const double want = -planck_radiance(9, 280) * std::expm1(-1e-3 * atmos::airmass(zenith));
    CHECK(atmos::sky_radiance_thermal(table, 0, zenith)[1] == doctest::Approx(want).epsilon(1e-3));
  }
  CHECK(atmos::airmass(0) == doctest::Approx(1).epsilon(1e-3));
  CHECK(atmos::airmass(60) == doctest::Approx(2).epsilon(5e-3));
  CHECK(atmos::airmass(90) == doctest::Approx(38).epsilon(0.01));
  double last = 0;
  for (double zenith = 0; zenith <= 90; zenith += 0.25) {
    CHECK(atmos::airmass(zenith) > last);
    last = atmos::airmass(zenith);
  }
  CHECK_THROWS_AS(atmos::sky_radiance_thermal(table, 0, 91), base::Error);
}

TEST_CASE("S5.3 two-way factor of reflected thermal sky: 1 where the row is absent, else the row") {
  atmos::UniformAir air;
  air.thermal_sky_radiance = [](double) { return 3.0; };
  air.thermal_path_radiance = [](double) { return 1.0; };
  CHECK(atmos::two_way_factor_thermal(atmos::uniform_table(air, {8, 12}), 0, 0)[0] == 1);
  air.two_way_factor_thermal = [](double) { return 0.875; };
  const auto table = atmos::uniform_table(air, {8, 12});
  CHECK(atmos::two_way_factor_thermal(table, 0, 30)[1] == 0.875);
  CHECK(atmos::sky_radiance_thermal(table, 0, 30)[1] == 3);
  CHECK(atmos::path_radiance_thermal(table, 0, 30)[1] == 1);
  atmos::validate(table, "thermal rows");
}

TEST_CASE("bad input: a table without thermal rows says which row is missing and for what") {
  const auto table = atmos::uniform_sky_table(1000, 10, {0.4, 0.5});
  try {
    atmos::sky_radiance_thermal(table, 0, 0);
    FAIL("no error");
  } catch (const base::Error& error) {
    CHECK(std::string(error.what()).find("sky_radiance_thermal") != std::string::npos);
  }
}
