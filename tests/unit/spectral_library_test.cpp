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
    CHECK_SAYS(read.told, "1 sample without data left out (");
    CHECK(std::count(read.told.begin(), read.told.end(), '\n') == 1);
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
  // Of two rows out of place nobody knows what they are, wherever they lie.
  std::string swapped = "wavelength_nm,reflectance\n", of_text = "Wavelength\tleaf.asd\n";
  for (int i = 0; i < 40; ++i) {
    const int row = i == 22 ? 23 : i == 23 ? 22 : i;
    swapped += std::to_string(400 + 10 * row) + ",0." + std::to_string(100 + row) + "\n";
    of_text += std::to_string(400 + 10 * row) + "\t0." + std::to_string(100 + row) + "\n";
  }
  CHECK_SAYS(library.text("x.csv", swapped).refused, "wavelengths are not ascending (found 0.62 um after 0.63 um)");
  const Read sorted = library.text("x.txt", of_text);
  REQUIRE(sorted.material);
  CHECK_SAYS(sorted.told, "wavelengths go up and down; sorted");
  CHECK(sorted.material->reflectance.value.size() == 40);
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
  for (const auto& [lines, says] : {std::pair{"400\t***\n500\t0.2\n600\t0.2\n", "x.txt:2: not a row of numbers"},
                                    {"400\t0.2\n500\t\n600\t0.2\n700\t0.2\n", "x.txt:3: not a row of numbers"}})
    CHECK_SAYS(library.text("x.txt", std::string("Wavelength\tleaf.asd\n") + lines).refused, says);
  CHECK_SAYS(library.text("y.txt", eco + "\n400\t***\n500 10\n600 10\n").refused, "y.txt:5: not a row of numbers");
  const Read blanks = library.text("x.txt", "Wavelength\tleaf.asd\n400, 0.25\n500 ,0.25\n600 ; 0,25\n700\t0.25\n\x1a");
  REQUIRE_MESSAGE(blanks.material, blanks.refused);
  CHECK(blanks.material->reflectance.value == std::vector<double>(4, 0.25));
  CHECK_SAYS(blanks.told, "1 row with decimal commas read as such");
}

TEST_CASE("an ASD text has the unit that its column's name has as a word") {
  Library library;
  const std::string head = "ASD spectrum file\nnumber 1\n";
  const auto first_um = [&](const std::string& names, const std::string& first, const std::string& second) {
    const Read read = library.text("u.txt", head + names + "\n" + first + "\t0.2\n" + second + "\t0.2\n");
    REQUIRE_MESSAGE(read.material, read.refused);
    return read.material->reflectance.wavelength_um.front();
  };
  for (const char* um : {"Wavelength (um)\tleaf", "Wavelength [\u00b5m]\tleaf", "Wavelength (microns)\tleaf",
                         "Wavelength um;leaf", "Wavelength (um) leaf", "Wavelength (\xb5m)\tleaf", "Wavelength um"})
    CHECK_MESSAGE(first_um(um, "0.4", "0.5") == 0.4, um);
  for (const char* nm : {"Wavelength,spectrum00001.asd", "Wavelength\tmuseum.asd", "Wavelength (nm),column",
                         "Wavelength;aluminium", "Wavelength spectrum00001.asd", "Wavelength"})
    CHECK_MESSAGE(first_um(nm, "400", "500") == doctest::Approx(0.4), nm);
  for (const char* other : {"Wavelength (Angstrom)\tleaf", "Wavelength (cm-1),leaf", "Wavelength mm;leaf"})
    CHECK_SAYS(library.text("u.txt", head + other + "\n400\t0.2\n500\t0.2\n").refused,
               "u.txt:3: unknown unit of wavelengths (found '");
}

TEST_CASE("what is told of spectra of a family is told once") {
  const Folder folder;
  std::string names = "wavelength_nm", low = "400", high = "900";
  for (int i = 0; i < 40; ++i) names += ",leaf" + std::to_string(i) + " (%)", low += ",10", high += ",20";
  folder.write("family.csv", names + "\n" + low + "\n" + high + "\n");
  SpectrumRequest request;
  request.file = folder.at("family.csv"), request.scale = 1e-3;
  base::Problems problems;
  CHECK(read_family(request, problems).size() == 40);
  REQUIRE(problems.notices().size() == 1);
  CHECK_SAYS(problems.notices()[0], "'scale' is taken");
  CHECK_SAYS(problems.notices()[0], "; so for 40 spectra");
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

TEST_CASE("families: a column of another quantity, or of how well one is known, is no spectrum of theirs") {
  Folder folder;
  const auto read = [&](const std::string& column) {
    folder.write("family.csv", "wavelength_nm,grass," + column + "\n400,0.1,0.2\n900,0.4,0.3\n");
    SpectrumRequest request;
    request.file = folder.at("family.csv");
    base::Problems problems;
    const std::size_t count = read_family(request, problems).size();
    return std::pair(count, problems.lines().empty() ? "" : problems.lines().front());
  };
  for (const char* column : {"standard tile", "logs", "counts_of_nothing", "radiances"}) CHECK(read(column).first == 2);
  for (const char* column : {"std", "StdDev", "emissivity", "Radiance (W m-2 sr-1 um-1)", "log(1/R)", "transmittance",
                             "uncertainty [%]", "wavelength_um"}) {
    const auto [count, said] = read(column);
    CHECK(count == 0);
    CHECK_SAYS(said, "family.csv:1: no reflectance (found column '");
  }
}
