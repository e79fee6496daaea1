// AIR 5: differences of two tables per band, against closed forms on tables whose every value is stated.
#include <doctest/doctest.h>

#include <cmath>

#include "atmos_tables/synthetic.h"
#include "atmos_tables/table_difference.h"
#include "host/base/error.h"

using namespace raycube::atmos;

namespace {

const QuantityDifference& of(const TableDifference& d, const std::string& name) {
  for (const auto& q : d.quantities)
    if (q.name == name) return q;
  FAIL("not compared: " << name);
  return d.quantities.front();
}

UniformAir air(double view, double path) {
  UniformAir out;
  out.view_transmission = [=](double) { return view; };
  out.path_radiance = [=](double) { return path; };
  return out;
}

}  // namespace

TEST_CASE("AIR 5 a table differs from itself by nothing, in every quantity") {
  const RenderTable table = isothermal_table(
      290, [](double l) { return 0.1 * l; }, 1000, wavelength_grid(8, 12, 0.1));
  const TableDifference d = table_difference(table, table);
  CHECK(d.differs.empty());
  CHECK((d.only_a.empty() && d.only_b.empty()));
  CHECK(d.quantities.size() == 6);  // view transmission, thermal path and thermal sky, straight and slanted
  for (const auto& q : d.quantities)
    for (const auto& band : q.bands) CHECK((band.mean == 0 && band.rms == 0 && band.worst == 0));
}

TEST_CASE(
    "AIR 5 mean, rms and worst of a difference linear in wavelength are those of the line, whatever the two grids") {
  UniformAir a = air(0.5, 2), b = a;
  b.path_radiance = [](double l) { return 2 + 0.1 * (l - 1); };
  const auto table_a = uniform_table(a, wavelength_grid(0.9, 2.2, 0.013)),
             table_b = uniform_table(b, wavelength_grid(0.95, 2.5, 0.05));
  DifferenceChoice choice;
  choice.bands = {{1.0, 2.0, 1.5, 0}};
  const TableDifference d = table_difference(table_a, table_b, choice);
  CHECK(d.first_um == 0.95);
  CHECK(d.last_um == doctest::Approx(2.2));
  REQUIRE(of(d, "path_radiance_solar").bands.size() == 1);
  const BandDifference& band = of(d, "path_radiance_solar").bands[0];
  // Table values are floats: 6e-8 of 2. The trapezoid of a square is off by step^2 / 6 of the slope's square: 3e-7.
  CHECK(band.mean_a == doctest::Approx(2).epsilon(1e-7));
  CHECK(band.mean == doctest::Approx(0.05).epsilon(1e-5));
  CHECK(band.rms == doctest::Approx(0.1 / std::sqrt(3.0)).epsilon(1e-4));
  CHECK(band.worst == doctest::Approx(0.1).epsilon(1e-5));
  CHECK(band.worst_um == doctest::Approx(2.0));
  CHECK(band.mean_relative.value() == doctest::Approx(0.025).epsilon(1e-5));
  CHECK(band.worst_relative.value() == doctest::Approx(0.05).epsilon(1e-5));
  const BandDifference& ratio = of(d, "view_transmission").bands[0];
  CHECK(std::abs(ratio.worst) < 1e-7);
  CHECK(!ratio.mean_relative);
}

TEST_CASE(
    "AIR 5 a Gaussian band weighs by its response: a quadratic difference averages to its centre plus the variance") {
  UniformAir a = air(1, 1), b = a;
  b.path_radiance = [](double l) { return 1 + (l - 1) * (l - 1); };
  const auto grid = wavelength_grid(0.5, 1.5, 0.002);
  const double fwhm = 0.1, variance = fwhm * fwhm / (8 * std::log(2.0));
  DifferenceChoice choice;
  choice.bands = {gaussian_band(1.0, fwhm), gaussian_band(1.48, fwhm)};
  const TableDifference d = table_difference(uniform_table(a, grid), uniform_table(b, grid), choice);
  REQUIRE(of(d, "path_radiance_solar").bands.size() == 1);  // the second one's half-width point lies outside
  // Floats near 1 step by 1.2e-7, against a variance of 1.8e-3; the cut at 2.5 FWHM loses 4e-8 of the weight, 36
  // sigma^2 away.
  CHECK(of(d, "path_radiance_solar").bands[0].mean == doctest::Approx(variance).epsilon(1e-4));
}

TEST_CASE("AIR 5 what differs is said; rows of one table are named; nothing in common is refused") {
  UniformAir a = air(0.5, 2), b = air(0.6, 2);
  b.sun_zenith_deg = 30, b.sensor_height_m = 2000;
  b.spherical_albedo = b.diffuse_view_transmission = b.diffuse_return = [](double) { return 0.1; };
  const auto grid = wavelength_grid(0.4, 1.0, 0.1);
  const TableDifference d = table_difference(uniform_table(a, grid), uniform_table(b, grid));
  REQUIRE(d.differs.size() >= 2);
  CHECK(d.differs[0] == "sun zenith: 0 and 30 deg");
  CHECK(d.differs[1] == "sensor height: 1000 and 2000 m");
  CHECK(d.only_a.empty());
  CHECK(d.only_b == std::vector<std::string>{"diffuse_return", "diffuse_view_transmission", "spherical_albedo"});
  CHECK(of(d, "view_transmission").bands[0].mean == doctest::Approx(0.1).epsilon(1e-6));
  CHECK(difference_text(d, {"x", "y"}).find("only in B: diffuse_return") != std::string::npos);

  const auto apart = [&] { table_difference(uniform_table(a, grid), uniform_table(b, wavelength_grid(2, 3, 0.1))); };
  CHECK_THROWS_WITH_AS(apart(), "the tables have no wavelength in common: 0.4 to 1 um, and 2 to 3 um",
                       raycube::base::Error);
  RenderTable thermal = isothermal_table(
                  290, [](double) { return 0.1; }, 1000, wavelength_grid(0.5, 1, 0.1)),
              sun = uniform_table(a, grid);
  sun.rows.erase("view_transmission"), sun.rows.erase("view_optical_depth");
  CHECK_THROWS_WITH_AS(table_difference(sun, thermal),
                       "the tables have no row in common that can be compared (raycube atmos info lists rows)",
                       raycube::base::Error);
}

TEST_CASE("AIR 5 the two-way factor is left out where no light comes through") {
  UniformAir a = air(1, 0), b = a;
  a.sun_transmission = b.sun_transmission = [](double l) { return l < 1 ? 0.5 : 1e-6; };
  b.two_way_factor = [](double l) { return l < 1 ? 1.5 : 1e5; };
  const auto grid = wavelength_grid(0.6, 1.4, 0.1);
  DifferenceChoice choice;
  choice.bands = {{0.6, 0.9, 0.75, 0}, {1.1, 1.4, 1.25, 0}};
  const TableDifference d = table_difference(uniform_table(a, grid), uniform_table(b, grid), choice);
  REQUIRE(of(d, "two_way_factor").bands.size() == 1);
  CHECK(of(d, "two_way_factor").bands[0].mean == doctest::Approx(0.5).epsilon(1e-6));
}
