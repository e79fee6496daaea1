// S4.9 S6: tables from imported runs. Oracle: the closed form of light between ground and air, and real samples.
#include "atmos_tables/import/table_of_runs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
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
  const auto two_way = two_way_transmission(table, 0, 0), view = view_transmission(table, 0, 0),
             s = spherical_albedo(table, 0), t_dif = diffuse_view_transmission(table, 0, 0),
             direct = direct_irradiance(table, 0), diffuse = diffuse_irradiance(table, 0);
  CHECK(has_ground_coupling(table));
  double worst = 0;
  for (std::size_t i = 0; i < two_way.size(); ++i) {
    CHECK(two_way[i] == doctest::Approx(joined[i]).epsilon(1e-5));  // floats, and -ln of them
    CHECK(view[i] == doctest::Approx(run.at("transmittance").values[i]).epsilon(1e-5));
    CHECK(s[i] == doctest::Approx(run.at("spherical_albedo").values[i]).epsilon(1e-6));
    // A and B again, from what the renderer reads: the columns are printed to 1e-6 of 1 at least.
    const double above = run.at("solar_irradiance_cos_over_pi").values[i] * std::numbers::pi,
                 total = direct[i] + diffuse[i];
    worst = std::max(worst, std::abs(total * view[i] / above - run.at("coefficient_a").values[i]));
    worst = std::max(worst, std::abs(total * t_dif[i] / above - run.at("coefficient_b").values[i]));
  }
  // Diffuse irradiance is clamped at 0 where A and the direct column, both printed, leave less.
  // What the path emits is the channels' own column: below 3 um too.
  const auto emitted = path_radiance_thermal(table, 0, 0);
  double most = 0;
  for (std::size_t i = 0; i < emitted.size(); ++i) {
    CHECK(emitted[i] == doctest::Approx(run.at("path_radiance_thermal").values[i]).epsilon(1e-6));
    most = std::max(most, emitted[i] / run.at("radiance").values[i]);
  }
  MESSAGE("the path's own light: at most ", most, " of a channel");
  CHECK(most > 0.005);
  MESSAGE("A and B through the table: worst difference ", worst);
  CHECK(worst < 1e-6);
}

TEST_CASE("A-18 AIR 7 a real uvspec run becomes a table: Beer's law between its levels, its radiances at its angles") {
  const std::string folder = samples("libradtran");
  if (folder.empty()) return;
  const Imported uvspec = import_file(folder + "uvspec_solar_radiance.out");
  TableRequest request;
  request.sensor_height_m = 3000;
  const TableOfRuns made = table_of_runs({uvspec}, request);
  const Run& run = uvspec.runs.front();
  const auto column = [&](const std::string& name, double height, double zenith, double azimuth) -> const Column& {
    for (const Column& c : run.columns)
      if (c.name == name && c.place.height_m == height &&
          std::abs(c.place.zenith_deg.value_or(zenith) - zenith) < 1e-6 &&
          std::abs(c.place.relative_azimuth_deg.value_or(azimuth) - azimuth) < 1e-6)
        return c;
    FAIL("no such column " << name);
    return run.columns.front();
  };
  CHECK(made.table.sun_zenith_deg == 40);
  const auto sky = sky_radiance(made.table, 0, 60, 90), path = path_radiance(made.table, 0, 60, 180),
             t = view_transmission(made.table, 0, 60), down = direct_irradiance(made.table, 0);
  for (std::size_t i = 0; i < sky.size(); ++i) {
    CHECK(sky[i] == doctest::Approx(column("radiance_downward", 0, 60, 90).values[i]).epsilon(1e-5));
    CHECK(down[i] == doctest::Approx(column("irradiance_down_direct", 0, 0, 0).values[i]).epsilon(1e-5));
    // L_up(sensor) = path + T L_up(ground) must hold again.
    CHECK(path[i] + t[i] * column("radiance_upward", 0, 60, 180).values[i] ==
          doctest::Approx(column("radiance_upward", 3000, 60, 180).values[i]).epsilon(1e-5));
  }
  CHECK(std::any_of(made.notices.begin(), made.notices.end(),
                    [](const auto& n) { return holds(n, "ground of albedo 0.2"); }));
}

TEST_CASE("S6.6 .acd with a CSV: k-terms are summed as products, so the light from sun to sensor is exact") {
  raycube::testing::TestFolder folder;
  folder.write("a.acd",
               " atmospheric correction data\n FREQ LOS K WEIGHT ...\n (CM-1)\n of two k\n --------\n"
               " 10000.0  1  1  0.750000  0.100000  0.500000  0.050000  0.800000  0.080000\n"
               " 10000.0  1  2  0.250000  0.020000  0.100000  0.010000  0.400000  0.040000\n"
               " 12500.0  1  1  0.750000  0.110000  0.600000  0.060000  0.850000  0.090000\n"
               " 12500.0  1  2  0.250000  0.030000  0.200000  0.020000  0.450000  0.050000\n");
  folder.write(
      "rest.csv",
      "wavelength [um],solar_irradiance [W m-2 um-1],path_radiance_solar [W m-2 sr-1 um-1]\n0.8,1000,10\n1.0,800,6\n");
  TableRequest request;
  request.sun_zenith_deg = 60, request.sensor_height_m = 1000, request.even_sky = true;
  const RenderTable table =
      table_of_runs({import_file(folder / "a.acd"), import_file(folder / "rest.csv")}, request).table;
  // At 1 um, by hand: T = 0.7, sun to sensor 0.4, sun to ground diffuse 0.08, embedded 0.04, S = 0.07; E0 cos(sun) =
  // 400.
  const std::size_t at = 1;
  REQUIRE(wavelengths(table)[at] == doctest::Approx(1.0));
  CHECK(view_transmission(table, 0, 0)[at] == doctest::Approx(0.7).epsilon(1e-6));
  CHECK(two_way_transmission(table, 0, 0)[at] == doctest::Approx(0.4).epsilon(1e-6));
  CHECK(diffuse_irradiance(table, 0)[at] == doctest::Approx(400 * 0.08).epsilon(1e-6));
  CHECK(sky_radiance(table, 0, 50, 20)[at] == doctest::Approx(400 * 0.08 / std::numbers::pi).epsilon(1e-6));
  CHECK(spherical_albedo(table, 0)[at] == doctest::Approx(0.07).epsilon(1e-6));
  CHECK(diffuse_view_transmission(table, 0, 0)[at] == doctest::Approx(0.04).epsilon(1e-6));
}

TEST_CASE(
    "S6.1 thermal runs down and up make an LWIR table; without the sky it is refused, and sunlight is not asked for") {
  raycube::testing::TestFolder folder;
  const auto run = [](int type, const char* card3, const char* thermal) {
    std::string text =
        "T F 2    " + std::to_string(type) +
        "    1    1    2    2    2    2    2    2    1    0    0 300.000   0.00\n"
        "    1    1    1    0    0    0  23.00000   0.00000   0.00000   0.00000   0.00000\n   36MID-LATITUDE SUMMER\n" +
        card3 +
        "\n  -99  -99  -99  -99\n -99.00000 -99.00000 -99.00000 -99.00000 -99.00000 -99.00000 -99.00000 -99.00000\n"
        "    1000.0    1100.0     100.0     100.0NW              \n    0   0    0.000  0    0.000  0    0.000\n"
        "    FREQ  TOT_TRANS  PTH_THRML  THRML_SCT  SURF_EMIS   SOL_SCAT  SING_SCAT  GRND_RFLT  DRCT_RFLT  TOTAL_RAD  "
        "REF_SOL  SOL@OBS   DEPTH DIR_EM    TOA_SUN BBODY_T[K]\n";
    for (const char* frequency : {" 1000.00", " 1100.00"})
      text += std::string(frequency) + " 0.80000000 " + thermal +
              " 0.0000E+00 0.0000E+00                       0.0000E+00            " + thermal +
              "                     0.223 1.0000               290.000\n";
    return text + " -9999.\n";
  };
  folder.write("down.tp7", run(2, "   0.50000   0.00000 180.00000   0.50000   0.00000   0.00000    0        0.00000",
                               "2.0000E-06"));
  folder.write("up.tp7", run(3, "   0.00000   0.00000  30.00000   0.00000   0.00000   0.00000    0        0.00000",
                             "3.0000E-06"));
  const Imported down = import_file(folder / "down.tp7"), up = import_file(folder / "up.tp7");
  const std::string said = refusal([&] { table_of_runs({down}, {}); });
  CHECK(holds(said, "sky_radiance_thermal"));
  CHECK(!holds(said, "sky_radiance_solar"));
  const RenderTable table = table_of_runs({down, up}, {}).table;
  CHECK(table.sensor_height_m == 500);
  CHECK(!table.has("solar_irradiance"));
  // 2e-6 W cm-2 sr-1 per cm-1 at 1000 cm-1 (10 um) is 2 W m-2 sr-1 um-1; wavelengths ascend, so it stands last.
  CHECK(path_radiance_thermal(table, 0, 0).back() == doctest::Approx(2).epsilon(1e-6));
  CHECK(sky_radiance_thermal(table, 0, 70).back() == doctest::Approx(3).epsilon(1e-6));
  CHECK(sky_radiance_thermal(table, 0, 70).front() == doctest::Approx(3e-6 * 1100 * 1100).epsilon(1e-6));
}

TEST_CASE("S6.1 a thermal uvspec run takes its transmission from one by sunlight: grey air, in closed form") {
  // Air of one temperature that only absorbs, 0.3 deep below the sensor and 0.1 above: what its path sends is
  // B (1 - t), what the sky sends B (1 - t_sky), and the ground's light comes through with t.
  raycube::testing::TestFolder folder;
  const double below = 0.3, above = 0.1, b = 8, ground = 10, mu0 = std::cos(40 * std::numbers::pi / 180), e0 = 2;
  const auto number = [](double x) {
    char text[40];
    std::snprintf(text, sizeof text, " %.9e", x);
    return std::string(text);
  };
  const auto solar = [&](double depth) { return e0 * mu0 * std::exp(-depth / mu0); };
  std::string beam, heat;
  for (const char* nm : {" 9000.000", " 9500.000"}) {
    beam += std::string(nm) + "  0.000" + number(solar(below + above)) + "\n" + nm + "  2.000" + number(solar(above)) +
            "\n" + nm + "  120.0" + number(solar(0)) + "\n";
    for (const bool high : {false, true}) {
      heat += std::string(nm) + (high ? "  2.000" : "  0.000");
      const auto sky = [&](double mu) { return b * (1 - std::exp(-(high ? above : below + above) / mu)); };
      const auto up = [&](double mu) {
        const double t = high ? std::exp(-below / mu) : 1;
        return ground * t + b * (1 - t);
      };
      heat += number(sky(0.5) / 1e3) + number(up(0.5) / 1e3) + number(up(1) / 1e3) + "\n";
    }
  }
  folder.write("sun.inp", "source solar kurudz_1.0nm.dat\nsza 40\nzout 0 2 TOA\noutput_user lambda zout edir\n");
  folder.write("sun.out", beam);
  folder.write("heat.inp",
               "source thermal\noutput_process per_nm\nzout 0 2\numu -0.5 0.5 1\nphi 0\noutput_user lambda zout uu\n");
  folder.write("heat.out", heat);
  const Imported sun = import_file(folder / "sun.out"), thermal = import_file(folder / "heat.out");
  CHECK(thermal.runs[0].mode == "thermal fluxes and radiances");
  // In any order; alone the transmission is missing, and the message says what gives it.
  const RenderTable table = table_of_runs({thermal, sun}, {}).table;
  CHECK(table.sensor_height_m == 2000);
  CHECK(table.axis("view_zenith").nodes.size() == 2);
  for (const auto& [zenith, mu] : {std::pair{0.0, 1.0}, {60.0, 0.5}}) {
    const double t = std::exp(-below / mu);
    CHECK(view_transmission(table, 0, zenith)[1] == doctest::Approx(t).epsilon(1e-6));
    CHECK(path_radiance_thermal(table, 0, zenith)[1] == doctest::Approx(b * (1 - t)).epsilon(1e-6));
  }
  CHECK(sky_radiance_thermal(table, 0, 60)[0] == doctest::Approx(b * (1 - std::exp(-0.4 / 0.5))).epsilon(1e-6));
  const std::string said = refusal([&] { table_of_runs({thermal}, {}); });
  CHECK(holds(said, "no run says what T is"));
  CHECK(holds(said, "add a uvspec run with source solar"));
}
