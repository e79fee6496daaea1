// Spectra and bands: units, medium, files of other programs.
#include <bit>
#include <cmath>

#include "scene_compiler/air_wavelength.h"
#include "scene_compiler/band_list.h"
#include "scene_compiler/envi_library.h"
#include "scene_compiler/spectrometer_file.h"
#include "scene_compiler/spectrum_file.h"
#include "tests/unit/scene_files.h"

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
             "l.sli: is too short: 3 samples x 2 lines x 1 bands of float32 and a header offset of 0 need 24 bytes "
             "(found 20)");
  // Read with the wrong byte order, 0.1f becomes -4.3e8: refused by its value, with its place.
  CHECK_SAYS(library(library_header(4, 1), good), "l.sli: spectrum 'grass', sample 1: reflectance outside 0 .. 1");
  std::string huge = library_header(4, 0);
  huge.replace(huge.find("samples = 3"), 11, "samples = 99999999999");
  CHECK_SAYS(library(huge, good), "l.sli.hdr:2: \"samples\" must be a whole number from 1 to 2147483648");
  std::string unit = library_header(4, 0);
  unit.replace(unit.find("Nanometers"), 10, "Index");
  CHECK_SAYS(library(unit, good), "l.sli.hdr: unknown wavelength unit (found Index); write Micrometers or Nanometers");
  CHECK_SAYS(library(library_header(6, 0), good + good), "l.sli.hdr: ENVI data type is not a real number's (found 6)");
  CHECK_SAYS(library(library_header(4, 0), good, "gras"),
             "scene.toml:5:1: spectral library has no spectrum of that name (found 'gras'); it holds: grass, "
             "dry soil");
  CHECK_SAYS(library("ENVI\nsamples = 3\n", good), "the key \"lines\" is missing");
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
  // That library holds NaN from sample 2080 on: left out, and said.
  const auto vital = load(folder, std::string(kHead) + "[[material]]\nname = \"v\"\nfile = \"" + data +
                                      "envi/rstoolbox_vegSpec.sli\"\nspectrum = \"veg_vital\"\n");
  CHECK(material(vital, "v").reflectance.value.size() == 2079);
  CHECK_SAYS(material(vital, "v").source, ", 72 samples without data left out");
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

namespace {

/// A file's spectrum as one material.
Material as_it_comes(const Folder& folder, const std::string& file, const std::string& more = "") {
  const std::string text = std::string(kHead) + "[[material]]\nname = \"m\"\nfile = \"" + file + "\"\n" + more;
  CHECK(refusal(folder, text) == "");
  return material(load(folder, text), "m");
}

/// ASD's binary layout by its document: bytes where that says, all others 0.
std::string asd_file(char type, const std::vector<float>& target, const std::vector<float>& reference) {
  std::string out(484, '\0');
  const auto put = [&](std::size_t at, const std::string& raw) { out.replace(at, raw.size(), raw); };
  put(0, "as7");
  out[186] = type;
  put(191, bytes<float>({350.0f, 10.0f}, false));
  put(204, bytes<std::uint16_t>({static_cast<std::uint16_t>(target.size())}, false));
  out += bytes(target, false) +
         bytes<std::uint16_t>({static_cast<std::uint16_t>(reference.empty() ? 0 : 0xffff)}, false) +
         std::string(16, '\0') + bytes<std::uint16_t>({3}, false) + "abc";
  return out + bytes(reference, false);
}

}  // namespace

TEST_CASE("S42: spectra as they come: libraries and spectrometers by what stands in their files") {
  const Folder folder;
  // Percent, longest wavelength first, one of them twice, carriage returns.
  folder.write("eco.txt",
               "Name: Lawn\r\nType: vegetation\r\nX Units: Wavelength (micrometers)\r\nY Units: Reflectance "
               "(percent)\r\nNumber of X Values: 4\r\nAdditional Information: none\r\n\r\n 2.5\t 10.0\r\n 1.0\t "
               "40.0\t\r\n 1.0\t 50.0\r\n 0.4\t -0.1\r\n");
  auto m = as_it_comes(folder, "eco.txt");
  CHECK(m.reflectance.wavelength_um == std::vector<double>{0.4, 1.0, 2.5});
  CHECK(m.reflectance.value[0] == 0);
  CHECK(m.reflectance.value[1] == doctest::Approx(0.45).epsilon(1e-15));
  CHECK(m.source == "ECOSTRESS, Lawn, 1 value below 0 taken as 0");
  std::string head = "USGS Digital Spectral Library splib06a\n";
  for (int i = 2; i <= 14; ++i) head += "line " + std::to_string(i) + "\n";
  folder.write("u6.asc", head +
                             "Quartz GDS31 W1R1Ba AREF\ncopy of splib05a\n  0.205100  -1.23e34  0.010460\n  "
                             "0.213100  0.3  0.002\n  2.9  0.4  0.01\n");
  m = as_it_comes(folder, "u6.asc");
  CHECK(m.reflectance.wavelength_um == std::vector<double>{0.2131, 2.9});
  CHECK(m.source == "USGS splib06, Quartz GDS31 W1R1Ba AREF, 1 sample without data left out");
  folder.write("u7.txt", " splib07a Record=13: Acmite NMNH133746\n -1.2300000e+034\n 0.25\n 0.35\n");
  folder.write("wavelengths.txt", " splib07a Record=1: Wavelengths ASD 3 ch\n 0.35\n 0.351\n 0.352\n");
  m = as_it_comes(folder, "u7.txt", "wavelengths = \"wavelengths.txt\"\n");
  CHECK(m.reflectance.wavelength_um == std::vector<double>{0.351, 0.352});
  CHECK(m.reflectance.value == std::vector<double>{0.25, 0.35});
  folder.write("raw.asd", asd_file(0, {10, 20, 30}, {100, 100, 60}));
  folder.write("ref.asd", asd_file(1, {0.1f, 0.2f, 0.5f}, {}));
  for (const char* file : {"raw.asd", "ref.asd"}) {
    m = as_it_comes(folder, file);
    CHECK(m.reflectance.wavelength_um[2] == doctest::Approx(0.37).epsilon(1e-15));
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(m.reflectance.value[i] == doctest::Approx(std::vector{0.1, 0.2, 0.5}[i]).epsilon(1e-7));
  }
  folder.write("asd.txt", "Wavelength;leaf00001.asd\n350; 0.25 \n351; 0.35\n");
  CHECK(as_it_comes(folder, "asd.txt").reflectance.value == std::vector<double>{0.25, 0.35});
  folder.write("asd.txt", "Wavelength\tleaf00001.asd\n350\t0,2500\n351\t0,3500\n");  // as half of Europe writes
  CHECK(as_it_comes(folder, "asd.txt").reflectance.value == std::vector<double>{0.25, 0.35});
  // A CSV of ours is one, whatever its comments name.
  folder.write("csv.csv",
               "# source: USGS Digital Spectral Library splib06a\n# medium: air\n"
               "wavelength_nm,reflectance\n400,0.25\n500,0.35\n");
  m = as_it_comes(folder, "csv.csv");
  CHECK(m.reflectance.wavelength_um[0] == vacuum_from_air_um(0.4));
  CHECK(m.reflectance.value == std::vector<double>{0.25, 0.35});
  folder.write("svc.sig",
               "/*** Spectra Vista SIG Data ***/\nname= gr1.sig\ncomm= \ndata=\n338.5  100.0  20.0  20.00\n"
               "340.0  100.0  25.0  25.00\n");
  m = as_it_comes(folder, "svc.sig");
  CHECK(m.reflectance.wavelength_um[0] == doctest::Approx(0.3385).epsilon(1e-15));
  CHECK(m.reflectance.value[1] == doctest::Approx(0.25).epsilon(1e-15));
}

TEST_CASE("S42: spectra as they come are refused by their cause, in one line") {
  const Folder folder;
  const auto refused = [&](const std::string& file, const std::string& content, const std::string& more = "") {
    folder.write(file, content);
    return refusal(folder, std::string(kHead) + "[[material]]\nname = \"m\"\nfile = \"" + file + "\"\n" + more);
  };
  CHECK_SAYS(refused("u7.txt", " splib07a Record=13: Acmite\n 0.2\n 0.3\n"),
             "a spectrum of splib07 stands without its wavelengths");
  folder.write("w.txt", " splib07a Record=1: Wavelengths\n 0.35\n");
  CHECK_SAYS(refused("u7.txt", " splib07a Record=13: Acmite\n 0.2\n 0.3\n", "wavelengths = \"w.txt\"\n"),
             "(found 1 for 2 values); name those of the same spectrometer");
  CHECK_SAYS(refused("e.txt", "Name: x\nX Units: Wavenumber (cm-1)\nY Units: Reflectance (percent)\n1 2\n"),
             "X Units: unknown unit of wavelengths (found wavenumber (cm-1))");
  CHECK_SAYS(refused("e.txt", "Name: x\nX Units: Wavelength (micrometers)\nY Units: Transmittance (percent)\n1 2\n"),
             "Y Units: no reflectance (found transmittance (percent))");
  CHECK_SAYS(refused("a.txt", "Wavelength;a.asd;b.asd\n350;0.1;0.2\n351;0.1;0.2\n"),
             "a.txt:2: an ASD text of several samples (found 3 columns)");
  CHECK_SAYS(refused("a.txt", "Wavelength\ta.asd\nThe file holds radiance\n350\t0.1\n351\t0.1\n"),
             "an ASD text that is not of reflectance (found radiance)");
  CHECK_SAYS(refused("a.txt", "place_nm;transmittance;reflectance\n350;0.4;0.1\n"), "no wavelength column");
  CHECK_SAYS(refused("a.txt", "ASD spectrum file\nWavelength\n350 0.1\n"), "a spectrum needs at least two points");
  CHECK_SAYS(refused("a.asd", asd_file(0, {10, 20}, {})), "an ASD file without its white reference");
  CHECK_SAYS(refused("a.asd", asd_file(1, {0.1f, 0.2f}, {1, 1}).substr(0, 515)), "without its white reference");
  CHECK_SAYS(refused("a.asd", asd_file(2, {10, 20}, {1, 1})), "an ASD file that holds no reflectance (found data of");
  CHECK_SAYS(refused("a.asd", asd_file(1, {1, 1}, {}).substr(0, 300)), "an ASD file ends in its header");
  CHECK_SAYS(refused("s.sig", "/*** Spectra Vista SIG Data ***/\nname= x\n"), "without data (found no line 'data=')");
  CHECK(line_count(refused("e.txt",
                           "X Units: Wavelength (micrometers)\nY Units: Reflectance (percent)\n0.4 20\n0.5 "
                           "300\n0.6 400\n")) == 1);
}

TEST_CASE("S42: a spectrum is held at both ends where that is asked for") {
  const Folder folder;
  folder.write("m.csv", "wavelength_um,reflectance,transmittance\n0.4,0.2,0.1\n2.5,0.3,0.1\n");
  const auto m = as_it_comes(folder, "m.csv", "reflectance_below = 0.05\nreflectance_beyond = 0.04\n");
  CHECK(m.reflectance.value == std::vector<double>{0.05, 0.05, 0.2, 0.3, 0.04, 0.04});
  CHECK(m.transmittance.value == std::vector<double>{0, 0, 0.1, 0.1, 0, 0});
  CHECK(m.reflectance.wavelength_um.front() == 0.1);
  CHECK(m.reflectance.wavelength_um.back() == 100);
}

TEST_CASE("real input: spectra of ASTER, USGS and ASD in their own layouts, which nobody here wrote") {
  const auto shared = shared_folder("spectra as they come");
  if (!shared) return;
  const Folder folder;
  const std::string data = *shared + "/data/";
  const auto conifer = as_it_comes(
      folder, data + "spectra/aster_ascii/jhu.becknic.vegetation.trees.conifers.solid.conifer.spectrum.txt");
  CHECK(conifer.reflectance.wavelength_um.size() == 550);  // as its header says
  CHECK(conifer.reflectance.wavelength_um.front() == 0.302);
  CHECK(conifer.reflectance.value.front() == doctest::Approx(0.03948).epsilon(1e-12));
  const auto aloe = as_it_comes(
      folder, data + "spectra/aster_ascii/vegetation.tree.aloe.bainesii.all.jpl057.jpl.asdnicolet.spectrum.txt");
  CHECK(aloe.reflectance.wavelength_um.size() == 3888);
  const auto butlerite = as_it_comes(folder, data + "spectra/usgs_ascii/butlerite_gds25.3947.asc");
  CHECK(butlerite.reflectance.wavelength_um.front() == 0.2211);
  CHECK(butlerite.reflectance.value.front() == doctest::Approx(0.015736).epsilon(1e-12));
  // The instrument's own program exported the same file as text; its panel sends more than its reference here and
  // there.
  base::Problems problems;
  bool known = false;
  const auto binary = read_spectrometer_file(data + "spectra/asd_binary/ribb00001.asd", "", {}, known, problems),
             text = read_spectrometer_file(data + "spectra/asd_binary/ribb00001.asd.txt", "", {}, known, problems);
  REQUIRE(binary);
  REQUIRE(text);
  REQUIRE(binary->value.size() == 2151);
  REQUIRE(text->value.size() == 2151);
  double worst = 0;
  for (std::size_t i = 0; i < 2151; ++i) worst = std::max(worst, std::abs(binary->value[i] - text->value[i]));
  CHECK(worst < 1e-12);
  CHECK(binary->wavelength_um.back() == doctest::Approx(2.5).epsilon(1e-12));
  CHECK_SAYS(refusal(folder, std::string(kHead) + "[[material]]\nname = \"m\"\nfile = \"" + data +
                                 "spectra/asd_binary/ribb00001.asd\"\n"),
             "reflectance outside 0 .. 1 (found 2.189242449487937, and at 150 more points)");
}
