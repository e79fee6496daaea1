// S4.9 S6: tables from imported runs. Oracle: the closed form of light between ground and air, and real samples.
#include "atmos_tables/import/table_of_runs.h"

#include <algorithm>
#include <numbers>

#include "atmos_tables/import/albedo_runs.h"
#include "atmos_tables/import/import_file.h"
#include "atmos_tables/import/modtran_chn.h"
#include "atmos_tables/interpolate.h"
#include "tests/unit/import_kit.h"

using namespace raycube::atmos;
using namespace raycube::atmos::imported;
using raycube::testing::holds;
using raycube::testing::refusal;
using raycube::testing::samples;

TEST_CASE("S4.9 three runs over albedos 0, r1 and r2 give back S and the coefficient they were made of") {
  for (const double s : {0.0, 1e-4, 0.05, 0.3, 0.9})
    for (const double c : {1e-6, 2.0, 300.0})
      for (const auto& [r1, r2] : {std::pair{0.1, 0.5}, {0.3, 1.0}, {0.5, 0.6}}) {
        const double l0 = 7.5;
        const auto light = [&](double r) { return l0 + r * c / (1 - r * s); };
        const GroundCoupling found = coupling_of_three_runs(l0, light(r1), light(r2), r1, r2);
        // D is a difference of numbers near l0: 1e-16 l0 / c, divided by the difference of the albedos.
        const double rounding = 1e-14 * (1 + l0 / c) / ((r2 - r1) * r1);
        CHECK(found.spherical_albedo == doctest::Approx(s).epsilon(1e-9).scale(1 + 1e9 * rounding));
        CHECK(found.coefficient == doctest::Approx(c).epsilon(1e-9 + 10 * rounding));
      }
  const GroundCoupling dark = coupling_of_three_runs(2, 2, 2, 0.3, 0.6);
  CHECK((dark.spherical_albedo == 0 && dark.coefficient == 0));
}

TEST_CASE("A-18 S6.3 a real .chn becomes a table: its columns come back through the table's own reading") {
  const std::string folder = samples("modtran");
  if (folder.empty()) return;
  const Imported chn = import_file(folder + "isofit_modtran6_vswir.chn");
  TableRequest request;
  request.sensor_height_m = 2000, request.even_sky = true;
  CHECK(holds(refusal([&] { table_of_runs({chn}, request); }), "the sun's zenith"));
  request.sun_zenith_deg = 52;
  const RenderTable table = table_of_runs({chn}, request).table;
  const Run& run = chn.runs.front();
  const auto joined = sun_ground_sensor_transmittance(run, 52);
  const auto two_way = two_way_transmission(table, 0, 0), view = view_transmission(table, 0, 0), s = spherical_albedo(table, 0),
             t_dif = diffuse_view_transmission(table, 0, 0), direct = direct_irradiance(table, 0), diffuse = diffuse_irradiance(table, 0);
  CHECK(has_ground_coupling(table));
  double worst = 0;
  for (std::size_t i = 0; i < two_way.size(); ++i) {
    CHECK(two_way[i] == doctest::Approx(joined[i]).epsilon(1e-5));  // floats, and -ln of them
    CHECK(view[i] == doctest::Approx(run.at("transmittance").values[i]).epsilon(1e-5));
    CHECK(s[i] == doctest::Approx(run.at("spherical_albedo").values[i]).epsilon(1e-6));
    // A and B again, from what the renderer reads: the columns are printed to 1e-6 of 1 at least.
    const double above = run.at("solar_irradiance_cos_over_pi").values[i] * std::numbers::pi, total = direct[i] + diffuse[i];
    worst = std::max(worst, std::abs(total * view[i] / above - run.at("coefficient_a").values[i]));
    worst = std::max(worst, std::abs(total * t_dif[i] / above - run.at("coefficient_b").values[i]));
  }
  // Diffuse irradiance is clamped at 0 where A and the direct column, both printed, leave less.
  MESSAGE("A and B through the table: worst difference ", worst);
  CHECK(worst < 1e-6);
}

TEST_CASE("A-18 S7 a real uvspec run becomes a table: Beer's law between its levels, its radiances at its angles") {
  const std::string folder = samples("libradtran");
  if (folder.empty()) return;
  const Imported uvspec = import_file(folder + "uvspec_solar_radiance.out");
  TableRequest request;
  request.sensor_height_m = 3000;
  const TableOfRuns made = table_of_runs({uvspec}, request);
  const Run& run = uvspec.runs.front();
  const auto column = [&](const std::string& name, double height, double zenith, double azimuth) -> const Column& {
    for (const Column& c : run.columns)
      if (c.name == name && c.place.height_m == height && std::abs(c.place.zenith_deg.value_or(zenith) - zenith) < 1e-6 &&
          std::abs(c.place.relative_azimuth_deg.value_or(azimuth) - azimuth) < 1e-6)
        return c;
    FAIL("no such column " << name);
    return run.columns.front();
  };
  CHECK(made.table.sun_zenith_deg == 40);
  const auto sky = sky_radiance(made.table, 0, 60, 90), path = path_radiance(made.table, 0, 60, 180), t = view_transmission(made.table, 0, 60),
             down = direct_irradiance(made.table, 0);
  for (std::size_t i = 0; i < sky.size(); ++i) {
    CHECK(sky[i] == doctest::Approx(column("radiance_downward", 0, 60, 90).values[i]).epsilon(1e-5));
    CHECK(down[i] == doctest::Approx(column("irradiance_down_direct", 0, 0, 0).values[i]).epsilon(1e-5));
    // L_up(sensor) = path + T L_up(ground) must hold again.
    CHECK(path[i] + t[i] * column("radiance_upward", 0, 60, 180).values[i] ==
          doctest::Approx(column("radiance_upward", 3000, 60, 180).values[i]).epsilon(1e-5));
  }
  CHECK(std::any_of(made.notices.begin(), made.notices.end(), [](const auto& n) { return holds(n, "ground of albedo 0.2"); }));
}
