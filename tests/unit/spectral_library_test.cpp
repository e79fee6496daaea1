// What headers of spectral libraries and cubes declare, each applied or refused by its cause; detectors that overlap.
// Oracle: the same grey told in other ways, and a saw-tooth whose two sides are known.
#include <cmath>

#include "host/products/envi_header.h"
#include "scene_compiler/spectrum_file.h"
#include "tests/unit/scene_files.h"

using namespace raycube;
using namespace raycube::scene;
using namespace raycube::scene::testing;

namespace {

template <class T>
std::string bytes(const std::vector<double>& values) {
  std::string out;
  for (const double value : values) {
    const T number = static_cast<T>(value);
    out.append(reinterpret_cast<const char*>(&number), sizeof number);
  }
  return out;
}

std::string list(const std::vector<double>& values) {
  std::string out;
  for (const double value : values) out += (out.empty() ? "" : ", ") + std::to_string(value);
  return out;
}

const std::vector<double> kGrid_nm = {400, 500, 600, 700};

std::string header(const std::string& more, int type = 4, const std::vector<double>& wavelengths = kGrid_nm,
                   const std::string& units = "wavelength units = Nanometers\n", const std::string& names = "a") {
  return "ENVI\nsamples = " + std::to_string(wavelengths.size()) +
         "\nlines = 1\nbands = 1\nfile type = ENVI Spectral Library\ndata type = " + std::to_string(type) +
         "\ninterleave = bsq\nbyte order = 0\nspectra names = {" + names + "}\nwavelength = {" + list(wavelengths) +
         "}\n" + units + more;
}

struct Read {
  std::optional<Material> material;
  std::string refused, told;
};

class Library {
 public:
  Read read(const std::string& data, const std::string& text, const std::string& spectrum = "") {
    folder_.write("l.sli", data);
    folder_.write("l.sli.hdr", text);
    return file("l.sli", spectrum);
  }
  Read text(const std::string& name, const std::string& content) {
    folder_.write(name, content);
    return file(name, "");
  }

 private:
  Read file(const std::string& name, const std::string& spectrum) {
    base::Problems problems;
    Read out{read_spectrum({.file = folder_.at(name), .spectrum = spectrum}, problems), "", ""};
    for (const std::string& line : problems.lines()) out.refused += line + "\n";
    for (const std::string& line : problems.notices()) out.told += line + "\n";
    return out;
  }
  Folder folder_;
};

}  // namespace

TEST_CASE("spectral libraries: the same grey by every declaration of its header") {
  Library library;
  const auto grey = [&](double stored, const std::string& text, int type = 4) {
    const std::vector<double> values(4, stored);
    const Read read = library.read(type == 4 ? bytes<float>(values) : bytes<std::int16_t>(values), text);
    REQUIRE_MESSAGE(read.material, text << read.refused);
    for (std::size_t i = 0; i < 4; ++i) {
      CHECK(read.material->reflectance.value[i] == doctest::Approx(0.2).epsilon(1e-6));
      CHECK(read.material->reflectance.wavelength_um[i] == doctest::Approx(1e-3 * kGrid_nm[i]).epsilon(1e-6));
    }
    return read.told;
  };
  CHECK(grey(0.2, header("")) == "");
  grey(2000, header("reflectance scale factor = 10000\n", 2), 2);
  grey(20, header("data units = percent\n"));
  grey(20, header("z plot titles = {Wavelength (nm), Reflectance (%)}\n"));
  CHECK_SAYS(grey(200, header("data gain values = {0.001}\n", 2), 2), "by its 'data gain values'");
  grey(200, header("data gain values = {0.001, 0.001, 0.001, 0.001}\n", 2), 2);
  grey(-0.3, header("data offset values = {0.5}\n"));
  grey(-30, header("data offset values = {50}\nreflectance scale factor = 100\n"));
  grey(0.2, header("", 4, {0.4, 0.5, 0.6, 0.7}, "wavelength units = Micrometers\n"));
  grey(0.2, header("", 4, {4000, 5000, 6000, 7000}, "wavelength units = Angstroms\n"));
  grey(0.2, header("", 4, {25000, 20000, 1e7 / 600, 1e7 / 700}, "wavelength units = Wavenumber\n"));
  // Longest wavelength first: turned round.
  const Read back = library.read(bytes<float>({0.4, 0.3, 0.2, 0.1}), header("", 4, {1e7 / 700, 1e7 / 600, 20000, 25000},
                                                                            "wavelength units = Wavenumber\n"));
  REQUIRE(back.material);
  CHECK(back.material->reflectance.value[0] == doctest::Approx(0.1).epsilon(1e-6));
  // Bad bands and the ignore value, whatever stands there.
  for (const char* out_of_use : {"bbl = {1, 0, 1, 1}\n", "data ignore value = 0.75\n"}) {
    const Read read = library.read(bytes<float>({0.2, 0.75, 0.2, 0.2}), header(out_of_use));
    REQUIRE(read.material);
    CHECK(read.material->reflectance.value.size() == 3);
    CHECK_SAYS(read.told, "1 samples without data left out");
  }
  const Read short_list = library.read(bytes<float>({0.2, 0.2, 0.2, 0.2}), header("bbl = {1, 0, 1}\n"));
  CHECK_SAYS(short_list.told, "\"bbl\" has 3 values, not 4; it is ignored");
}

TEST_CASE("spectral libraries: what cannot be applied is refused by name") {
  Library library;
  const auto refused = [&](const std::string& text, const std::string& spectrum = "") {
    const Read read = library.read(bytes<float>({0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2}), text, spectrum);
    CHECK_MESSAGE(!read.material, text);
    return read.refused;
  };
  CHECK_SAYS(refused(header("", 4, kGrid_nm, "")), "lacks 'wavelength units'");
  CHECK_SAYS(refused(header("", 4, kGrid_nm, "wavelength units = Index\n")), "unknown wavelength unit (found Index)");
  CHECK_SAYS(refused(header("data units = uW/cm^2/sr/nm\n")), "not of reflectance (found uW/cm^2/sr/nm)");
  CHECK_SAYS(refused(header("file compression = 1\n")), "\"file compression\" is not read");
  CHECK_SAYS(refused(header("major frame offsets = {16, 0}\n")), "\"major frame offsets\" is not read");
  CHECK_SAYS(refused(header("reflectance scale factor = 0\n")), "is not a positive number (found 0)");
  std::string two = header("", 4, kGrid_nm, "wavelength units = nm\n", "a, a");
  two.replace(two.find("lines = 1"), 9, "lines = 2");
  CHECK_SAYS(refused(two, "a"), "two spectra of the library have one name (found 'a' is line 1 and 2");
  CHECK_SAYS(refused(header("", 4, kGrid_nm, "wavelength units = nm\n", "a, b")), "has no name for each spectrum");
}

TEST_CASE("detectors that overlap are joined in the middle of what both see, and told") {
  // Three detectors as a field spectrometer has them; the second is 0.03 brighter, the third 0.05.
  std::vector<double> nm, value;
  const auto detector = [&](double first, double step, double last, double reflectance) {
    for (double at = first; at <= last; at += step) nm.push_back(at), value.push_back(reflectance);
  };
  detector(350, 5, 1010, 0.20), detector(970, 8, 1910, 0.23), detector(1890, 10, 2510, 0.25);
  const auto rows = [&](const std::string& separator, double factor, bool backwards, const std::string& between) {
    std::string out;
    for (std::size_t i = 0; i < nm.size(); ++i) {
      const std::size_t at = backwards ? nm.size() - 1 - i : i;
      out += std::to_string(nm[at]) + separator + between + std::to_string(factor * value[at]) + "\n";
    }
    return out;
  };
  Library library;
  for (const Read& read :
       {library.read(bytes<float>(value), header("", 4, nm)),
        library.text("x.sig", "/*** Spectra Vista SIG Data ***/\nname= x\ndata=\n" + rows(" ", 100, false, "100 20 ")),
        library.text("x.txt", "Wavelength\tleaf.asd\n" + rows("\t", 1, false, "")),
        library.text("x.csv", "wavelength_nm,reflectance\n" + rows(",", 1, false, "")),
        library.text("y.txt", "Name: x\nX Units: Wavelength (nanometers)\nY Units: Reflectance (percent)\n\n" +
                                  rows("\t", 100, true, ""))}) {
    REQUIRE_MESSAGE(read.material, read.refused);
    CHECK_SAYS(read.told, "overlap from 970 to 1010 nm; they are joined at 990 nm, where they differ by 0.03");
    CHECK_SAYS(read.told, "overlap from 1890 to 1906 nm; they are joined at 1898 nm, where they differ by 0.02");
    const auto& curve = read.material->reflectance;
    std::size_t steps = 0;
    for (std::size_t i = 1; i < curve.value.size(); ++i) {
      CHECK(curve.wavelength_um[i] > curve.wavelength_um[i - 1]);
      steps += std::abs(curve.value[i] - curve.value[i - 1]) > 0.01;
    }
    CHECK(steps == 2);
  }
  // Of two rows out of place nobody knows what they are.
  CHECK_SAYS(library.text("x.csv", "wavelength_nm,reflectance\n400,0.1\n600,0.1\n500,0.1\n700,0.1\n").refused,
             "wavelengths are not ascending");
  CHECK_SAYS(library.text("x.txt", "Wavelength\tleaf.asd\n400\t0.1\n600\t0.1\n500\t0.1\n700\t0.1\n").told,
             "wavelengths go up and down; sorted");
  // Rows are counted, those that are none are refused, and decimal commas are told once.
  const std::string eco = "Name: x\nX Units: Wavelength (nanometers)\nY Units: Reflectance (percent)\n";
  CHECK_SAYS(library.text("y.txt", eco + "Number of X Values: 4\n\n400 10\n500 10\n600 10\n").refused,
             "Number of X Values: the file holds another number of rows (found 3 for 4)");
  CHECK_SAYS(library.text("y.txt", eco + "\n400 10\n500 wet\n600 10\n").refused, "y.txt:6: not a row of numbers");
  CHECK_SAYS(library.text("x.txt", "Wavelength\tleaf.asd\n350\t0,25\n351\t0,35\n").told,
             "2 rows with decimal commas read as such");
  // Of a text its column's unit.
  for (const char* unit : {"Wavelength (um)", "Wavelength [\u00b5m]", "Wavelength (microns)"})
    CHECK(library.text("u.txt", std::string(unit) + "\tleaf\n0.4\t0.2\n0.5\t0.2\n")
              .material.value()
              .reflectance.wavelength_um.front() == 0.4);
}

TEST_CASE("cubes: widths in wavenumbers and frequencies; a unit that is none is told") {
  const std::string minimal = "ENVI\nsamples = 1\nlines = 1\nbands = 2\ndata type = 4\ninterleave = bil\n";
  const auto of = [&](const std::string& more) { return products::parse_envi_header(minimal + more, "x.hdr"); };
  // 1000 cm-1 is 10 um; from 990 to 1010 cm-1 are 1e4/990 - 1e4/1010 um.
  const auto wide = of("wavelength = {1000, 2000}\nfwhm = {20, 20}\nwavelength units = Wavenumber\n").fwhm_um();
  REQUIRE(wide.size() == 2);
  CHECK(wide[0] == doctest::Approx(1e4 / 990 - 1e4 / 1010).epsilon(1e-12));
  CHECK(of("wavelength = {0.4, 0.5}\nwavelength units = Micrometres\n").wavelength_um()[0] == 0.4);
  const auto none = of("wavelength = {400, 500}\n");
  CHECK(none.wavelength_um().empty());
  REQUIRE(none.warnings.size() == 1);
  CHECK_SAYS(none.warnings[0], "x.hdr: has no 'wavelength units'; they are not used");
  CHECK_SAYS(of("wavelength = {1, 2}\nwavelength units = Index\n").warnings.at(0), "in no unit of them ('Index')");
}
