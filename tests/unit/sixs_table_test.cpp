// Tables of 6S runs, one per wavelength or band. Oracle: the equation 6S prints its apparent reflectance by, with the
// parts its output lists (Vermote et al. 1997, eq. 1-4), over ground of any albedo.
#include "tests/unit/import_kit.h"

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>

#include "atmos_tables/import/import_file.h"
#include "atmos_tables/import/table_of_runs.h"
#include "atmos_tables/interpolate.h"

using namespace raycube;
using namespace raycube::atmos;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

/// Air at one wavelength: gas transmittances, those of scattering, optical depth, spherical albedo, intrinsic
/// reflectance, sun above.
struct Air {
  double um, gas_down, gas_up, gas, down, up, depth, depth_below_plane, albedo, intrinsic, sun;
};
constexpr Air kAir[] = {{0.55, 0.97, 0.98, 0.955, 0.86, 0.83, 0.30, 0.12, 0.12, 0.09, 1850},
                        {0.65, 0.96, 0.97, 0.935, 0.90, 0.88, 0.20, 0.08, 0.08, 0.05, 1580},
                        {0.85, 0.99, 0.99, 0.980, 0.94, 0.92, 0.12, 0.05, 0.05, 0.02, 980}};
const double kMu0 = std::cos(30 * std::numbers::pi / 180);

double mu_of(double view_deg) { return std::cos(view_deg * std::numbers::pi / 180); }
double apparent_reflectance(const Air& a, double r) {
  return a.intrinsic * a.gas + a.gas * a.down * a.up * r / (1 - r * a.albedo);
}

/// The text of one run, laid out as 6SV's formats have it. `band_um`: 0 = monochromatic.
std::string run_text(const Air& a, double view_deg, double band_um, double plane_km, double r = 0) {
  char line[2000];
  const double direct = a.sun * kMu0 * a.gas_down * std::exp(-a.depth / kMu0),
               total = a.sun * kMu0 * a.gas_down * a.down, rho = apparent_reflectance(a, r);
  std::string out = "******************************* 6SV version 1.1 ******************************\n";
  std::snprintf(line, sizeof line,
                "*    solar zenith angle:   30.00 deg  solar azimuthal angle:      150.00 deg   *\n"
                "*    view zenith angle:   %6.2f deg  view azimuthal angle:        60.00 deg   *\n"
                "*    scattering angle:    120.00 deg  azimuthal angle difference:  90.00 deg   *\n",
                view_deg);
  out += line;
  if (band_um > 0)
    std::snprintf(line, sizeof line, "*  wl inf=%9.5f mic   wl sup=%9.5f mic  *\n", a.um - band_um / 2,
                  a.um + band_um / 2);
  else
    std::snprintf(line, sizeof line, "*           monochromatic calculation at wl :%6.3f micron   *\n", a.um);
  out += line;
  out += "*           ground altitude  [km]       0.600                                 *\n";
  if (plane_km > 0) {
    std::snprintf(line, sizeof line, "*           plane  altitude absolute [km] %9.3f   *\n", plane_km);
    out += line;
  }
  std::snprintf(line, sizeof line,
                "*  apparent reflectance %11.7f  appar. rad.(w/m2/sr/mic) %9.3f  *\n"
                "*     direct solar irr.    atm. diffuse irr.    environment  irr  *\n* %.3f %.3f 0.000 *\n"
                "*     atm. intrin. rad.    background  rad.    pixel  radiance    *\n* %.3f 0.000 0.000 *\n",
                rho, rho * a.sun * kMu0 / std::numbers::pi, direct, total - direct,
                a.intrinsic * a.gas * a.sun * kMu0 / std::numbers::pi);
  out += line;
  if (band_um > 0)
    std::snprintf(line, sizeof line, "*  int. funct filter (in mic)   int. sol. spect (in w/m2)  *\n* %.7f %.3f *\n",
                  band_um, band_um * a.sun);
  else
    std::snprintf(line, sizeof line, "*   sol. spect (in w/m2/mic)  *\n* %.3f *\n", a.sun);
  out += line;
  std::snprintf(line, sizeof line,
                "*      global gas. trans. : %.5f %.5f %.5f *\n*      total  sca.   \"    : %.5f %.5f %.5f *\n"
                "*      spherical albedo   : 0.1 0.1 %.5f *\n*      optical depth total: 0.1 0.1 %.5f *\n"
                "*      optical depth plane: 0.1 0.1 %.5f *\n",
                a.gas_down, a.gas_up, a.gas, a.down, a.up, a.down * a.up, a.albedo, a.depth, a.depth_below_plane);
  return out + line;
}

TableRequest satellite() {
  TableRequest request;
  request.even_sky = true, request.sensor_height_m = 700e3;
  return request;
}

/// Light at the sensor over ground of albedo r, of the table's own rows.
double seen(const RenderTable& table, std::size_t i, double view_deg, double azimuth_deg, double r) {
  const double ground = direct_irradiance(table, 0)[i] + diffuse_irradiance(table, 0)[i],
               both = two_way_transmission(table, 0, view_deg)[i] + 0.0,
               view = view_transmission(table, 0, view_deg)[i];
  // Two-way transmission over that of sun and view is the factor that all ground light is multiplied with.
  const double sun = direct_irradiance(table, 0)[i] / (table.rows.at("solar_irradiance").values[i] * kMu0);
  const double factor = both / (sun * view);
  return path_radiance(table, 0, view_deg, azimuth_deg)[i] +
         factor * (view + diffuse_view_transmission(table, 0, view_deg)[i]) * ground * r / std::numbers::pi /
             (1 - r * spherical_albedo(table, 0)[i]);
}

}  // namespace

TEST_CASE("S20 6SV: runs of one wavelength each become a table that gives back 6S's own radiance over any ground") {
  const TestFolder folder;
  // Out of order, in two files, two views: nadir and 40 degrees.
  std::string nadir, aside;
  for (const int i : {2, 0, 1}) nadir += run_text(kAir[i], 0, 0, 0), aside += run_text(kAir[i], 40, 0, 0);
  folder.write("nadir.txt", nadir), folder.write("aside.txt", aside);
  const std::vector<Imported> files{import_file(folder / "nadir.txt"), import_file(folder / "aside.txt")};
  CHECK(files[0].runs.size() == 3);
  const TableOfRuns made = table_of_runs(files, satellite());
  const RenderTable& table = made.table;
  CHECK(table.sun_zenith_deg == 30);
  CHECK(table.sun_azimuth_deg == 150);
  CHECK(table.axis("view_zenith").nodes == std::vector<double>{0, 40});
  REQUIRE(table.axis("wavelength").nodes.size() == 3);
  for (std::size_t i = 0; i < 3; ++i)
    for (const double view : {0.0, 40.0}) {
      // As computed for the 6S text: transmissions printed to 5 decimals, radiances to 3.
      CHECK(view_transmission(table, 0, view)[i] ==
            doctest::Approx(kAir[i].gas_up * std::exp(-kAir[i].depth / mu_of(view))).epsilon(2e-5));
      for (const double r : {0.0, 0.3, 0.8})
        CHECK(seen(table, i, view, 90, r) ==
              doctest::Approx(apparent_reflectance(kAir[i], r) * kAir[i].sun * kMu0 / std::numbers::pi).epsilon(5e-5));
    }
  // Without a sky, and without a height: both are asked for, by name.
  const std::string said = refusal([&] { table_of_runs(files, {}); });
  CHECK(holds(said, "sky_radiance_solar"));
  CHECK(holds(said, "--even-sky"));
  CHECK(holds(said, "--sensor-height"));
}

TEST_CASE("S20 6SV: bands are channels, an aircraft sees through the air below it, faults name what is missing") {
  const TestFolder folder;
  std::string bands;
  for (const Air& a : kAir) bands += run_text(a, 0, 0.02, 3.6);
  folder.write("plane.txt", bands);
  TableRequest request;
  request.even_sky = true;
  const TableOfRuns made = table_of_runs({import_file(folder / "plane.txt")}, request);
  CHECK(made.table.sensor_height_m == doctest::Approx(3000));
  CHECK(view_transmission(made.table, 0, 0)[0] == doctest::Approx(0.98 * std::exp(-0.12)).epsilon(2e-5));
  const auto channels = nlohmann::json::parse(made.table.provenance_json)["channels"];
  REQUIRE(channels.size() == 3);
  CHECK(channels[1][1].get<double>() == doctest::Approx(0.65));
  CHECK(channels[1][2].get<double>() == doctest::Approx(0.02));
  // A run that is there twice, one of another sun, one without its optical depth.
  folder.write("twice.txt", bands + run_text(kAir[1], 0, 0.02, 3.6));
  CHECK(holds(refusal([&] { table_of_runs({import_file(folder / "twice.txt")}, request); }),
              "two runs are of one wavelength and one view (found 0.65 um)"));
  Imported other_sun = import_file(folder / "plane.txt");
  other_sun.runs[1].geometry.sun_zenith_deg = 31;
  CHECK(
      holds(refusal([&] { table_of_runs({other_sun}, request); }), "the sun's zenith is not that of the runs before"));
  std::string old = run_text(kAir[0], 0, 0, 0);
  old.resize(old.find("*      optical depth total"));
  folder.write("old.txt", old);
  CHECK(holds(refusal([&] { table_of_runs({import_file(folder / "old.txt")}, satellite()); }),
              "not every run has optical_depth (found optical depth total)"));
}

TEST_CASE("S20 6SV: a table by wavelength lists what a render lacks of it, and gives its part when asked") {
  const std::string table =
      "*wave   total  total  total  total  atm.   swl    step   sbor   dsol   toar *\n"
      "*0.4500 0.9900 0.8100 0.8200 0.2100 0.0900 2069.7 0.0025 0.5000 1.0333 0.1500 *\n"
      "*0.4525 0.9890 0.8110 0.8210 0.2090 0.0890 2060.1 0.0025 1.0000 1.0333 0.1490 *\n";
  const std::string run = run_text(kAir[0], 0, 0.02, 0);
  const TestFolder folder;
  folder.write("a.txt", run + table);
  const std::vector<Imported> files{import_file(folder / "a.txt")};
  const std::string said = refusal([&] { table_of_runs(files, satellite()); });
  for (const char* row : {"view_transmission", "sun_transmission", "diffuse_irradiance", "path_radiance_solar",
                          "sky_radiance_solar", "iwave -1"})
    CHECK(holds(said, row));
  TableRequest part = satellite();
  part.partial = true;
  const RenderTable made = table_of_runs(files, part).table;
  CHECK(made.rows.at("spherical_albedo").values[1] == 0.209f);
  CHECK(made.rows.at("solar_irradiance").values[0] == 2069.7f);
}
