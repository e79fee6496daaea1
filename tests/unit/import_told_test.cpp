// What a .tp6 or an input JSON tells of a .chn: sun, heights, day. Oracles: LOWTRAN 7's table by hand, spherical
// triangles solved another way, a real run's listing against its input, and its solar irradiance against a spectrum
// that MODTRAN did not make.
#include "tests/unit/import_kit.h"

#include <algorithm>
#include <numbers>

#include "atmos_tables/import/import_file.h"
#include "atmos_tables/import/modtran_cards.h"
#include "atmos_tables/import/modtran_sun.h"
#include "atmos_tables/import/modtran_tape6.h"
#include "atmos_tables/import/table_of_runs.h"
#include "atmos_tables/import/text_lines.h"
#include "atmos_tables/import/told_geometry.h"
#include "atmos_tables/interpolate.h"

using namespace raycube;
using namespace raycube::atmos;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

/// A listing of one line of sight from 3 km, 30 deg off straight down, over ground at 0.5 km; the path runs to the east
/// (azimuth 90), the sun stands 40 deg to the right of it, in the southeast.
const std::string kListing =
    "                    *   MODTRAN(R) 6.0.2r2                                      *\n"
    " CARD 1  *****CMF 2F   3    2   -1    2    2    2    2    2    2    1    0T   2   0.000LAMBER \n"
    "   GNDALT =   0.50000\n"
    " CARD 3  *****   3.00000   0.00000 150.00000   0.00000   0.00000     0.00000  0        0.00000   0.00000\n"
    "          DAY OF THE YEAR =                           100\n"
    "EXTRA-TERRESTIAL SOURCE IS THE SUN\n"
    "SUMMARY OF MULTIPLE SCATTERING VERTICAL PATH GEOMETRY CALCULATION\n\n"
    "          H1ALT   =    0.50000 KM\n          H2ALT   =  100.00000 KM\n          OBSZEN  =    0.00000 DEG\n\n"
    "SUMMARY OF LINE-OF-SIGHT No.  1 GEOMETRY CALCULATION\n\n"
    "          H1ALT   =    3.00000 KM\n"
    "          H2ALT   =    0.50000 KM\n"
    "          OBSZEN  =  150.00000 DEG\n"
    "          HRANGE  =    2.88700 KM\n"
    "          ECA     =    0.01300 DEG\n"
    "          BCKZEN  =   30.01200 DEG\n\n\n"
    "Line-of-Sight No.    1 location and direction:\n"
    "       34.00000   Latitude at H1ALT [Deg North of Equator]\n"
    "       90.00000   True Azimuth at H1ALT [Deg East of North]\n\n"
    " SINGLE SCATTER SOLAR PATH GEOMETRY TABLE FOR LINE-OF-SIGHT PATH No.  1\n"
    " ----------------------------------------------------------------------\n"
    " SCT       SCATTER     SUBTENDED         SOLAR          PATH      RELATIVE       SCATTER\n"
    "              [KM]         [DEG]         [DEG]         [DEG]         [DEG]         [DEG]\n"
    "   1    3.00000000    0.00000000   45.01000000  150.00000000   40.00000000  120.00000000\n"
    "   2    0.50000000    0.01300000   45.00000000  149.98800000   40.00000000  120.01000000\n\n"
    " SUN ELLIPTIC ORBIT SOLAR IRRADIANCE FACTOR FOR DAY 100:   0.99500\n"
    " CARD 5 *****    1   0       1.  0       1.  0       1.\n";

Run listing(const std::string& text) {
  const TestFolder folder;
  folder.write("a.tp6", text);
  return import_file(folder / "a.tp6").runs.at(0);
}
std::string refused(const std::string& text) {
  const TestFolder folder;
  folder.write("a.tp6", text);
  return refusal([&] { read_tape6(folder / "a.tp6"); });
}

/// Numbers of the first two columns of a CSV with # comments and one header line.
std::vector<std::pair<double, double>> two_columns(const std::string& path) {
  std::vector<std::pair<double, double>> out;
  for (const std::string& line : read_lines(path)) {
    const auto cells = split_commas(line);
    const Number first = cells.size() > 1 ? read_number(cells[0]) : Number{}, second = read_number(cells.back());
    if (first.good() && second.good()) out.emplace_back(first.value, read_number(cells[1]).value);
  }
  return out;
}

/// A file that names no geometry: MODTRAN 6 spectra of two frequencies.
const std::string kSpectra = "Freq,combin trans\n2000,0.5\n2500,0.25\n";

}  // namespace

TEST_CASE("S20 the subsolar point is LOWTRAN's and MODTRAN's: real listings come back to their last digit") {
  struct Printed {
    int day;
    double time_h, latitude_deg, longitude_west_deg;
  };
  // Of isofit's MODTRAN 6.0.2 run over Pasadena, 6.0.1 run of thermal channels and 6.0 runs of topoflux.
  for (const Printed& p :
       {Printed{312, 18.708, -16.2562, 104.6175}, {149, 17.797, 21.4264, 87.6439}, {254, 18.95, 4.7600, 105.0433}}) {
    const EarthPoint found = modtran_subsolar_point(p.day, p.time_h);
    CHECK(std::abs(found.latitude_deg - p.latitude_deg) <= 0.51e-4);
    CHECK(std::abs(found.longitude_west_deg - p.longitude_west_deg) <= 0.51e-4);
  }
  // Both ends of the table, and noon at Greenwich on the day whose equation of time is 10.02 minutes.
  CHECK(modtran_subsolar_point(1, 12).latitude_deg == -23.07);
  CHECK(modtran_subsolar_point(366, 12).latitude_deg == -23.07);
  CHECK(modtran_subsolar_point(274, 12).longitude_west_deg == doctest::Approx(10.02 / 4));
}

TEST_CASE("S20 the sun's angles on a sphere: a quarter turn, the poles, and the cosine law") {
  const SunAngles east = sun_seen_from({0, 10}, {0, 280});  // 90 degrees of longitude to the east
  CHECK(east.zenith_deg == doctest::Approx(90));
  CHECK(east.azimuth_deg == doctest::Approx(90));
  CHECK(sun_seen_from({40, 5}, {-20, 5}).azimuth_deg == doctest::Approx(180));
  CHECK(sun_seen_from({40, 5}, {-20, 5}).zenith_deg == doctest::Approx(60));
  CHECK(sun_seen_from({-40, 5}, {20, 5}).azimuth_deg == doctest::Approx(0));
  for (const double azimuth : {0.0, 37.0, 163.0, 271.0})
    for (const double arc : {0.5, 30.0, 100.0}) {
      const EarthPoint from{34, 118};
      const ArcEnd end = along_great_circle(from, azimuth, arc);
      const SunAngles seen = sun_seen_from(from, end.point);
      CHECK(seen.zenith_deg == doctest::Approx(arc).epsilon(1e-9));
      CHECK(std::abs(std::remainder(seen.azimuth_deg - azimuth, 360)) < 1e-7);
      const ArcEnd home = along_great_circle(end.point, end.azimuth_back_deg, arc);
      CHECK(home.point.latitude_deg == doctest::Approx(34).epsilon(1e-9));
      CHECK(home.point.longitude_west_deg == doctest::Approx(118).epsilon(1e-9));
    }
}

TEST_CASE("S20 .tp6: heights, view, sun at the path's end and from north, ground, day; damage is refused") {
  const Run run = listing(kListing);
  CHECK(run.mode == "listing");
  CHECK(run.wavelength_um.empty());
  const Geometry& g = run.geometry;
  CHECK(*g.sensor_height_m == 3000);
  CHECK(*g.path_end_height_m == 500);
  CHECK(*g.path_length_m == doctest::Approx(2887));
  CHECK(*g.sight_zenith_deg == 150);
  CHECK(*g.view_zenith_deg == 30.012);
  CHECK(*g.sun_zenith_deg == 45);
  CHECK(*g.sun_azimuth_deg == 130);
  // The sensor stands 180 deg from where the path goes: 140 deg from the sun.
  CHECK(*g.relative_azimuth_deg == 140);
  CHECK(*g.ground_height_m == 500);
  CHECK(*g.day_of_year == 100);
  CHECK(*g.earth_sun_factor == 0.995);

  const auto with = [](const std::string& from, const std::string& to) {
    return refused(replaced(kListing, from, to));
  };
  CHECK(holds(with("OBSZEN  =  150.00000", "OBSZEN  =  ***"), "a.tp6:17: OBSZEN did not fit its field"));
  CHECK(holds(with("          H2ALT   =    0.50000 KM\n", ""), "lacks heights or zenith"));
  CHECK(holds(with("   2    0.50000000", "   3    0.50000000"), "points along the path do not follow each other"));
  CHECK(holds(with("45.00000000", "245.0000000"), "an angle along the path is none"));
  CHECK(
      holds(with("=                           100", "=                           400"), "the day of the year is none"));
  CHECK(holds(with("0.99500", "1.99500"), "the earth-sun factor is none"));
  CHECK(holds(refused(kListing.substr(0, kListing.find(" SINGLE SCATTER SOLAR PATH GEOMETRY TABLE FOR LINE"))),
              "no table of the sun along it"));
  CHECK(holds(refused(kListing.substr(0, kListing.find("SUMMARY OF LINE"))), "no SUMMARY OF LINE-OF-SIGHT"));
  // A profile that ends below the sensor: the sensor stays where it was asked for.
  const Run above =
      listing(replaced(kListing, "SUMMARY OF MULTIPLE",
                       " H1ALT   OBSERVER ALTITUDE (KM)       20.09900      3.00000\nSUMMARY OF MULTIPLE"));
  CHECK(*above.geometry.sensor_height_m == doctest::Approx(20099));
  CHECK(holds(above.notes.at(0), "the profile ends at 3000 m"));
}

TEST_CASE("S20 cards and input JSON: the sun by place and time, of observer or target; zeros that stand for nothing") {
  ModtranPath path;
  path.h1_km = 2.3, path.h2_km = 0.35, path.observer_zenith_deg = 180, path.iparm = 11;
  path.parm[0] = 34.139247, path.parm[1] = 118.127521, path.day_of_year = 312, path.time_h = 18.708;
  path.path_azimuth_deg = 0;
  const Geometry g = geometry_from_modtran(path);
  // The listing of this run prints 52.0119 deg above the air and, with refraction, 51.9928 deg at the ground.
  CHECK(std::abs(*g.sun_zenith_deg - 52.01191130) < 1e-4);
  CHECK(std::abs(*g.sun_azimuth_deg - (90 + 73.46725576)) < 1e-3);
  CHECK(std::abs(*g.view_zenith_deg) < 1e-12);
  // Of the observer, 700 km up and 30 deg off: the target lies where the sight comes down.
  path.iparm = 1, path.h1_km = 700, path.observer_zenith_deg = 150, path.path_azimuth_deg = 90;
  const Geometry aside = geometry_from_modtran(path);
  const double up = std::asin((6371.23 + 700) / (6371.23 + 0.35) * 0.5) * 180 / std::numbers::pi;
  CHECK(*aside.view_zenith_deg == doctest::Approx(up).epsilon(1e-12));
  const ArcEnd end = along_great_circle({34.139247, 118.127521}, 90, up - 30);
  CHECK(*aside.sun_zenith_deg ==
        doctest::Approx(sun_seen_from(end.point, modtran_subsolar_point(312, 18.708)).zenith_deg));
  CHECK(*aside.sun_zenith_deg < *g.sun_zenith_deg);  // towards the sun
  // IPARM 12: azimuth and zenith at the target, where the sensor is seen along the path itself.
  path.iparm = 12, path.parm[0] = 50, path.parm[1] = 40;
  CHECK(*geometry_from_modtran(path).relative_azimuth_deg == 50);
  path.iparm = 2;
  CHECK(*geometry_from_modtran(path).relative_azimuth_deg == 130);
  CHECK(!geometry_from_modtran(path).sun_azimuth_deg);

  const TestFolder folder;
  folder.write("in.json", R"({"MODTRAN": [{"MODTRANINPUT": {"GEOMETRY": {"ITYPE": 3, "H1ALT": 2.3, "H2ALT": 0.0,
    "OBSZEN": 180, "BETA": 0, "HRANGE": 0, "IDAY": 312, "IPARM": 11, "PARM1": 34.139247, "PARM2": 118.127521,
    "GMTIME": 18.708, "TRUEAZ": 0}, "SURFACE": {"GNDALT": 0.35}}}]})");
  const Run run = import_file(folder / "in.json").runs.at(0);
  CHECK(run.mode == "input");
  CHECK(*run.geometry.sensor_height_m == 2300);
  CHECK(*run.geometry.path_end_height_m == 350);
  CHECK(*run.geometry.ground_height_m == 350);
  CHECK(!run.geometry.path_length_m);
  CHECK(std::abs(*run.geometry.sun_zenith_deg - 52.0119) < 1e-3);
  folder.write("no.json", R"({"MODTRAN": [{"MODTRANINPUT": {"GEOMETRY": {"IPARM": 11}}}]})");
  CHECK(holds(refusal([&] { import_file(folder / "no.json"); }), "names no GEOMETRY of H1ALT and OBSZEN"));
}

TEST_CASE("S20 what is told: by name, the only one, beside; contradictions and numbers of sights are refused") {
  const TestFolder folder;
  folder.write("a.csv", kSpectra), folder.write("b.csv", kSpectra), folder.write("a.tp6", kListing);
  folder.write("other.tp6", replaced(kListing, "45.00000000", "30.00000000"));
  std::vector<Imported> both{import_file(folder / "a.csv"), import_file(folder / "a.tp6"),
                             import_file(folder / "other.tp6"), import_file(folder / "b.csv")};
  tell_geometry(both);
  CHECK(*both[0].runs[0].geometry.sun_zenith_deg == 45);
  CHECK(holds(both[0].runs[0].notes.back(), "a.tp6"));
  CHECK(!both[3].runs[0].geometry.sun_zenith_deg);  // two listings, none of its name
  std::vector<Imported> one{import_file(folder / "b.csv"), import_file(folder / "other.tp6")};
  tell_geometry(one);
  CHECK(*one[0].runs[0].geometry.sun_zenith_deg == 30);
  std::vector<Imported> alone{import_file(folder / "a.csv")};
  tell_geometry(alone);
  CHECK(*alone[0].runs[0].geometry.sensor_height_m == 3000);
  // One that nobody asked for and nobody can read is noted, and stops nothing.
  folder.write("b.tp6", "nothing\n");
  std::vector<Imported> damaged{import_file(folder / "b.csv")};
  tell_geometry(damaged);
  CHECK(holds(damaged[0].runs[0].notes.back(), "beside it, and not read"));
  // The same said twice must be the same: listing and input of one name.
  folder.write("a.json", R"({"MODTRAN": [{"MODTRANINPUT": {"GEOMETRY": {"H1ALT": 2.0, "OBSZEN": 150}}}]})");
  std::vector<Imported> contrary{import_file(folder / "a.csv"), import_file(folder / "a.tp6"),
                                 import_file(folder / "a.json")};
  const std::string said = refusal([&] { tell_geometry(contrary); });
  CHECK(holds(said, "the sensor's height is not that of"));
  CHECK(holds(said, "3000 m against 2000 m"));
  // Two lines of sight for one spectrum.
  const std::size_t sight = kListing.find("SUMMARY OF LINE"), end = kListing.find(" SUN ELLIPTIC");
  std::string second = kListing.substr(sight, end - sight);
  for (const char* label : {"LINE-OF-SIGHT No.  ", "Line-of-Sight No.    ", "PATH No.  "})
    second = replaced(second, label + std::string("1"), label + std::string("2"));
  folder.write("two.tp6", kListing.substr(0, end) + second + kListing.substr(end));
  folder.write("two.csv", kSpectra);
  std::vector<Imported> uneven{import_file(folder / "two.csv"), import_file(folder / "two.tp6")};
  CHECK(holds(refusal([&] { tell_geometry(uneven); }), "1 against 2"));
  CHECK(holds(refusal([&] { table_of_runs({import_file(folder / "a.tp6")}, {}); }), "give its .chn"));
  // A spectrum without geometry is no path; told, it is one that looks down 30 deg from 2.5 km above the ground.
  TableRequest part;
  part.partial = true;
  CHECK(
      holds(refusal([&] { table_of_runs({import_file(folder / "two.csv")}, part); }), "none of the files holds a run"));
  const RenderTable table = table_of_runs({both[0]}, part).table;
  CHECK(table.sensor_height_m == 2500);
  CHECK(table.axis("view_zenith").nodes == std::vector<double>{30.012});
  CHECK(table.rows.at("view_transmission").values[0] == doctest::Approx(0.25));
}

TEST_CASE("A-18 S6.3 a real .chn with its .tp6 needs no option: sun, heights and day are the run's own") {
  const std::string folder = samples("modtran");
  if (folder.empty()) return;
  const auto made = [&](const std::string& teller, TableRequest request) {
    std::vector<Imported> files{import_file(folder + "isofit_modtran6_vswir.chn"), import_file(folder + teller)};
    tell_geometry(files);
    request.even_sky = true;
    return table_of_runs(files, request);
  };
  const TableOfRuns by_listing = made("isofit_modtran6_vswir.tp6", {});
  const RenderTable& table = by_listing.table;
  // Ground 0.35 km, sensor 2.3 km; the angles as the listing prints them at the ground.
  CHECK(table.sensor_height_m == doctest::Approx(1950));
  CHECK(table.sun_zenith_deg == doctest::Approx(51.99282416).epsilon(1e-9));
  CHECK(table.sun_azimuth_deg == doctest::Approx(-90 + 253.46725576));
  CHECK(table.axis("target_height").nodes == std::vector<double>{0});
  const auto noted = [&](const char* text) {
    return std::any_of(by_listing.notices.begin(), by_listing.notices.end(),
                       [&](const std::string& n) { return holds(n, text); });
  };
  CHECK(noted("z = 0 is the ground of the runs, 350 m"));
  CHECK(noted("day 312 of the year, 1.01827 times"));
  CHECK(noted("told by"));
  // The input alone says the same, but for refraction.
  const RenderTable by_input = made("isofit_modtran6_vswir_input.json", {}).table;
  CHECK(by_input.sensor_height_m == doctest::Approx(1950));
  CHECK(std::abs(by_input.sun_zenith_deg - table.sun_zenith_deg) < 0.02);
  CHECK(std::abs(by_input.sun_azimuth_deg - table.sun_azimuth_deg) < 1e-3);
  // The zenith is right when pi col 19 / cos(zenith) is the sun at the day's distance: against TSIS-1 HSRS, which is
  // measured, over the range of the channels. The two differ by 0.3 % in sum; a zenith wrong by 1 deg is off by 2.2 %,
  // the day left out by 1.8 %.
  const auto& e0 = table.rows.at("solar_irradiance").values;
  const auto& um = table.axis("wavelength").nodes;
  double sum = 0, measured = 0;
  for (std::size_t i = 1; i < um.size(); ++i) sum += 0.5 * (e0[i] + e0[i - 1]) * (um[i] - um[i - 1]);
  const auto hsrs = two_columns(folder + "../../solar/solar_tsis1_hsrs_350-2500nm_0p5nm.csv");
  for (std::size_t i = 1; i < hsrs.size(); ++i)
    if (hsrs[i - 1].first >= um.front() * 1e3 && hsrs[i].first <= um.back() * 1e3)
      measured += 0.5e-3 * (hsrs[i].second + hsrs[i - 1].second) * (hsrs[i].first - hsrs[i - 1].first);
  MESSAGE("the sun of the channels over TSIS-1 at the day's distance: ", sum / (measured * 1.01827));
  CHECK(sum == doctest::Approx(measured * 1.01827).epsilon(0.01));
  // What is asked for goes before what is told, and is noted.
  TableRequest asked;
  asked.sun_zenith_deg = 50, asked.sun_azimuth_deg = 10, asked.ground_height_m = 0;
  const TableOfRuns other = made("isofit_modtran6_vswir.tp6", asked);
  CHECK(other.table.sun_zenith_deg == 50);
  CHECK(other.table.sun_azimuth_deg == 10);
  CHECK(other.table.sensor_height_m == doctest::Approx(2300));
  CHECK(other.table.axis("target_height").nodes == std::vector<double>{350});
  CHECK(std::count_if(other.notices.begin(), other.notices.end(),
                      [](const std::string& n) { return holds(n, "as asked for; the"); }) == 3);
}
