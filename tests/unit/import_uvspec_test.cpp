// uvspec with its .inp: small outputs written here, whole and with faults. Oracle: the layouts of libRadtran's manual.
#include "tests/unit/import_kit.h"

#include "atmos_tables/import/uvspec.h"

using namespace raycube;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

const std::string kInput =
    "# a comment\nsource solar ../data/solar_flux/kurudz_1.0nm.dat per_nm\nrte_solver disort\nwavelength 550 551 # "
    "nm\nsza 40\nphi0 30\n"
    "umu -0.5 1.0\nphi 30 120\nzout 0 3\n";
const std::string kBlock =
    "  550.000  7.000000e+02  4.000000e+02  2.200000e+02  8.0e+01  7.0e+01  3.9e+01\n     30.000   120.000\n"
    "-0.5000  1.40e+02  4.04e+02  8.80e+01\n 1.0000  7.80e+01  7.81e+01  7.82e+01\n";
const std::string kUpper = replaced(kBlock, "7.000000e+02", "9.000000e+02");
const std::string kOutput =
    kBlock + kUpper + replaced(kBlock, "550.000", "551.000") + replaced(kUpper, "550.000", "551.000");

struct Files {
  TestFolder folder;
  Files(const std::string& input, const std::string& output) {
    folder.write("a.inp", input), folder.write("a.out", output);
  }
  Imported read() const { return read_uvspec(folder / "a.out"); }
};

std::string refused(const std::string& input, const std::string& output) {
  const Files files(input, output);
  return refusal([&] { files.read(); });
}

}  // namespace

TEST_CASE("S20 uvspec: blocks of levels and directions, azimuths in the project's sense") {
  const Run run = Files(kInput, kOutput).read().runs.at(0);
  REQUIRE(run.wavelength_um.size() == 2);
  CHECK(run.wavelength_um[1] == doctest::Approx(0.551).epsilon(1e-15));
  REQUIRE(run.columns.size() == 2 * (6 + 2 * 3));
  CHECK(*run.geometry.sun_zenith_deg == 40);
  // First level: fluxes, then umu -0.5: mean, phi 30 = phi0 (the sun's side), phi 120.
  CHECK(run.columns[0].name == "irradiance_down_direct");
  CHECK(run.columns[0].values[0] == 700);
  CHECK(run.columns[7].name == "radiance_downward");
  CHECK(*run.columns[7].place.zenith_deg == doctest::Approx(60));
  CHECK(*run.columns[7].place.relative_azimuth_deg == doctest::Approx(0));
  CHECK(run.columns[7].values[1] == 404);
  CHECK(*run.columns[8].place.relative_azimuth_deg == doctest::Approx(90));
  CHECK(run.columns[10].name == "radiance_upward");
  CHECK(*run.columns[10].place.relative_azimuth_deg == doctest::Approx(180));
  CHECK(run.columns[10].unit == "W m-2 sr-1 um-1");
  CHECK(*run.columns[12].place.height_m == 3000);
  CHECK(run.columns[12].values[0] == 900);
}

TEST_CASE("S20 uvspec: units of thermal output, output_user, ratios") {
  const std::string thermal = "source thermal\nwavelength 10000 10000\noutput_process per_cm-1\n";
  const std::string line = " 10000.000  0.0e+00  9.0e-02  2.0e-01  0.0e+00  1.0e-02  4.0e-02\n";
  CHECK(Files(thermal, line).read().runs[0].at("irradiance_down_diffuse").values[0] ==
        doctest::Approx(9).epsilon(1e-12));
  CHECK(Files(replaced(thermal, "per_cm-1", "per_nm"), line).read().runs[0].at("irradiance_down_diffuse").values[0] ==
        doctest::Approx(90).epsilon(1e-12));
  // Without output_process REPTRAN and LOWTRAN write per cm-1, bands of 2 cm-1 in W m-2.
  const Run own = Files(replaced(thermal, "output_process per_cm-1", ""), line).read().runs[0];
  CHECK(own.at("irradiance_down_diffuse").values[0] == doctest::Approx(9).epsilon(1e-12));
  CHECK(own.mode == "thermal fluxes");
  const Run band =
      Files(replaced(thermal, "output_process per_cm-1", "mol_abs_param lowtran\nthermal_bandwidth 2"), line)
          .read()
          .runs[0];
  CHECK(band.mode == "bands");
  CHECK(band.at("irradiance_down_diffuse").unit == "W m-2");
  CHECK(band.at("irradiance_down_diffuse").values[0] == 0.09);
  const std::string user =
      "source solar kurudz_1.0nm.dat\nwavelength 860 860\nsza 40\numu 1.0\nphi 0\nzout TOA\noutput_user lambda "
      "wavenumber sza edir uu\n";
  const Run run = Files(user, "  860.000 11627.907    40.000  6.0e+02  6.8e+01\n").read().runs[0];
  CHECK(run.columns.size() == 2);
  CHECK(run.at("radiance_upward").values[0] == 68);
  CHECK(run.at("radiance_upward").place.top_of_air);
  CHECK(holds(refused(user, "  860.000 11628.907    40.000  6.0e+02  6.8e+01\n"),
              "a.out:1: lambda and wavenumber disagree"));
  CHECK(holds(refused(user, "  860.000 11627.907    41.000  6.0e+02  6.8e+01\n"),
              "a.out:1: sza is not that of the input file"));
  CHECK(holds(refused(replaced(user, "edir uu", "edir heat"), ""), "a.out"));
  const std::string ratio = "source solar mine.dat\nwavelength 750 750\noutput_quantity transmittance\n";
  const Run t = Files(ratio, " 750.000 0.77 -2.0e-15 0.1 0.1 0.1 0.1\n").read().runs[0];
  CHECK(t.at("irradiance_down_diffuse_per_sun").values[0] == 0);
  CHECK(t.at("irradiance_down_direct_per_sun").unit == "1");
}

TEST_CASE("S20 uvspec: faults are refused with file and line") {
  REQUIRE(refused(kInput, kOutput).empty());
  const auto with = [](const std::string& from, const std::string& to) {
    return refused(kInput, replaced(kOutput, from, to));
  };
  CHECK(holds(with("4.04e+02", "********"), "a.out:3: radiances did not fit its field"));
  CHECK(holds(with("4.04e+02", "nan"), "a.out:3: radiances is not finite"));
  CHECK(holds(with("4.04e+02", "-4.04e+02"), "a.out:3: uu is negative"));
  CHECK(holds(with("4.04e+02", ""), "a.out:3: a line of radiances has another number of fields"));
  CHECK(holds(with("30.000   120", "30.000   121"), "a.out:2: phi is not that of the input file"));
  CHECK(holds(with("-0.5000", "-0.6000"), "a.out:3: umu is not that of the input file"));
  CHECK(holds(refused(kInput, kBlock + kUpper + kBlock + kUpper), "a.out:9: wavelengths do not ascend"));
  CHECK(holds(refused(kInput, kBlock + replaced(kUpper, "550.000", "551.000")),
              "a.out:5: the wavelength changes between the levels"));
  CHECK(holds(refused(kInput, kBlock + kUpper + replaced(kBlock, "550.000", "551.000")),
              "the last wavelength has not every level"));
  CHECK(holds(refused(kInput, kOutput.substr(0, kOutput.size() - 30)), "a.out:16:"));
  CHECK(holds(refused(replaced(kInput, "550 551", "550 560"), kOutput),
              "the wavelengths are not those of the input file"));
  CHECK(
      holds(refused(replaced(kInput, "kurudz", "mine"), kOutput), "the unit of the output is that of the solar file"));
  CHECK(holds(refused(replaced(kInput, "rte_solver disort", "rte_solver polradtran"), kOutput),
              "the layout of this rte_solver is not known"));
  CHECK(holds(refused(kInput + "include other.inp\n", kOutput), "a.inp:10: the included file is not there"));
  CHECK(holds(refused(replaced(kInput, "zout 0 3", "zout 0 x"), kOutput), "a.inp:9: zout is no number"));
  const TestFolder folder;
  folder.write("b.out", kOutput);
  CHECK(holds(refusal([&] { read_uvspec(folder / "b.out"); }), "name its input file"));
}
