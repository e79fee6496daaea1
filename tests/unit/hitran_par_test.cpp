// The reader of line lists on files the test writes: fixed columns as the format means them, faults with their line
// numbers.
#include <doctest/doctest.h>

#include <cstdio>
#include <string>

#include "atmos_tables/lines/hitran_par.h"
#include "atmos_tables/lines/molecules.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {

/// A record of HITRAN 2004 with invented figures.
std::string record(int molecule, char isotopologue, double wavenumber, double intensity = 1.234e-21,
                   double energy = 104.7729) {
  char head[200];
  std::snprintf(head, sizeof head, "%2d%c%12.6f%10.3E%10.3E%5.4f%5.3f%10.4f%4.2f%8.6f", molecule, isotopologue,
                wavenumber, intensity, 1.5, 0.0567, 0.079, energy, 0.75, -0.0061);
  std::string line = head;
  // "0.0567" takes 6 columns; HITRAN prints ".0567".
  line.erase(line.find("0.0567"), 1);
  line.resize(153, ' ');
  return line + "    5.0";
}

std::string message(const std::string& file, base::Fault fault = base::Fault::input) {
  return testing::refusal([&] { read_hitran_par(file, 0, 1e5); }, fault);
}

bool says(const std::string& text, const std::string& part) {
  const bool found = text.find(part) != std::string::npos;
  if (!found) MESSAGE("'" << part << "' is not in: " << text);
  return found;
}

}  // namespace

TEST_CASE("AIR 9 line list: every column where the format has it, range kept, extents of the whole file") {
  const testing::TestFolder folder;
  REQUIRE(record(6, '1', 3057.687).size() == 160);
  folder.write("a.par", record(1, '4', 3000.25) + "\n" + record(6, '1', 3057.687423, 2.106e-19) + "\n" +
                            record(2, '0', 3058.5) + "\n" + record(2, 'A', 3059.5) + "\n" + record(6, '2', 4000.0) +
                            "\n");
  const LineList list = read_hitran_par(folder / "a.par", 3050, 3060);
  CHECK(list.records == 5);
  REQUIRE(list.lines.size() == 3);
  const SpectralLine& line = list.lines[0];
  CHECK(line.molecule == 6);
  CHECK(line.isotopologue == 1);
  CHECK(line.wavenumber_per_cm == 3057.687423);
  CHECK(line.intensity == 2.106e-19);
  CHECK(line.gamma_air == 0.0567);
  CHECK(line.gamma_self == 0.079);
  CHECK(line.lower_energy_per_cm == 104.7729);
  CHECK(line.n_air == 0.75);
  CHECK(line.delta_air == -0.0061);
  CHECK(list.lines[1].isotopologue == 10);
  CHECK(list.lines[2].isotopologue == 11);
  CHECK(list.molecules.at(6).records == 2);
  CHECK(list.molecules.at(6).last_per_cm == 4000.0);
  CHECK(list.molecules.count(3) == 0);
}

TEST_CASE(
    "AIR 9 line list: CR LF, any order, no end of line at the end, empty lines, exponents without E, blank self "
    "width") {
  const testing::TestFolder folder;
  std::string odd = record(6, '1', 3001.0);
  odd.replace(15, 10, " 1.234-105");
  std::string blank = record(6, '1', 2999.0, 1e-20, -1.0);
  blank.replace(40, 5, "     ");
  folder.write("b.par", record(6, '1', 3002.0) + "\r\n" + odd + "\r\n\r\n" + blank);
  const LineList list = read_hitran_par(folder / "b.par", 0, 1e5);
  REQUIRE(list.lines.size() == 3);
  CHECK(list.lines[0].wavenumber_per_cm == 2999.0);
  CHECK(list.lines[0].gamma_self == list.lines[0].gamma_air);
  CHECK(list.unknown_energy == 1);
  CHECK(list.lines[1].intensity == 1.234e-105);
  CHECK(list.lines[2].wavenumber_per_cm == 3002.0);
}

TEST_CASE("AIR 9 line list: faults are told with file and line, all at once") {
  const testing::TestFolder folder;
  std::string short_one = record(6, '1', 3000.0);
  short_one.resize(100);
  std::string blank = record(6, '1', 3000.0), stars = blank, pointless = blank, minus = blank, unknown = blank,
              letter = blank;
  blank.replace(45, 10, "          ");
  stars.replace(15, 10, "**********");
  pointless.replace(45, 10, "   1047729");
  minus.replace(15, 10, "-1.234E-21");
  unknown.replace(0, 2, "77");
  letter.replace(2, 1, "?");
  folder.write("c.par", record(6, '1', 3000.0) + "\n" + short_one + "\n" + blank + "\n" + stars + "\n" + pointless +
                            "\n" + minus + "\n" + unknown + "\n" + letter + "\n" +
                            record(6, '1', 3000.0).substr(0, 70));
  const std::string text = message(folder / "c.par");
  CHECK(says(text, "c.par:2: a record has 160 characters"));
  CHECK(says(text, "before 2004"));
  CHECK(says(text, "c.par:3: lower energy, columns 46-55, must be a number"));
  CHECK(says(text, "c.par:4: intensity, columns 16-25, must be a number"));
  CHECK(says(text, "c.par:5: lower energy, columns 46-55, must have a decimal point"));
  CHECK(says(text, "c.par:6: intensity must be above 0"));
  CHECK(says(text, "c.par:7: unknown molecule number"));
  CHECK(says(text, "c.par:8: unknown isotopologue"));
  CHECK(says(text, "c.par:9: a record has 160 characters"));
  CHECK(says(text, "70"));
  folder.write("empty.par", "");
  CHECK(says(message(folder / "empty.par"), "holds no lines"));
  CHECK(says(message(folder / "absent.par", base::Fault::environment), "cannot be read"));
  folder.write("long.par", std::string(9 << 20, 'x'));  // no line end in 9 MB
  CHECK(says(message(folder / "long.par"), "a record has 160 characters"));
  std::string many;
  for (int i = 0; i < 1000; ++i) many += "nonsense\n";
  folder.write("many.par", many);
  const std::string all = message(folder / "many.par");
  CHECK(says(all, "many.par:20:"));
  CHECK(all.find("many.par:21:") == std::string::npos);
}

TEST_CASE("AIR 9 line list: records across the joints of reading are whole; of a long file the range alone is kept") {
  const testing::TestFolder folder;
  std::string text;
  const int count = 120000;  // 19 MB: five pieces
  text.reserve(static_cast<std::size_t>(count) * 161);
  std::string line = record(6, '1', 1000.0) + "\n";
  for (int i = 0; i < count; ++i) {
    char wavenumber[16];
    std::snprintf(wavenumber, sizeof wavenumber, "%12.6f", 1000 + 0.01 * i);
    line.replace(3, 12, wavenumber);
    text += line;
  }
  folder.write("d.par", text);
  const LineList list = read_hitran_par(folder / "d.par", 1500 - 1e-6, 1500.1 + 1e-6);
  CHECK(list.records == 120000);
  CHECK(list.lines.size() == 11);
  CHECK(list.molecules.at(6).records == 120000);
  CHECK(list.molecules.at(6).last_per_cm == doctest::Approx(1000 + 0.01 * (count - 1)).epsilon(1e-12));
}

TEST_CASE("AIR 9 molecules: names, masses of isotopologues, partition sums of a user's file and its faults") {
  CHECK(molecule_name(6) == "ch4");
  CHECK(molecule_number("c2h6") == 27);
  CHECK(molecule_number("xyz") == 0);
  for (int m = 1; m <= molecule_count(); ++m) CHECK(molecule_number(molecule_name(m)) == m);
  // The masses of the list are the sums of their atoms (the commonest isotopes stand first).
  CHECK(isotopologue_mass_g(1, 1) == doctest::Approx(2 * 1.00782503 + 15.99491462).epsilon(1e-7));
  CHECK(isotopologue_mass_g(27, 1) == doctest::Approx(24 + 6 * 1.00782503).epsilon(1e-9));
  CHECK(isotopologue_mass_g(24, 1) == doctest::Approx(12 + 3 * 1.00782503 + 34.96885268).epsilon(1e-9));  // ch3cl
  CHECK(isotopologue_mass_g(52, 1) == doctest::Approx(73.92117776 + 4 * 1.00782503).epsilon(1e-9));       // geh4
  CHECK(isotopologue_mass_g(36, 1) == doctest::Approx(14.003074 + 15.99491462).epsilon(1e-9));            // no+

  const testing::TestFolder folder;
  folder.write("q.csv", "# TIPS\nmolecule,isotopologue,temperature_K,q\nch4,1,200,100\nch4,1,296,200\n6,1,300,250\n");
  const PartitionSums sums = PartitionSums::read_csv(folder / "q.csv");
  CHECK(sums.ratio(6, 1, 200) == doctest::Approx(2.0).epsilon(1e-12));
  CHECK(sums.ratio(6, 1, 296) == doctest::Approx(1.0).epsilon(1e-12));
  CHECK(sums.ratio(6, 2, 200) == PartitionSums().ratio(6, 2, 200));
  CHECK_THROWS_WITH_AS(sums.ratio(6, 1, 150), doctest::Contains("ends before 150"), base::Error);
  folder.write(
      "bad.csv",
      "molecule,isotopologue,temperature_K,q\nxyz,1,200,1\nch4,1,200\nch4,1,300,5\nch4,1,296,4\nch4,1,310,0\n");
  try {
    PartitionSums::read_csv(folder / "bad.csv");
    CHECK(false);
  } catch (const base::Error& error) {
    CHECK(says(error.what(), "bad.csv:2: unknown molecule"));
    CHECK(says(error.what(), "bad.csv:3: needs 4 cells"));
    CHECK(says(error.what(), "bad.csv:5: temperatures of one isotopologue must ascend"));
    CHECK(says(error.what(), "bad.csv:6: temperature and q must be above 0"));
  }
}
