// Plain CSV: small files written here, whole and with faults. Oracle: the stated units, by hand.
#include "tests/unit/import_kit.h"

#include "atmos_tables/import/import_file.h"
#include "atmos_tables/import/plain_csv.h"

using namespace raycube;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

const std::string kText =
    "# measured\nwavenumber [cm-1], transmittance [1], path_radiance_solar [W cm-2 sr-1 (cm-1)-1], sky [uW cm-2 sr-1 "
    "nm-1], sun [mW m-2 nm-1]\n"
    "10000, 0.8, 1e-8, 0.5, 900\n# between\n12500, 0.7, 2e-8, 0.6, 1.1E+03\n";

std::string refused(const std::string& text) {
  const TestFolder folder;
  folder.write("a.csv", text);
  return refusal([&] { read_plain_csv(folder / "a.csv"); });
}

}  // namespace

TEST_CASE("S20 plain CSV: units are those the header states") {
  const TestFolder folder;
  folder.write("a.csv", kText);
  const Imported imported = import_file(folder / "a.csv");
  CHECK(imported.format == "plain-csv");
  const Run& run = imported.runs.at(0);
  CHECK(run.wavelength_um[0] == doctest::Approx(0.8).epsilon(1e-15));
  CHECK(run.wavelength_um[1] == doctest::Approx(1.0).epsilon(1e-15));
  CHECK(run.at("transmittance").values == std::vector<double>{0.7, 0.8});
  // 1e-8 x 10000^2 = 1; 2e-8 x 12500^2 = 3.125.
  CHECK(run.at("path_radiance_solar").values[1] == doctest::Approx(1).epsilon(1e-12));
  CHECK(run.at("path_radiance_solar").values[0] == doctest::Approx(3.125).epsilon(1e-12));
  CHECK(run.at("sky").values[1] == doctest::Approx(5).epsilon(1e-12));
  CHECK(run.at("sun").values[0] == doctest::Approx(1100).epsilon(1e-12));
  CHECK(run.at("sun").unit == "W m-2 um-1");
}

TEST_CASE("S20 plain CSV: faults are refused with file and line") {
  const auto with = [](const std::string& from, const std::string& to) { return refused(replaced(kText, from, to)); };
  CHECK(holds(with("0.8", "nan"), "a.csv:3: transmittance is not finite"));
  CHECK(holds(with("0.8", "****"), "a.csv:3: transmittance did not fit its field"));
  CHECK(holds(with("0.8", "-0.8"), "a.csv:3: transmittance is negative"));
  CHECK(holds(with("0.8", ""), "a.csv:3: transmittance is blank"));
  CHECK(holds(with("0.8,", ""), "a.csv:3: the row has another number of fields"));
  CHECK(holds(with("0.8", "1.8"), "a value is above 1"));
  CHECK(holds(with("12500", "10000"), "a.csv:5: the axis does not keep its order"));
  CHECK(holds(with("12500", "0"), "a.csv:5: the axis is not above 0"));
  CHECK(holds(with("wavenumber [cm-1]", "frequency"), "a.csv:2: the first column is no axis"));
  CHECK(holds(with("sky [uW cm-2 sr-1 nm-1]", "sky [nits]"),
              "a.csv:2: a column is not `name [unit]` with a known unit (found sky [nits])"));
  CHECK(holds(refused(kText.substr(0, kText.find("10000,"))), "no data rows"));
}
