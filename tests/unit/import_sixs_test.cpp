// 6S text output: a run written here after the layout public readers describe (Py6S). Oracle: the layout, and
// reflectance = pi L / (E0 cos sun): pi 50 / (1800 cos 30) = 0.10077.
#include "tests/unit/import_kit.h"

#include "atmos_tables/import/import_file.h"
#include "atmos_tables/import/sixs.h"

using namespace raycube;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

const std::string kRun =
    "******************************* 6s version 4.1 ******************************\n"
    "*        month:  1 day :  1                                                  *\n"
    "*        solar zenith angle:    30.00 deg  solar azimuthal angle:     0.00 deg *\n"
    "*        view zenith angle:     45.00 deg  view azimuthal angle:    270.00 deg *\n"
    "*        scattering angle:     127.76 deg  azimuthal angle difference: 270.00 deg *\n"
    "*           wl inf= 0.540 mic   wl sup= 0.560 mic                             *\n"
    "*        apparent reflectance  0.1008    appar. rad.(w/m2/sr/mic)    50.000   *\n"
    "*                   total gaseous transmittance  0.950                        *\n"
    "*     direct solar irr.    atm. diffuse irr.    environment  irr              *\n"
    "*            1000.000             200.000              10.000                 *\n"
    "*     atm. intrin. rad.    background  rad.    pixel  radiance                *\n"
    "*              20.000               5.000              25.000                 *\n"
    "*          int. funct filter (in mic)              int. sol. spect (in w/m2)  *\n"
    "*             0.0200000                                  36.000               *\n"
    "*      global gas. trans. :     0.97000        0.98000        0.95000         *\n"
    "*      rayl.  sca. trans. :     0.90000        0.91000        0.81900         *\n"
    "*      total  sca.   \"    :     0.85000        0.86000        0.73100         *\n"
    "*      spherical albedo   :     0.04063        0.03943        0.07191         *\n"
    "*      optical depth total:     0.10000        0.20000        0.30000         *\n"
    "*      reflectance        :     0.01773        0.00703        0.02504         *\n";

std::string refused(const std::string& text) {
  const TestFolder folder;
  folder.write("a.txt", text);
  return refusal([&] { read_sixs(folder / "a.txt"); });
}

}  // namespace

TEST_CASE("S20 6S: bands, angles, transmittances, albedo, radiances, two runs in one file") {
  const TestFolder folder;
  folder.write("a.txt", kRun + replaced(replaced(kRun, "0.540", "0.640"), "0.560", "0.660"));
  const Imported imported = import_file(folder / "a.txt");
  CHECK(imported.format == "6s");
  REQUIRE(imported.runs.size() == 2);
  const Run& run = imported.runs[0];
  CHECK(run.wavelength_um[0] == doctest::Approx(0.55));
  CHECK(imported.runs[1].wavelength_um[0] == doctest::Approx(0.65));
  CHECK(*run.geometry.sun_zenith_deg == 30);
  CHECK(*run.geometry.view_zenith_deg == 45);
  CHECK(*run.geometry.relative_azimuth_deg == doctest::Approx(90));
  CHECK(run.at("radiance").values[0] == 50);
  CHECK(run.at("solar_irradiance").values[0] == doctest::Approx(1800));
  CHECK(run.at("sun_ground_transmittance_gas").values[0] == 0.97);
  CHECK(run.at("ground_sensor_transmittance_scattering").values[0] == 0.86);
  CHECK(run.at("spherical_albedo").values[0] == 0.07191);
  CHECK(run.at("optical_depth").values[0] == 0.3);
  CHECK(run.at("reflectance_path").values[0] == 0.02504);
  CHECK(run.at("irradiance_down_diffuse").values[0] == 200);
  CHECK(run.at("path_radiance_solar").values[0] == 20);
  CHECK(run.find("filter_width") == nullptr);
}

TEST_CASE(
    "S20 6SV: a table by wavelength (iwave = -2) is a spectrum; the optical depth of its whole range is "
    "nobody's") {
  // Layout of 6SV's formats 1500 and 1501: 6(F6.4,1X), F6.1, 4(F6.4,1X).
  const std::string table =
      "*wave   total  total  total  total  atm.   swl    step   sbor   dsol   toar *\n"
      "*       gas    scat   scat   spheri intr                                    *\n"
      "*       trans  down   up     albedo refl                                    *\n"
      "*0.4500 0.9900 0.8100 0.8200 0.2100 0.0900 2069.7 0.0025 0.5000 1.0333 0.1500 *\n"
      "*0.4525 0.9890 0.8110 0.8210 0.2090 0.0890 2060.1 0.0025 1.0000 1.0333 0.1490 *\n"
      "*0.4550 0.9880 0.8120 0.8220 0.2080 0.0880 2050.5 0.0025 0.5000 1.0333 0.1480 *\n";
  const TestFolder folder;
  const std::size_t at = kRun.find("*        apparent");
  folder.write("a.txt", kRun.substr(0, at) + table + kRun.substr(at) + kRun);
  const Imported imported = import_file(folder / "a.txt");
  REQUIRE(imported.runs.size() == 2);
  const Run& run = imported.runs[0];
  CHECK(run.mode == "spectrum");
  REQUIRE(run.wavelength_um.size() == 3);
  CHECK(run.wavelength_um[1] == doctest::Approx(0.4525));
  CHECK(run.at("spherical_albedo").values[2] == 0.208);
  CHECK(run.at("solar_irradiance").values[0] == 2069.7);
  CHECK(run.at("ground_sensor_transmittance_scattering").values[1] == 0.821);
  CHECK(run.at("reflectance_apparent").values[2] == 0.148);
  CHECK(run.find("optical_depth_aerosol") == nullptr);
  REQUIRE(run.notes.size() == 1);
  CHECK(holds(run.notes[0], "whole range"));
  CHECK(imported.runs[1].at("optical_depth_aerosol").values[0] == 0.2);
  CHECK(holds(refused(kRun.substr(0, at) + table.substr(0, table.find("*0.4525")) + kRun.substr(at)),
              "a.txt:1: a table by wavelength with fewer than 2 rows"));
  CHECK(holds(refused(kRun.substr(0, at) + replaced(table, "0.4550", "0.4500") + kRun.substr(at)), "do not ascend"));
}

TEST_CASE("S20 6S: faults are refused with file and line") {
  REQUIRE(refused(kRun).empty());
  const auto with = [](const std::string& from, const std::string& to) { return refused(replaced(kRun, from, to)); };
  CHECK(holds(with(" 0.97000", " *******"), "a.txt:15: global gas. trans. : did not fit its field"));
  CHECK(holds(with(" 0.97000", "     NaN"), "a.txt:15: global gas. trans. : is not finite"));
  CHECK(holds(with(" 0.97000", "-0.97000"), "a.txt:15: global gas. trans. : is negative"));
  CHECK(holds(with(" 0.97000", "        "), "a.txt:15: global gas. trans. : is blank"));
  CHECK(holds(with(" 0.97000", " 1.97000"), "a value is above 1"));
  CHECK(holds(with(" 50.000 ", " 51.000 "), "apparent reflectance and radiance disagree"));
  CHECK(holds(refused(kRun.substr(0, kRun.find("*      spherical"))), "a.txt:1: the run has no spherical_albedo"));
  CHECK(holds(with("wl inf=", "wl  inf"), "the run names no band"));
  CHECK(holds(refused("nothing\n"), "no title"));
}
