// Cross-sections from a user's CSV: linear between what the file states, held beyond, faults by line.
#include <doctest/doctest.h>

#include <cmath>
#include <string>

#include "atmos_tables/lines/tabulated_absorber.h"
#include "host/base/error.h"
#include "tests/support/refusal.h"
#include "tests/unit/test_folder.h"

using namespace raycube;
using namespace raycube::atmos;

namespace {
const std::string kHead = "wavenumber_per_cm,pressure_hPa,temperature_K,cross_section_cm2\n";
}

TEST_CASE("S9 cross-sections: linear in wavenumber and temperature, in ln p between pressures, 0 outside") {
  const testing::TestFolder folder;
  folder.write("a.csv", "# ethane, invented\n" + kHead +
                            "3000,1000,280,1e-20\n3002,1000,280,3e-20\n"
                            "3000,1000,300,2e-20\n3002,1000,300,4e-20\n"
                            "3000,250,290,8e-20\n3002,250,290,8e-20\n");
  const TabulatedAbsorber table = TabulatedAbsorber::read_csv(folder / "a.csv");
  CHECK(table.first_per_cm() == 3000);
  CHECK(table.last_per_cm() == 3002);
  const auto at = [&](double v, double p, double t) { return table.cross_section_cm2({v}, {p, t, 0})[0]; };
  CHECK(at(3001, 1000, 280) == doctest::Approx(2e-20).epsilon(1e-12));
  CHECK(at(3001, 1000, 290) == doctest::Approx(2.5e-20).epsilon(1e-12));
  CHECK(at(3001, 1000, 350) == doctest::Approx(3e-20).epsilon(1e-12));    // held
  CHECK(at(3001, 1050, 200) == doctest::Approx(2e-20).epsilon(1e-12));    // held
  CHECK(at(3001, 500, 290) == doctest::Approx(5.25e-20).epsilon(1e-12));  // half way in ln p
  CHECK(at(3001, 10, 290) == doctest::Approx(8e-20).epsilon(1e-12));
  CHECK(at(3002, 1000, 280) == doctest::Approx(3e-20).epsilon(1e-12));
  CHECK(at(2999.99, 1000, 280) == 0);
  CHECK(at(3002.01, 1000, 280) == 0);
}

TEST_CASE("S9 cross-sections: faults are told by line") {
  const testing::TestFolder folder;
  const auto message = [&](const std::string& text) {
    folder.write("b.csv", text);
    return testing::refusal([&] { TabulatedAbsorber::read_csv(folder / "b.csv"); });
  };
  const auto says = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  CHECK(says(message("nu,sigma\n1,2\n"), "b.csv:1: the columns of cross-sections are"));
  const std::string all =
      message(kHead +
              "3000,1000,280,1e-20\n2999,1000,280,1e-20\n3001,1000\n3001,1000,280,x\n3002,-5,280,1e-20\n"
              "3003,1000,280,12\n3000,900,280,1e-20\n3004,1000,280,1e-20\n");
  CHECK(says(all, "b.csv:3: wavenumbers must ascend strictly"));
  CHECK(says(all, "b.csv:4: needs 4 cells"));
  CHECK(says(all, "b.csv:5:"));
  CHECK(says(all, "b.csv:6:"));
  CHECK(says(all, "b.csv:7: a cross-section of a molecule is below 1e-12 cm2"));
  CHECK(says(all, "b.csv:9: rows of one pressure and temperature must follow each other"));
  CHECK(says(message(kHead), "holds no cross-sections"));
  CHECK(says(message(kHead + "3000,1000,280,1e-20\n"), "at least 2 wavenumbers"));
  CHECK(says(message(kHead + "3000,1000,280,1e-20\n3001,1000,280,1e-20\n3000,1005,280,1e-20\n3001,1005,280,1e-20\n"),
             "nearly one pressure"));
}
