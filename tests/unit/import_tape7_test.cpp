// tape7 and .7sc: small runs written here in MODTRAN's columns, whole and with every fault. Oracle: the format's rules
// and arithmetic by hand.
#include "tests/unit/import_kit.h"

#include "atmos_tables/import/modtran_tape7.h"

using namespace raycube;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

/// Card echo of a slant path from 3 km to the ground, sun 40 deg at azimuth 60 deg from the line of sight (IPARM = 2).
std::string cards(int iemsct, const std::string& band = "    2000.0    2500.0       1.0       1.0NW              ") {
  return "T F 2    2    " + std::to_string(iemsct) +
         "    1    2    2    2    2    2    2    1    0    0 300.000   0.30\n"
         "    1    1    1    0    0    0  23.00000   0.00000   0.00000   0.00000   0.00000\n"
         "   36MID-LATITUDE SUMMER\n"
         "   3.00000   0.00000 150.00000   3.46500   0.01556   0.00000    0        0.00000\n"
         "    2    2    1    0\n"
         "  60.00000  40.00000   0.00000   0.00000  12.00000   0.00000   0.00000   0.00000\n" +
         band + "\n    0   0    0.000  0    0.000  0    0.700\n";
}

const std::string kHeader =
    "    FREQ  TOT_TRANS  PTH_THRML  THRML_SCT  SURF_EMIS   SOL_SCAT  SING_SCAT  GRND_RFLT  DRCT_RFLT  TOTAL_RAD  "
    "REF_SOL  SOL@OBS   DEPTH DIR_EM    TOA_SUN BBODY_T[K]\n";
const std::string kRows =
    " 2000.00 0.50000000 2.0000E-08 1.0000E-10 4.0000E-07 3.0000E-10 2.0000E-10 1.0000E-09 5.0000E-10 4.2130E-07 "
    "8.00E-07 9.00E-07   0.693 0.7000 1.0000E-06    290.000\n"
    " 2500.00 0.25000000 1.0000E-08 1.0000E-10 2.0000E-07 3.0000E-10 2.0000E-10 1.0000E-09 5.0000E-10 2.1130E-07 "
    "7.00E-07 8.00E-07   1.386 0.7000 1.1000E-06    285.000\n";
const std::string kEnd = " -9999.\n";

struct File {
  TestFolder folder;
  std::string path;
  explicit File(const std::string& text) : path(folder / "tape7") { folder.write("tape7", text); }
  Imported read() const { return read_tape7(path); }
};

std::string refused(const std::string& text) {
  const File file(text);
  return refusal([&] { file.read(); });
}

}  // namespace

TEST_CASE("S20 tape7: a radiance run, its units, order and geometry") {
  const File file(cards(2) + kHeader + kRows + kEnd);
  const Imported imported = file.read();
  REQUIRE(imported.runs.size() == 1);
  const Run& run = imported.runs[0];
  CHECK(run.mode == "radiance");
  // 2500 cm-1 is 4 um and comes first.
  REQUIRE(run.wavelength_um.size() == 2);
  CHECK(run.wavelength_um[0] == doctest::Approx(4).epsilon(1e-15));
  CHECK(run.wavelength_um[1] == doctest::Approx(5).epsilon(1e-15));
  CHECK(run.at("transmittance").values == std::vector<double>{0.25, 0.5});
  // L = 2.0E-8 x 2000^2 = 0.08 W m-2 sr-1 um-1; 1e-8 x 2500^2 = 0.0625.
  CHECK(run.at("path_radiance_thermal").values[1] == doctest::Approx(0.08).epsilon(1e-12));
  CHECK(run.at("path_radiance_thermal").values[0] == doctest::Approx(0.0625).epsilon(1e-12));
  CHECK(run.at("solar_irradiance").values[1] == doctest::Approx(4.0).epsilon(1e-12));
  CHECK(run.at("solar_irradiance").unit == "W m-2 um-1");
  CHECK(run.at("brightness_temperature").values[1] == 290);
  CHECK(run.at("ground_reflected_direct").values[1] == doctest::Approx(0.002).epsilon(1e-12));
  CHECK(run.at("optical_depth").rounding[0] == doctest::Approx(0.0005));
  CHECK(*run.geometry.sensor_height_m == 3000);
  CHECK(*run.geometry.path_end_height_m == 0);
  CHECK(*run.geometry.path_length_m == doctest::Approx(3465));
  CHECK(*run.geometry.sight_zenith_deg == 150);
  CHECK(*run.geometry.view_zenith_deg == doctest::Approx(30.01556));
  CHECK(*run.geometry.sun_zenith_deg == 40);
  CHECK(*run.geometry.relative_azimuth_deg == doctest::Approx(120));
}

TEST_CASE("S20 tape7: labels of MODTRAN 4, columns not computed, runs after each other") {
  std::string header = kHeader, rows = kRows;
  for (char& c : header)
    if (c == '_') c = ' ';
  header = replaced(header, "BBODY T", "BBODY_T");
  // No sun was computed: those fields are blank in every row.
  for (std::size_t line = 0; line < 2; ++line) {
    const std::size_t at = rows.find('\n') + 1;
    const std::size_t from = line == 0 ? 0 : at;
    for (std::size_t i = 54 - 1; i < 75; ++i) rows[from + i - 1] = ' ';
  }
  rows = replaced(rows, "4.2130E-07", "4.2100E-07"), rows = replaced(rows, "2.1130E-07", "2.1100E-07");
  const File file(cards(2) + header + kRows + kEnd + "\n" + cards(1) + kHeader + rows + kEnd);
  const Imported imported = file.read();
  REQUIRE(imported.runs.size() == 2);
  CHECK(imported.runs[0].at("path_radiance_solar").values[1] == doctest::Approx(3.0e-10 * 4e6).epsilon(1e-12));
  CHECK(imported.runs[1].find("path_radiance_solar") == nullptr);
  CHECK(imported.runs[1].find("path_radiance_solar_single") == nullptr);
  CHECK(imported.runs[1].at("ground_reflected").values[1] == doctest::Approx(0.004).epsilon(1e-12));
}

TEST_CASE("S20 tape7: labels of MODTRAN 6 give solar path radiance as the sum of its parts") {
  std::string header = replaced(kHeader, " SOL_SCAT", "MULT_SCAT"), rows = kRows;
  rows = replaced(rows, "4.2130E-07", "4.2150E-07"), rows = replaced(rows, "2.1130E-07", "2.1150E-07");
  const File file(cards(2) + header + rows + kEnd);
  CHECK(file.read().runs[0].at("path_radiance_solar").values[1] == doctest::Approx(5.0e-10 * 4e6).epsilon(1e-12));
}

TEST_CASE("S20 tape7: axis in nm by the flags of card 4, and .7sc of the same layout") {
  std::string rows = replaced(replaced(kRows, " 2000.00", " 1000.00"), " 2500.00", " 1100.00");
  const File file(cards(2, "     900.0    1200.0       1.0       1.0NW        N     ") + kHeader + rows + kEnd);
  const Imported imported = read_tape7(file.path, "7sc");
  CHECK(imported.format == "7sc");
  const Run& run = imported.runs[0];
  CHECK(run.wavelength_um[0] == doctest::Approx(1.0).epsilon(1e-15));
  CHECK(run.at("surface_emission").values[0] == doctest::Approx(4.0).epsilon(1e-12));  // 4e-7 W cm-2 sr-1 nm-1
  const File um(cards(2, "       0.9       1.2       0.1       0.1NW        M     ") + kHeader +
                replaced(replaced(kRows, " 2000.00", " 1.00000"), " 2500.00", " 1.10000") + kEnd);
  CHECK(um.read().runs[0].at("surface_emission").values[0] == doctest::Approx(4e-3).epsilon(1e-12));
}

TEST_CASE("S20 tape7: transmittances, touching labels, and direct irradiance with its depth") {
  const std::string trans =
      "    FREQ COMBIN    H2O   UMIX     O3  TRACE     N2    H2O MOLEC AER+CLD  HNO3 AER+CLD    -LOG    CO2 "
      "H2-CH4CH4-CH4\n"
      "    CM-1  TRANS  TRANS  TRANS  TRANS  TRANS   CONT   CONT   SCAT  TRANS  TRANS abTRNS  COMBIN  TRANS  TRANS  "
      "TRANS\n"
      " 2000.00 0.9100 0.9726 0.9679 0.9998 1.0000 1.0000 0.9775 1.0000 0.9891 1.0000 0.9983   0.094 0.9699 1.0000 "
      "0.9990\n";
  const File file(cards(0) + trans + kEnd);
  const Run run = file.read().runs[0];
  CHECK(run.mode == "transmittance");
  CHECK(run.at("transmittance").values[0] == 0.91);
  CHECK(run.at("transmittance_h2o").values[0] == 0.9726);
  CHECK(run.at("transmittance_h2o_continuum").values[0] == 0.9775);
  CHECK(run.at("transmittance_aerosol_cloud").values[0] == 0.9891);
  CHECK(run.at("transmittance_aerosol_cloud_absorption").values[0] == 0.9983);
  CHECK(run.at("optical_depth").values[0] == 0.094);
  CHECK(run.at("transmittance_co2").values[0] == 0.9699);
  CHECK(run.at("transmittance_h2_ch4").values[0] == 1);
  CHECK(run.at("transmittance_ch4_ch4").values[0] == 0.999);
  CHECK(holds(refused(cards(0) + replaced(trans, " 0.9990\n", "\n") + kEnd),
              ":11: the row has another number of fields"));

  const std::string direct =
      "    FREQ   TRANS     SOL TR  SOLAR\n 2000.00  0.5000 4.00E-07 8.00E-07                    6.931E-01\n";
  const Run sun = File(cards(3) + direct + kEnd).read().runs[0];
  CHECK(sun.at("solar_irradiance").values[0] == doctest::Approx(3.2).epsilon(1e-12));
  CHECK(sun.at("solar_irradiance_transmitted").values[0] == doctest::Approx(1.6).epsilon(1e-12));
  CHECK(sun.at("optical_depth").values[0] == 0.6931);
  CHECK(sun.at("optical_depth").unit == "1");
}

TEST_CASE("S20 tape7: faults are refused with file and line") {
  const auto with = [](const std::string& from, const std::string& to) {
    return cards(2) + kHeader + replaced(kRows, from, to) + kEnd;
  };
  // Rows stand in lines 10 and 11.
  CHECK(holds(refused(with("4.0000E-07", "**********")), "tape7:10: SURF_EMIS did not fit its field"));
  CHECK(holds(refused(with("4.0000E-07", "       NaN")), "tape7:10: SURF_EMIS is not finite"));
  CHECK(holds(refused(with("4.0000E-07", "  Infinity")), "tape7:10: SURF_EMIS is not finite"));
  CHECK(holds(refused(with(" 4.0000E-07", "-4.0000E-07")), "tape7:10: SURF_EMIS is negative"));
  CHECK(holds(refused(with("4.0000E-07", "4.00x0E-07")), "tape7:10: SURF_EMIS is no number"));
  CHECK(holds(refused(with("2.0000E-07", "          ")), "tape7:11: SURF_EMIS is blank here"));
  CHECK(holds(refused(with("4.0000E-07", "4.0000E-0 ")),
              "tape7:10: the number under SURF_EMIS does not end where its label ends"));
  CHECK(holds(refused(with("   290.000", "    290.000")), "tape7:10:"));
  CHECK(holds(refused(with(" 2500.00", " 2000.00")), "tape7:11: FREQ does not keep its order"));
  CHECK(holds(refused(with(" 2500.00", " 4500.00")), "does not lie in the band"));
  CHECK(holds(refused(with("4.0000E-07", "5.0000E-07")), "tape7:10: the parts of TOTAL_RAD do not add up"));
  CHECK(holds(refused(with("0.50000000", "1.50000000")), "a value is above 1"));
  // A last digit is within what was printed: the sum holds to it, and no further.
  CHECK(refused(with("4.2130E-07", "4.2131E-07")).empty());
  CHECK(holds(refused(with("4.2130E-07", "4.2134E-07")), "do not add up"));
  // Exponents without E are read.
  CHECK(refused(with("1.0000E-10", " 1.000-110")).empty());
  // Cut short: no end mark; within the last row; within the header.
  CHECK(holds(refused(cards(2) + kHeader + kRows), "without the mark -9999"));
  const std::string whole = cards(2) + kHeader + kRows;
  CHECK(holds(refused(whole.substr(0, whole.size() - 60)), "tape7:11:"));
  CHECK(holds(refused(cards(2) + kHeader + kEnd), "no data rows"));
  CHECK(holds(refused(cards(2)), "no header line"));
  CHECK(holds(refused(cards(0) + kHeader + kRows + kEnd), "the header is not that of the run on card 1"));
  // Rows swapped in a longer run.
  const std::string third = replaced(kRows.substr(kRows.find('\n') + 1), " 2500.00", " 2200.00");
  CHECK(holds(refused(cards(2) + kHeader + kRows + third + kEnd), "tape7:12: FREQ does not keep its order"));
  const TestFolder folder;
  folder.write("empty", "");
  CHECK(holds(refusal([&] { read_tape7(folder / "empty"); }), "the file is empty"));
}

TEST_CASE("S20 tape7: every file cut short is refused, and no damaged byte ends the program") {
  const std::string whole = cards(2) + kHeader + kRows + kEnd;
  const TestFolder folder;
  const auto outcome = [&](const std::string& text) {
    folder.write("tape7", text);
    return refusal([&] { read_tape7(folder / "tape7"); });
  };
  REQUIRE(outcome(whole).empty());
  // The mark's own point and newline say nothing.
  for (std::size_t length = 0; length + 2 < whole.size(); ++length) {
    CAPTURE(length);
    CHECK_FALSE(outcome(whole.substr(0, length)).empty());
  }
  for (std::size_t i = 0; i < whole.size(); ++i)
    for (const char damage : {'*', '-', ' ', '\n', '\0', '\xff', '9'}) {
      std::string damaged = whole;
      damaged[i] = damage;
      outcome(damaged);  // read or refused as bad input; refusal() checks the kind of error
    }
}
