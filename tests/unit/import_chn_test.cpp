// .chn: two channels written here in the format's columns, whole and with faults. Oracle: the format's rules,
// arithmetic by hand.
#include "tests/unit/import_kit.h"

#include <cstdio>

#include "atmos_tables/import/modtran_chn.h"

using namespace raycube;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

constexpr int kWidths[26] = {12, 3,  3,  13, 13, 8,  13, 9,  9,  9,  9,  13, 13,
                             13, 13, 13, 13, 13, 13, 13, 13, 10, 10, 10, 10, 10};

/// Right-aligned numbers in columns of dashes, two blanks between.
std::string row_of(const std::vector<std::string>& numbers, const std::string& description) {
  std::string out;
  for (int i = 0; i < 26; ++i) {
    std::string cell = numbers[static_cast<std::size_t>(i)];
    out += std::string(i ? 2 : 0, ' ') + std::string(static_cast<std::size_t>(kWidths[i]) - cell.size(), ' ') + cell;
  }
  return out + "  " + description + "\n";
}

std::string header() {
  std::string dashes;
  for (int i = 0; i < 26; ++i)
    dashes += std::string(i ? 2 : 0, ' ') + std::string(static_cast<std::size_t>(kWidths[i]), '-');
  return "\n1ST SPECTRAL  LOS CHAN\n   MOMENT     NO.  NEL\n(NANOMETERS)       NO.\n" + dashes + "  -----------\n";
}

/// Radiance 1.2e-6 W sr-1 cm-2 over 10 nm: 1.2e-7 W cm-2 sr-1 nm-1, 1.2 W m-2 sr-1 um-1.
std::vector<std::string> numbers(int channel, const std::string& moment) {
  return {moment,
          "1",
          std::to_string(channel),
          "1.000000E-09",
          "1.200000E-07",
          "290.000",
          "1.200000E-06",
          "100.0000",
          "10.0000",
          "540.0000",
          "560.0000",
          "1.000000E-07",
          "2.000000E-08",
          "3.000000E-08",
          "2.500000E-07",
          "3.000000E-07",
          "5.000000E-07",
          "4.000000E-07",
          "6.000000E-05",
          "1.000000E-04",
          "1.500000E-04",
          "0.5000000",
          "0.0400000",
          "0.2000000",
          "0.8000000",
          "0.9000002"};
}

std::string text(const std::vector<std::string>& second = numbers(2, "560.00000")) {
  return header() + row_of(numbers(1, "550.00000"), "CENTER:   550.00 NM   FWHM:  9.50 NM") +
         row_of(second, "CENTER:   560.00 NM   FWHM:  9.60 NM");
}

std::string refused(const std::string& content) {
  const TestFolder folder;
  folder.write("a.chn", content);
  return refusal([&] { read_chn(folder / "a.chn"); });
}

std::string refused_with(std::size_t column, const std::string& cell) {
  auto second = numbers(2, "560.00000");
  second[column] = cell;
  return refused(text(second));
}

}  // namespace

TEST_CASE("S20 chn: channel integrals become means over the channel") {
  const TestFolder folder;
  folder.write("a.chn", text());
  const Imported imported = read_chn(folder / "a.chn");
  REQUIRE(imported.runs.size() == 1);
  const Run& run = imported.runs[0];
  CHECK(run.wavelength_um[0] == doctest::Approx(0.55).epsilon(1e-15));
  CHECK(run.at("radiance").values[0] == doctest::Approx(1.2).epsilon(1e-12));
  CHECK(run.at("channel_radiance").values[0] == doctest::Approx(1.2).epsilon(1e-12));
  // Thermal scatter stands beside emission: 0.1 + 0.02; solar path: 0.25 + 0.3.
  CHECK(run.at("path_radiance_thermal").values[0] == doctest::Approx(0.12).epsilon(1e-12));
  CHECK(run.at("path_radiance_solar").values[0] == doctest::Approx(0.55).epsilon(1e-12));
  CHECK(run.at("spherical_albedo").values[1] == 0.2);
  CHECK(run.at("coefficient_a").values[0] == 0.5);
  CHECK(run.at("channel_center").values[1] == doctest::Approx(0.56));
  CHECK(run.at("channel_fwhm").values[1] == doctest::Approx(0.0096));
  CHECK(run.at("channel_width").values[0] == doctest::Approx(0.01));
  // 100 / (60 pi / cos 60): 0.26526.
  CHECK(sun_ground_sensor_transmittance(run, 60)[0] ==
        doctest::Approx(1e-4 / (6e-5 * std::acos(-1.0) / 0.5)).epsilon(1e-12));
  CHECK(holds(refusal([&] { sun_ground_sensor_transmittance(run, 95); }), "above the horizon"));
}

TEST_CASE("S20 chn: faults are refused with file and line") {
  REQUIRE(refused(text()).empty());
  // The second channel stands in line 7.
  CHECK(holds(refused_with(11, "*************"), "a.chn:7: THERMAL EMISSION did not fit its field"));
  CHECK(holds(refused_with(11, "NaN"), "a.chn:7: THERMAL EMISSION is not finite"));
  CHECK(holds(refused_with(14, "-2.50000E-07"), "a.chn:7: PATH MULTIPLE SCAT SOLAR is negative"));
  CHECK(holds(refused_with(14, ""), "a.chn:7: PATH MULTIPLE SCAT SOLAR is blank"));
  CHECK(holds(refused_with(14, "2.5x0000E-07"), "is no number"));
  CHECK(holds(refused_with(14, "2.600000E-07"), "a.chn:7: the parts of CHANNEL RADIANCE do not add up"));
  CHECK(holds(refused_with(2, "3"), "a.chn:7: channels do not follow each other"));
  CHECK(holds(refused_with(8, "0.0000"), "a.chn:7: moment and equivalent width must be above 0"));
  CHECK(holds(refused_with(24, "1.8000000"), "a value is above 1"));
  CHECK(holds(refused_with(14, "2.500000E-07 "), "does not end where its column ends"));
  const std::string whole = text();
  CHECK(holds(refused(whole.substr(0, whole.size() - 6)), "a.chn:7: the description is cut short"));
  CHECK(holds(refused(whole.substr(0, whole.size() - 120)), "a.chn:7:"));
  CHECK(holds(refused(header()), "no channels"));
  CHECK(holds(refused("nothing\nof the kind\n"), "no header of channel output"));
}
