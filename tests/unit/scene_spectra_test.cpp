// Spectra and bands: units, medium, files of other programs.
#include <bit>
#include <cmath>

#include "scene_compiler/air_wavelength.h"
#include "scene_compiler/band_list.h"
#include "scene_compiler/envi_library.h"
#include "scene_compiler/spectrum_file.h"
#include "scene_files.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

const Material& material(const Simulation& simulation, const std::string& name) {
  for (const auto& m : simulation.scene.materials)
    if (m.name == name) return m;
  FAIL("no material " << name);
  return simulation.scene.materials.front();
}

std::string instrument(const std::string& bands) {
  return std::string(kHead) +
         "time = { sun = { zenith_deg = 30 } }\n[[instrument]]\nname = \"i\"\nkind = \"framing\"\npixels = "
         "2\nlines = 2\nposition_m = [0, 0, 100]\nifov_mrad = 1\n" +
         bands;
}

template <class T>
std::string bytes(std::vector<T> values, bool big_endian) {
  std::string out;
  for (const T value : values) {
    std::string raw(reinterpret_cast<const char*>(&value), sizeof(T));
    if (big_endian) std::reverse(raw.begin(), raw.end());
    out += raw;
  }
  return out;
}

std::string library_header(int type, int order, const std::string& more = "") {
  return "ENVI\nsamples = 3\nlines = 2\nbands = 1\nheader offset = 0\nfile type = ENVI Spectral "
         "Library\ndata type = " +
         std::to_string(type) + "\nbyte order = " + std::to_string(order) +
         "\nwavelength units = Nanometers\nspectra names = {\n grass, dry soil}\nwavelength = {\n 400.0, "
         "500.0,\n 600.0}\n" +
         more;
}

}  // namespace

TEST_CASE("air to vacuum: published pairs of lines (S42 wavelengths)") {
  // NIST Atomic Spectra Database, air and vacuum wavelengths of [O III] and H-alpha as SDSS lists them (nm):
  // 500.6843 and 500.8240; 656.2801 and 656.4614. Their last digit is 1e-4 nm.
  CHECK(vacuum_from_air_um(0.5006843) == doctest::Approx(0.5008240).epsilon(2e-7));
  CHECK(vacuum_from_air_um(0.6562801) == doctest::Approx(0.6564614).epsilon(2e-7));
  // Round trip: dividing by the index brings the air wavelength back to the last bits.
  for (const double air_um : {0.35, 0.55, 1.0, 2.5, 10.0}) {
    const double vacuum_um = vacuum_from_air_um(air_um);
    CHECK(vacuum_um / ciddor_air_index(vacuum_um) == doctest::Approx(air_um).epsilon(1e-15));
  }
}

TEST_CASE("S1 material spectrum: nm and um columns give one curve; source and medium come from comments") {
  const Folder folder;
  folder.write("nm.csv",
               "# source: Somebody 2001\n# medium: "
               "air\nwavelength_nm,reflectance,transmittance\n400,0.1,0.2\n500,0.3,0.4\n");
  folder.write("um.csv", "wavelength_um,reflectance\n0.4,0.1\n0.5,0.3\n");
  const auto simulation = load(
      folder, std::string(kHead) +
                  "[[material]]\nname = \"a\"\nfile = \"nm.csv\"\n[[material]]\nname = \"b\"\nfile = \"um.csv\"\n");
  const auto &a = material(simulation, "a"), &b = material(simulation, "b");
  CHECK(a.source == "Somebody 2001");
  CHECK(a.reflectance.wavelength_um[0] == vacuum_from_air_um(400 * 1e-3));
  CHECK(b.reflectance.wavelength_um == std::vector<double>{0.4, 0.5});
  CHECK(b.reflectance.value == std::vector<double>{0.1, 0.3});
  CHECK(a.transmittance.value == std::vector<double>{0.2, 0.4});
  CHECK(b.transmittance.value.empty());
}

TEST_CASE("S1 material in percent: scale") {
  const Folder folder;
  folder.write("p.csv", "wavelength_um,reflectance\n0.4,10\n0.5,30\n");
  const auto simulation =
      load(folder, std::string(kHead) + "[[material]]\nname = \"a\"\nfile = \"p.csv\"\nscale = 0.01\n");
  CHECK(material(simulation, "a").reflectance.value[1] == doctest::Approx(0.3).epsilon(1e-15));
}

TEST_CASE("ENVI spectral library: both byte orders, float and scaled integers, read alike") {
  const Folder folder;
  const std::vector<float> values{0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f};
  folder.write("le.sli", bytes(values, false));
  folder.write("le.sli.hdr", library_header(4, 0));
  folder.write("be.sli", bytes(values, true));
  folder.write("be.hdr", library_header(4, 1));
  folder.write("i2.sli", bytes<std::int16_t>({1000, 2000, 3000, 4000, 5000, 6000}, true));
  folder.write("i2.sli.hdr", library_header(2, 1, "reflectance scale factor = 10000\n"));
  base::Problems problems;
  for (const char* name : {"le.sli", "be.sli", "i2.sli"}) {
    CAPTURE(name);
    SpectrumRequest request;
    request.file = folder.at(name);
    request.spectrum = "dry soil";
    const auto read = read_spectrum(request, problems);
    REQUIRE(read);
    CHECK(read->reflectance.wavelength_um == std::vector<double>{0.4, 0.5, 0.6});
    for (int i = 0; i < 3; ++i) CHECK(read->reflectance.value[i] == doctest::Approx(0.4 + 0.1 * i).epsilon(1e-7));
  }
  CHECK(problems.empty());
}

TEST_CASE("bad input: ENVI library truncated, huge sizes, wrong byte order, unknown unit or name") {
  const Folder folder;
  const auto library = [&](const std::string& header, const std::string& data, const std::string& name = "grass") {
    folder.write("l.sli", data);
    folder.write("l.sli.hdr", header);
    return refusal(folder,
                   std::string(kHead) + "[[material]]\nname = \"a\"\nfile = \"l.sli\"\nspectrum = \"" + name + "\"\n");
  };
  const std::string good = bytes<float>({0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f}, false);
  CHECK(library(library_header(4, 0), good) == "");
  CHECK_SAYS(library(library_header(4, 0), good.substr(0, 20)),
             "l.sli: data file is shorter than its header says (found 20 bytes for 2 spectra of 3 samples)");
  // Read with the wrong byte order, 0.1f becomes -4.3e8: refused by its value, with its place.
  CHECK_SAYS(library(library_header(4, 1), good), "l.sli: spectrum 'grass', sample 1: reflectance outside 0 .. 1");
  std::string huge = library_header(4, 0);
  huge.replace(huge.find("samples = 3"), 11, "samples = 99999999999");
  CHECK_SAYS(library(huge, good), "data file is shorter than its header says");
  std::string unit = library_header(4, 0);
  unit.replace(unit.find("Nanometers"), 10, "Index");
  CHECK_SAYS(library(unit, good),
             "l.sli.hdr:9: unknown wavelength unit (found Index); write Micrometers or Nanometers");
  CHECK_SAYS(library(library_header(6, 0), good), "l.sli.hdr:7: ENVI data type is not a real number's (found 6)");
  CHECK_SAYS(library(library_header(4, 0), good, "gras"),
             "scene.toml:5:1: spectral library has no spectrum of that name (found 'gras'); it holds: grass, "
             "dry soil");
  CHECK_SAYS(library("ENVI\nsamples = 3\n", good), "ENVI header lacks 'lines'");
}

TEST_CASE("bands: regular grid, units, out-of-order and duplicate bands come out ascending with a notice") {
  const Folder folder;
  const auto regular = load(folder, instrument("bands = { first_nm = 400, step_nm = 2.5, count = 5, fwhm_nm = 3 }\n"));
  REQUIRE(regular.instruments.at(0).bands.size() == 5);
  CHECK(regular.instruments[0].bands[4].center_um == doctest::Approx(0.41).epsilon(1e-15));
  CHECK(regular.instruments[0].bands[4].fwhm_um == doctest::Approx(0.003).epsilon(1e-15));
  CHECK(regular.notices.empty());
  folder.write("b.csv", "center_nm,fwhm_nm\n900,10\n500,9\n900,20\n895,40\n");
  const auto listed = load(folder, instrument("bands = \"b.csv\"\n"));
  const auto& bands = listed.instruments.at(0).bands;
  REQUIRE(bands.size() == 4);
  CHECK(bands[0].center_um == doctest::Approx(0.5).epsilon(1e-15));
  CHECK(bands[1].fwhm_um == doctest::Approx(0.04).epsilon(1e-15));
  // Equal centres keep the file's order.
  CHECK(bands[2].fwhm_um == doctest::Approx(0.01).epsilon(1e-15));
  CHECK(bands[3].fwhm_um == doctest::Approx(0.02).epsilon(1e-15));
  REQUIRE(listed.notices.size() == 1);
  CHECK_SAYS(listed.notices[0], "were not ascending and have been sorted");
  folder.write("u.csv", "center_um,fwhm_um\n0.5,0.009\n");
  CHECK(load(folder, instrument("bands = \"u.csv\"\n")).instruments[0].bands[0].center_um == 0.5);
}

TEST_CASE("bands: tabulated responses, wide and long tables give the same bands; centre is the mean wavelength") {
  const Folder folder;
  folder.write("w.csv", "wavelength_nm,green,red\n500,0,0\n550,1,0\n600,0,0\n650,0,1\n700,0,1\n750,0,0\n");
  folder.write("l.csv",
               "band,wavelength_nm,response\nred,600,0\nred,650,1\nred,700,1\nred,750,0\ngreen,500,0\ngreen,"
               "550,1\ngreen,600,0\n");
  const auto wide = load(folder, instrument("bands = \"w.csv\"\n")).instruments.at(0).bands;
  const auto tall = load(folder, instrument("bands = { file = \"l.csv\" }\n")).instruments.at(0).bands;
  REQUIRE(wide.size() == 2);
  REQUIRE(tall.size() == 2);
  for (int i = 0; i < 2; ++i) {
    CHECK(wide[i].name == tall[i].name);
    CHECK(wide[i].wavelength_um == tall[i].wavelength_um);
    CHECK(wide[i].response == tall[i].response);
    CHECK(wide[i].fwhm_um == 0);
  }
  // A triangle about 550 nm and a trapezoid about 675 nm: centres by symmetry.
  CHECK(wide[0].center_um == doctest::Approx(0.550).epsilon(1e-14));
  CHECK(wide[1].center_um == doctest::Approx(0.675).epsilon(1e-14));
}

TEST_CASE("quicklook bands: by number from 1, by wavelength, and by default") {
  const Folder folder;
  const std::string visible = "bands = { first_nm = 400, step_nm = 10, count = 40, fwhm_nm = 10 }\n";
  CHECK(load(folder, instrument(visible)).instruments[0].quicklook_bands == std::vector<int>{25, 15, 5});
  CHECK(load(folder, instrument(visible + "quicklook_bands = [3, 2, 1]\n")).instruments[0].quicklook_bands ==
        std::vector<int>{2, 1, 0});
  CHECK(load(folder, instrument(visible + "quicklook_nm = [703]\n")).instruments[0].quicklook_bands ==
        std::vector<int>{30});
  CHECK_SAYS(refusal(folder, instrument(visible + "quicklook_bands = [41]\n")), "no such band (found 41 of 40)");
  CHECK(load(folder, instrument("bands = { first_nm = 1000, step_nm = 10, count = 5, fwhm_nm = 10 }\n"))
            .instruments[0]
            .quicklook_bands == std::vector<int>{4, 2, 0});
}

TEST_CASE("real input: measured spectra and spectral libraries nobody here wrote") {
  const auto shared = shared_folder("measured spectra");
  if (!shared) return;
  const Folder folder;
  const std::string data = *shared + "/data/";
  const auto simulation =
      load(folder, std::string(kHead) + "[[material]]\nname = \"maple\"\nfile = \"" + data +
                       "spectra/usgs_maple_leaves.csv\"\n" + "[[material]]\nname = \"beech\"\nfile = \"" + data +
                       "spectra/lopex_leaf_fagus_sylvatica.csv\"\n" + "[[material]]\nname = \"asphalt\"\nfile = \"" +
                       data + "envi/library_berlin.sli\"\nspectrum = \"asphalt 1\"\nscale = 0.0001\n");
  CHECK(material(simulation, "maple").reflectance.value[2] == 0.0304157);  // third row of the file
  CHECK_SAYS(material(simulation, "maple").source, "pycoal");
  CHECK(!material(simulation, "beech").transmittance.value.empty());
  CHECK(material(simulation, "asphalt").reflectance.wavelength_um.size() == 177);
  CHECK(material(simulation, "asphalt").reflectance.wavelength_um.front() == 0.46);
  base::Problems problems;
  const auto library = read_envi_library(data + "envi/library_berlin.sli", {}, problems);
  REQUIRE(library);
  CHECK(library->names.size() == 75);
  const auto vegetation = read_envi_library(data + "envi/rstoolbox_vegSpec.sli", {}, problems);
  REQUIRE(vegetation);
  CHECK(vegetation->wavelength_um.size() == 2151);
  CHECK(vegetation->wavelength_um.front() == doctest::Approx(0.35).epsilon(1e-15));
  // That library holds NaN from sample 2080 on: refused, each sample named.
  CHECK_SAYS(refusal(folder, std::string(kHead) + "[[material]]\nname = \"v\"\nfile = \"" + data +
                                 "envi/rstoolbox_vegSpec.sli\"\nspectrum = \"veg_vital\"\n"),
             "spectrum 'veg_vital', sample 2080: reflectance is not a finite number (found nan)");
  const std::string bad = refusal(folder, std::string(kHead) + "[[material]]\nname = \"m\"\nfile = \"" + data +
                                              "spectra/bad_above_one_muufl_field_cloth_red.csv\"\n");
  CHECK_SAYS(bad, "reflectance outside 0 .. 1");
}

TEST_CASE("a spectrum that ends goes on with reflectance_beyond, opaque; a constant one takes no such key") {
  const Folder folder;
  folder.write("leaf.csv", "wavelength_nm,reflectance,transmittance\n500,0.2,0.1\n2500,0.3,0.2\n");
  const auto simulation = load(folder, std::string(kHead) +
                                           "[[material]]\nname = \"leaf\"\nfile = \"leaf.csv\"\n"
                                           "reflectance_beyond = 0.04\n");
  const Material& leaf = material(simulation, "leaf");
  REQUIRE(leaf.reflectance.wavelength_um.size() == 4);
  CHECK(leaf.reflectance.wavelength_um[2] == doctest::Approx(2.5).epsilon(2e-6));
  CHECK(leaf.reflectance.wavelength_um[2] > 2.5);
  CHECK(leaf.reflectance.wavelength_um[3] == 100);
  CHECK(leaf.reflectance.value == std::vector<double>{0.2, 0.3, 0.04, 0.04});
  CHECK(leaf.transmittance.value == std::vector<double>{0.1, 0.2, 0, 0});
  CHECK_SAYS(refusal(folder, std::string(kHead) + kGrey + "reflectance_beyond = 0.1\n"),
             "'reflectance_beyond' means nothing for a constant reflectance");
}

TEST_CASE("real input: band lists and responses of real sensors") {
  const auto shared = shared_folder("sensor bands");
  if (!shared) return;
  const Folder folder;
  const auto bands = [&](const std::string& file) {
    return load(folder, instrument("bands = \"" + *shared + "/data/sensors/" + file + "\"\n")).instruments.at(0).bands;
  };
  CHECK(bands("aviris_ng_425_bands.csv").size() == 425);
  CHECK(bands("emit_bands.csv").size() > 200);
  const auto sentinel = bands("sentinel2a_msi_srf.csv");
  CHECK(sentinel.size() == 13);
  // AVIRIS 1995: overlapping spectrometers, not monotonic in the file.
  const auto aviris = bands("aviris_1995_224_bands.csv");
  CHECK(aviris.size() == 224);
  CHECK(std::is_sorted(aviris.begin(), aviris.end(),
                       [](const Band& a, const Band& b) { return a.center_um < b.center_um; }));
  CHECK_SAYS(refusal(folder, instrument("bands = \"" + *shared + "/data/sensors/emit_328_rows_bands.csv\"\n")),
             "band width must be above 0 (found 0");
}
