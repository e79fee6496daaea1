// Inputs as libRadtran's own examples write them: included files, slit functions, splines, default sun, bands, columns
// of output_user. Oracle: libRadtran's documentation of its options, arithmetic by hand.
#include "tests/unit/import_kit.h"

#include "atmos_tables/import/import_file.h"
#include "atmos_tables/import/uvspec.h"
#include "atmos_tables/import/uvspec_input.h"

using namespace raycube;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

const std::string kBase =
    "atmosphere_file ../data/atmmod/afglus.dat\nsource solar ../data/solar_flux/atlas_plus_modtran\nsza 32.0\n"
    "day_of_year 170\nalbedo 0.2\nrte_solver disort\nwavelength 299.0 341.0\nslit_function_file ../examples/SLIT.DAT\n"
    "spline 300 302 1         # nm\nquiet\n";
const std::string kFluxes = "  7.0e+02  4.0e+02  2.2e+02  8.0e+01  7.0e+01  3.9e+01\n";

std::string lines(const std::string& rest, std::initializer_list<const char*> nm) {
  std::string out;
  for (const char* at : nm) out += "  " + std::string(at) + rest;
  return out;
}

/// Reads `output` with `input`; other files stand beside.
Run read(const std::string& input, const std::string& output,
         std::initializer_list<std::pair<const char*, std::string>> beside = {}) {
  const TestFolder folder;
  folder.write("a.inp", input), folder.write("a.out", output);
  for (const auto& [name, text] : beside) folder.write(name, text);
  return read_uvspec(folder / "a.out").runs.at(0);
}
std::string refused(const std::string& input, const std::string& output = lines(kFluxes, {"550.000"})) {
  return refusal([&] { read(input, output); });
}

}  // namespace

TEST_CASE("S20 uvspec: included files, nested, the last word holds; slit function and spline of the outermost file") {
  const std::string three = lines(kFluxes, {"300.000", "301.000", "302.000"});
  const std::pair<const char*, std::string> base{"BASE.INP", kBase},
      slit{"SLIT.DAT", "# nm\n-1.0 0.0\n-0.5 0.5\n0.0 1.0\n0.5 0.5\n1.0 0.0\n"};
  const Run run = read("include ../examples/MID.INP\nsza 40\n", three,
                       {base, slit, {"MID.INP", "include ../examples/BASE.INP # nested\naerosol_default\n"}});
  CHECK(*run.geometry.sun_zenith_deg == 40);
  CHECK(*run.geometry.ground_albedo == 0.2);
  CHECK(*run.geometry.day_of_year == 170);
  CHECK(run.mode == "fluxes");
  CHECK(run.at("irradiance_down_direct").values == std::vector<double>(3, 700));
  REQUIRE(run.notes.size() == 1);
  CHECK(run.notes[0] == "convolved with the slit function ../examples/SLIT.DAT, 1 nm wide at half its height");
  // The same without the slit's file: its width is not said.
  CHECK(read("include BASE.INP\n", three, {base}).notes[0] == "convolved with the slit function ../examples/SLIT.DAT");
  // Two-stream solver over the included DISORT: five columns.
  const Run two =
      read("include BASE.INP\nrte_solver ftwostr\n", lines("  7e2  4e2  2e2  8e1\n", {"300", "301", "302"}), {base});
  CHECK(two.columns.size() == 4);
  // Other wavelengths than the spline's, and a ring of files.
  CHECK(holds(refusal([&] {
                read("include BASE.INP\n", lines(kFluxes, {"300.000", "301.000"}), {base});
              }),
              "not those that spline asks for (found 2 of 3)"));
  CHECK(holds(refusal([&] { read("include b.inp\n", three, {{"b.inp", "include a.inp\n"}}); }), "include each other"));
  CHECK(holds(refused("include\n"), "a.inp:1: include names no file"));
  CHECK(holds(refused("spline 300 200 1\nsource solar kurudz\n"), "spline needs first and last wavelength"));
  // Inputs end in .INP where libRadtran's examples do.
  const TestFolder folder;
  folder.write("EXAMPLE.INP", "source solar kurudz_1.0nm.dat\n"), folder.write("EXAMPLE.OUT", lines(kFluxes, {"550"}));
  CHECK(import_file(folder / "EXAMPLE.OUT").format == "uvspec");
  // Wavelengths of a file.
  const Run file = read("source solar kurudz_1.0nm.dat\nspline_file grid.dat\n", lines(kFluxes, {"300.5", "301.25"}),
                        {{"grid.dat", "300.5\n301.25\n"}});
  CHECK(file.wavelength_um[1] == doctest::Approx(0.30125));
}

TEST_CASE("S20 uvspec: what stands where nothing is said: sun in the zenith, surface, the sun of REPTRAN by its size") {
  const Run run = read("wavelength 550 550\nsource solar\n", lines(kFluxes, {"550.000"}));
  CHECK(*run.geometry.sun_zenith_deg == 0);
  CHECK(*run.columns[0].place.height_m == 0);
  CHECK(run.at("irradiance_down_direct").values[0] == 700);
  // 0.7 W m-2 nm-1 is the same light in W: read as mW it is less than 1/1000 of the sun, which may be dark air too.
  const std::string dim = lines("  7.0e-01  4.0e-01  2.2e-01  8.0e-02  7.0e-02  3.9e-02\n", {"550.000"});
  CHECK(
      holds(refusal([&] { read("wavelength 550 550\n", dim); }), "whether the numbers are in mW or W cannot be told"));
  CHECK(refusal([&] { read("wavelength 550 550\nsource solar kurudz_1.0nm.dat\n", dim); }).empty());
  // Gases that need a file; a place and a time instead of a zenith, which output_user tells.
  CHECK(holds(refused("mol_abs_param crs\n"), "uvspec needs a solar file with this mol_abs_param"));
  const std::string there = "source solar kurudz_1.0nm.dat\nlatitude N 48\nlongitude E 11\ntime 2020 6 1 12 0 0\n";
  CHECK(!read(there, lines(kFluxes, {"550.000"})).geometry.sun_zenith_deg);
  CHECK(*read(there + "output_user lambda sza edir\n", "550.000 26.5 7e2\n").geometry.sun_zenith_deg == 26.5);
}

TEST_CASE("S20 uvspec: units: photons, per cm-1 of sunlight, bands, sums and filters") {
  const auto first = [](const std::string& input, const char* nm = "500.000") {
    const Run run = read(input, lines(kFluxes, {nm}));
    return std::pair{run.columns[0].values[0], run.columns[0].unit};
  };
  // 700 photons s-1 cm-2 nm-1 at 500 nm: h c / lambda = 3.97289171e-19 J each.
  CHECK(first("source solar atlas_plus_modtran_ph\n").first ==
        doctest::Approx(700e4 * 3.97289171e-19 * 1e3).epsilon(1e-8));
  // 700 mW m-2 per cm-1 at 500 nm: 1 cm-1 is 0.025 nm.
  CHECK(first("source solar kurudz_1.0nm.dat per_nm\noutput_process per_cm-1\n").first ==
        doctest::Approx(28000).epsilon(1e-12));
  CHECK(first("mol_abs_param KATO\n") == std::pair{700.0, std::string("W m-2")});
  CHECK(first("source solar fu\nmol_abs_param fu\noutput_process sum\n") == std::pair{700.0, std::string("W m-2")});
  const auto filtered = first("source solar kurudz_0.1nm.dat\noutput_process integrate\nfilter_function_file f.dat\n");
  CHECK(filtered.first == doctest::Approx(0.7).epsilon(1e-15));
  CHECK(filtered.second == "W m-2");
  CHECK(first("source solar kurudz_0.1nm.dat\noutput_process integrate\nfilter_function_file f.dat normalize\n") ==
        std::pair{700.0, std::string("W m-2 um-1")});
  CHECK(first("source thermal\nmol_abs_param avhrr_kratz\noutput_quantity brightness\noutput_process sum\n").second ==
        "K");
  CHECK(holds(refused("source solar kurudz_1.0nm.dat\nmol_abs_param crs\noutput_process sum\n"),
              "a sum over wavelengths"));
  CHECK(holds(refused("source solar kurudz_1.0nm.dat\nfilter_function_file f.dat\n"), "multiplied by the filter"));
  CHECK(holds(refused("mol_abs_param avhrr_kratz\n"), "the unit of the solar file of this mol_abs_param"));
  CHECK(
      holds(refused("source thermal\noutput_process integrate\nfilter_function_file f.dat normalize\n"), "normalized"));
  CHECK(holds(refused("source thermal x.dat per_nm\n"), "uvspec's own"));
  CHECK(holds(refused("output_process rgb\n"), "only per_nm, per_cm-1, per_band"));
}

TEST_CASE("S20 uvspec output_user: radiances without phi are azimuth means, the air's columns are left out") {
  const std::string input =
      "source solar kurudz_1.0nm.dat\nmol_abs_param crs\numu -1 -0.5\noutput_user wavelength edir p T uu\n";
  const Run run = read(input, "  290.000 1e1 1013.0 288.1 2e0 3e0\n");
  REQUIRE(run.columns.size() == 3);
  CHECK(run.columns[2].name == "radiance_downward_azimuth_mean");
  CHECK(*run.columns[2].place.zenith_deg == doctest::Approx(60));
  CHECK(run.columns[2].values[0] == 3);
  CHECK(run.notes.size() == 2);
  CHECK(holds(run.notes[0], "column p is no light"));
  // By wavenumber alone.
  const Run wave = read("source thermal\nzout sur toa\noutput_user wavenumber zout edn eup\n",
                        "1000.0 0.0 1e-1 2e-1\n1000.0 120.0 0.0 1e-1\n");
  CHECK(wave.wavelength_um[0] == doctest::Approx(10));
  CHECK(wave.at("irradiance_up").values[0] == doctest::Approx(20));
  CHECK(wave.columns[3].place.top_of_air);
  const Run albedo =
      read("source solar kurudz_1.0nm.dat\ndisort_spherical_albedo\numu 0.5 1\noutput_user lambda spher_alb\n",
           "  549.000 0.17\n");
  CHECK(albedo.at("spherical_albedo").values[0] == 0.17);
  CHECK(holds(refused("source solar kurudz_1.0nm.dat\noutput_user zout edir\n"), "output_user without lambda"));
  CHECK(holds(refused("source solar kurudz_1.0nm.dat\nheating_rate local\n"), "prints a matrix of heating rates"));
  CHECK(holds(refused("source solar kurudz_1.0nm.dat\nrte_solver rodents\n"), "the layout of this rte_solver"));
  CHECK(refusal([&] {
          read("source solar kurudz_1.0nm.dat\nrte_solver rodents\noutput_user wavelength edir\n", "550 1e1\n");
        }).empty());
  CHECK(holds(refused("sza_file s.dat\n"), "a.inp:1: this setting is not read: the sun's zenith changes"));
  CHECK(holds(refused("pressure_out 1000 500\n"), "give zout in km"));
}
