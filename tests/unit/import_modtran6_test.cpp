// MODTRAN 6 JSON and CSV: small outputs written here, whole and with faults. Oracle: the formats' rules, arithmetic by
// hand.
#include "tests/unit/import_kit.h"

#include "atmos_tables/import/modtran_csv.h"
#include "atmos_tables/import/modtran_json.h"

using namespace raycube;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

const std::string kJson = R"({"MODTRAN": [{"MODTRANINPUT": {
  "GEOMETRY": {"H1ALT": 2.3, "OBSZEN": 180, "IPARM": 2, "PARM1": 0, "PARM2": 35, "BETA": 0},
  "SPECTRAL": {"V1": 2000, "V2": 2500, "DV": 1, "FWHM": 1, "FLAGS": "W     "}},
 "MODTRANOUTPUT": {"SPECTRA": {
  "RADIANCE": {"FREQ": [2000, 2500], "TOT_TRANS": [0.5, 0.25], "THRML_EM": [2e-8, 1e-8], "THRML_SCT": [1e-9, 1e-9],
   "SURF_EMIS": [4e-7, 2e-7], "MULT_SCAT": [1e-10, 1e-10], "SING_SCAT": [2e-10, 2e-10], "GRND_RFLT": [1e-9, 1e-9],
    "DRCT_RFLT": [5e-10, 5e-10],
   "TOTAL_RAD": [4.223e-7, 2.123e-7], "DEPTH": [0.6931, 1.3863],
    "DIR_EM": [0.7, 0.7], "TOA_RAD": [1e-6, 1.1e-6], "BBODY_TK": [290, 285],
    "SOMETHING": [1, 2]},
  "TRANSMITTANCE": {"FREQ": [2000, 2500], "TOT_TRANS": [0.5, 0.25], "TRANS_H2O": [0.8, 0.7],
   "CONT_H2O": [0.9, 0.9]}}}}]})";

std::string refused_json(const std::string& text) {
  const TestFolder folder;
  folder.write("a.json", text);
  return refusal([&] { read_modtran_json(folder / "a.json"); });
}

std::string refused_csv(const std::string& text) {
  const TestFolder folder;
  folder.write("a.csv", text);
  return refusal([&] { read_modtran_csv(folder / "a.csv"); });
}

const std::string kCsv =
    "case 0,run of two frequencies\n"
    "Freq,total transmittance,path emission,path thermal scat,surface emission,path multiple scat,path single "
    "scat,ground reflect,direct reflect,total radiance\n"
    "cm-1,,,,,,,,,\n"
    "2000.0,0.5,2.0e-08,1.0e-09,4.0e-07,1.0e-10,2.0e-10,1.0e-09,5.0e-10,4.2230e-07\n"
    "2500.0,0.25,1.0e-08,1.0e-09,2.0e-07,1.0e-10,2.0e-10,1.0e-09,5.0e-10,2.1230e-07\n";

const std::string kFlux =
    "case index 0 = {\nnum freq, 2\nnum column, 6\n"
    "Freq, UP, DOWN, SOLAR, UP, DOWN, SOLAR\n[cm-1], 0 KM, 0 KM, 0 KM, 1.5 KM, 1.5 KM, 1.5 KM\n"
    "2000, 1.0e-6, 2.0e-6, 3.0e-6, 4.0e-6, 5.0e-6, 6.0e-6\n2500, 1.1e-6, 2.1e-6, 3.1e-6, 4.1e-6, 5.1e-6, 6.1e-6\n}\n";

}  // namespace

TEST_CASE("S20 MODTRAN 6 JSON: radiance and transmittance of a case, units, geometry, unknown arrays noted") {
  const TestFolder folder;
  folder.write("a.json", kJson);
  const Imported imported = read_modtran_json(folder / "a.json");
  REQUIRE(imported.runs.size() == 2);
  const Run& run = imported.runs[0];
  CHECK(run.mode == "radiance");
  CHECK(run.wavelength_um[0] == doctest::Approx(4).epsilon(1e-15));
  CHECK(run.at("transmittance").values == std::vector<double>{0.25, 0.5});
  // Emission and scatter stand apart: the total says so. (2e-8 + 1e-9) x 4e6 = 0.084.
  CHECK(run.at("path_radiance_thermal").values[1] == doctest::Approx(0.084).epsilon(1e-12));
  CHECK(run.at("path_radiance_solar").values[1] == doctest::Approx(3e-10 * 4e6).epsilon(1e-12));
  CHECK(run.at("solar_irradiance").values[1] == doctest::Approx(4).epsilon(1e-12));
  REQUIRE(run.notes.size() == 1);
  CHECK(holds(run.notes[0], "SOMETHING"));
  CHECK(*run.geometry.sensor_height_m == doctest::Approx(2300));
  CHECK(*run.geometry.view_zenith_deg == 0);
  CHECK(*run.geometry.sun_zenith_deg == 35);
  CHECK(imported.runs[1].mode == "transmittance");
  CHECK(imported.runs[1].at("transmittance_h2o").values[1] == 0.8);
  CHECK(imported.runs[1].at("transmittance_h2o_continuum").values[1] == 0.9);
  // Where the total holds without the scatter, emission already has it.
  folder.write("b.json", replaced(replaced(kJson, "4.223e-7", "4.213e-7"), "2.123e-7", "2.113e-7"));
  CHECK(read_modtran_json(folder / "b.json").runs[0].at("path_radiance_thermal").values[1] ==
        doctest::Approx(0.08).epsilon(1e-12));
  // Axis in nm.
  folder.write("c.json", replaced(kJson, "\"FLAGS\": \"W", "\"FLAGS\": \"N"));
  const Run nm = read_modtran_json(folder / "c.json").runs[0];
  CHECK(nm.wavelength_um[0] == doctest::Approx(2).epsilon(1e-15));
  CHECK(nm.at("surface_emission").values[0] == doctest::Approx(4).epsilon(1e-12));
}

TEST_CASE("S20 MODTRAN 6 JSON: faults are refused with their place") {
  const auto with = [](const std::string& from, const std::string& to) {
    return refused_json(replaced(kJson, from, to));
  };
  CHECK(holds(with("\"SURF_EMIS\": [4e-7", "\"SURF_EMIS\": [NaN"), "a.json:6:18: the text is no JSON"));
  CHECK(holds(refused_json(kJson.substr(0, 700)), "the text is no JSON"));
  CHECK(holds(with("[4e-7, 2e-7]", "[4e-7, -2e-7]"), "RADIANCE.SURF_EMIS[1]: a value is negative"));
  CHECK(holds(with("[4e-7, 2e-7]", "[4e-7, \"****\"]"), "RADIANCE.SURF_EMIS[1]: no number"));
  CHECK(holds(with("[4e-7, 2e-7]", "[4e-7, null]"), "RADIANCE.SURF_EMIS[1]: no number"));
  CHECK(holds(with("[4e-7, 2e-7]", "[4e-7]"), "RADIANCE.SURF_EMIS: the array is not as long as FREQ"));
  CHECK(holds(with("[4e-7, 2e-7]", "[4e-7, 1e999]"), "a.json"));
  CHECK(holds(with("\"FREQ\": [2000, 2500]", "\"FREQ\": [2000, 2000]"), "FREQ[1]: FREQ does not keep its order"));
  CHECK(holds(with("\"FREQ\": [2000, 2500]", "\"FREQ\": [2000, 9000]"), "does not lie in the band"));
  CHECK(holds(with("4.223e-7", "4.323e-7"), "do not add up"));
  CHECK(holds(with("\"FREQ\": [2000", "\"FRQ\": [2000"), "no array FREQ"));
  // A case without output beside one that has it; alone it is an input, which says what was asked for.
  const std::string two = kJson.substr(0, kJson.size() - 2) + ", {\"MODTRANINPUT\": {}}]}";
  CHECK(holds(refused_json(two), "MODTRAN[1]: no MODTRANOUTPUT.SPECTRA"));
  CHECK(with("MODTRANOUTPUT", "MODTRANOUTPUTS").empty());
  CHECK(holds(refused_json("{}"), "no array MODTRAN"));
}

TEST_CASE("S20 MODTRAN 6 CSV: spectra and fluxes") {
  const TestFolder folder;
  folder.write("a.csv", kCsv);
  const Run run = read_modtran_csv(folder / "a.csv").runs.at(0);
  CHECK(run.mode == "radiance");
  CHECK(run.at("transmittance").values == std::vector<double>{0.25, 0.5});
  CHECK(run.at("path_radiance_thermal").values[1] == doctest::Approx(0.084).epsilon(1e-12));
  folder.write("t.csv", "Freq,combin trans,H2O trans,aercld abtrns\r\n2000,0.5,0.6,0.7\r\n");
  const Run trans = read_modtran_csv(folder / "t.csv").runs.at(0);
  CHECK(trans.mode == "transmittance");
  CHECK(trans.at("transmittance_h2o").values[0] == 0.6);
  CHECK(trans.at("transmittance_aerosol_cloud_absorption").values[0] == 0.7);

  folder.write("f.csv", kFlux);
  const Imported fluxes = read_modtran_csv(folder / "f.csv");
  REQUIRE(fluxes.runs.size() == 1);
  const auto& columns = fluxes.runs[0].columns;
  REQUIRE(columns.size() == 6);
  CHECK(columns[4].name == "irradiance_down_diffuse");
  CHECK(*columns[4].place.height_m == 1500);
  CHECK(columns[4].values[1] == doctest::Approx(5e-6 * 4e6).epsilon(1e-12));
  CHECK(columns[2].name == "irradiance_down_direct");
  CHECK(columns[2].values[0] == doctest::Approx(3.1e-6 * 6.25e6).epsilon(1e-12));
}

TEST_CASE("S20 MODTRAN 6 CSV: faults are refused with file and line") {
  const auto with = [](const std::string& from, const std::string& to) {
    return refused_csv(replaced(kCsv, from, to));
  };
  CHECK(holds(with("4.0e-07", "*******"), "a.csv:4: surface emission did not fit its field"));
  CHECK(holds(with("4.0e-07", "nan"), "a.csv:4: surface emission is not finite"));
  CHECK(holds(with("4.0e-07", "-4.0e-07"), "a.csv:4: surface emission is negative"));
  CHECK(holds(with("4.0e-07", ""), "a.csv:4: surface emission is blank"));
  CHECK(holds(with("4.0e-07,", ""), "a.csv:4: the row has another number of fields"));
  CHECK(holds(with("4.0e-07", "5.0e-07"), "a.csv:4: the parts of total radiance do not add up"));
  CHECK(holds(with("2500.0,", "2000.0,"), "a.csv:5: Freq does not keep its order"));
  CHECK(holds(with("Freq", "Wave"), "no row of labels that starts with Freq"));
  CHECK(holds(refused_csv(kCsv.substr(0, kCsv.find("2000.0"))), "no data rows"));
  CHECK(holds(refused_csv(kCsv.substr(0, kCsv.size() - 12)), "a.csv:5:"));
  const auto flux = [](const std::string& from, const std::string& to) {
    return refused_csv(replaced(kFlux, from, to));
  };
  CHECK(holds(flux("}\n", ""), "the case is not whole"));
  CHECK(holds(flux("num freq, 2", "num freq, 3"), "2 of 3 frequencies"));
  CHECK(holds(flux("num column, 6", "num column, 9"), "do not fit"));
  CHECK(holds(flux("SOLAR, UP", "SIDE, UP"), "not UP, DOWN or SOLAR"));
  CHECK(holds(flux("2.0e-6", "NaN"), "a.csv:6: DOWN is not finite"));
}

TEST_CASE("S20 MODTRAN 6: every JSON and flux file cut short is refused") {
  for (std::size_t length = 0; length < kJson.size(); ++length) {
    CAPTURE(length);
    CHECK_FALSE(refused_json(kJson.substr(0, length)).empty());
  }
  for (std::size_t length = 0; length + 1 < kFlux.size(); ++length) {
    CAPTURE(length);
    CHECK_FALSE(refused_csv(kFlux.substr(0, length)).empty());
  }
}
