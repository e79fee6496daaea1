// .acd, text and binary: two frequencies of two k-terms written here. Oracle: the format's rules, sums by hand.
#include "tests/unit/import_kit.h"

#include <cstdint>
#include <cstring>

#include "atmos_tables/import/acd.h"

using namespace raycube;
using namespace raycube::atmos::imported;
using namespace raycube::testing;

namespace {

const std::string kText =
    " atmospheric correction data\n FREQ LOS K WEIGHT ...\n (CM-1)\n of two k\n --------\n"
    " 10000.0  1  1  0.750000  0.100000  0.500000  0.050000  0.800000  0.080000\n"
    " 10000.0  1  2  0.250000  0.020000  0.100000  0.010000  0.400000  0.040000\n"
    " 12500.0  1  1  0.750000  0.110000  0.600000  0.060000  0.850000  0.090000\n"
    " 12500.0  1  2  0.250000  0.030000  0.200000  0.020000  0.450000  0.050000\n";

std::string refused(const std::string& text) {
  const TestFolder folder;
  folder.write("a.acd", text);
  return refusal([&] { read_acd_text(folder / "a.acd"); });
}

std::string record(float freq, std::int32_t sight, std::int32_t k, std::initializer_list<float> rest) {
  std::string out;
  const auto add = [&](const void* value) { out.append(static_cast<const char*>(value), 4); };
  const std::int32_t marker = 36;
  add(&marker), add(&freq), add(&sight), add(&k);
  for (const float value : rest) add(&value);
  add(&marker);
  return out;
}

std::string binary() {
  return record(-9999, 0, 1, {0, 0, 0, 0, 0, 0}) + record(10000, 1, 1, {0.75f, 0.1f, 0.5f, 0.05f, 0.8f, 0.08f}) +
         record(10000, 1, 2, {0.25f, 0.02f, 0.1f, 0.01f, 0.4f, 0.04f});
}

std::string refused_binary(const std::string& bytes) {
  const TestFolder folder;
  folder.write("a.acd", bytes);
  return refusal([&] { read_acd_binary(folder / "a.acd"); });
}

}  // namespace

TEST_CASE("S20 acd: functions per k-term, their weighted sums, and why products belong to each k") {
  const TestFolder folder;
  folder.write("a.acd", kText);
  const Run run = read_acd_text(folder / "a.acd").runs.at(0);
  CHECK(run.wavelength_um[0] == doctest::Approx(0.8).epsilon(1e-15));
  CHECK(run.wavelength_um[1] == doctest::Approx(1.0).epsilon(1e-15));
  const Column& sum = run.at("sun_ground_sensor_transmittance_direct");
  CHECK_FALSE(sum.place.k);
  CHECK(sum.values[1] == doctest::Approx(0.75 * 0.5 + 0.25 * 0.1).epsilon(1e-12));
  const auto of_k = [&](const char* name, int k) -> const Column& {
    for (const Column& column : run.columns)
      if (column.name == name && column.place.k == k) return column;
    FAIL("no column");
    throw 0;
  };
  CHECK(of_k("k_weight", 1).values[1] == 0.75);
  CHECK(of_k("spherical_albedo", 2).values[1] == 0.04);
  CHECK(run.at("spherical_albedo").values[1] == doctest::Approx(0.75 * 0.08 + 0.25 * 0.04).epsilon(1e-12));
  folder.write("b.acd", binary());
  const Run same = read_acd_binary(folder / "b.acd").runs.at(0);
  CHECK(same.at("sun_ground_sensor_transmittance_direct").values[0] == doctest::Approx(sum.values[1]).epsilon(1e-7));
  CHECK(same.columns.size() == run.columns.size());
}

TEST_CASE("S20 acd: faults are refused with file and line or record") {
  const auto with = [](const std::string& from, const std::string& to) { return refused(replaced(kText, from, to)); };
  REQUIRE(refused(kText).empty());
  CHECK(holds(with("0.500000", "********"), "a.acd:6: SUN_GND_OBS_DIRECT_TRANSM did not fit its field"));
  CHECK(holds(with("0.500000", "NaN"), "a.acd:6: SUN_GND_OBS_DIRECT_TRANSM is not finite"));
  CHECK(holds(with("0.500000", "-0.500000"), "a.acd:6: SUN_GND_OBS_DIRECT_TRANSM is negative"));
  CHECK(holds(with("0.500000", ""), "a.acd:6: the row has another number of fields"));
  CHECK(holds(with("0.500000", "1.500000"), "a value is above 1"));
  CHECK(holds(with("1  2  0.25", "1  3  0.25"), "a.acd:7: the k-terms of a frequency are not whole"));
  CHECK(holds(with("1  1  0.750000  0.11", "1  1  0.650000  0.11"),
              "a.acd:8: the weights of the k-terms do not sum to 1"));
  CHECK(holds(refused(kText.substr(0, kText.rfind(" 12500.0"))), "the k-terms of a frequency are not whole"));
  CHECK(holds(refused(replaced(replaced(kText, "12500.0", "9000.0"), "12500.0", "9000.0")),
              "a.acd:8: FREQ does not ascend"));
  CHECK(holds(refused(kText.substr(0, kText.find(" 10000"))), "no data rows"));
  const std::string whole = binary();
  REQUIRE(refused_binary(whole).empty());
  CHECK(holds(refused_binary(whole.substr(0, whole.size() - 4)), "records of 44 bytes"));
  std::string marker = whole;
  marker[44] = 'x';
  CHECK(holds(refused_binary(marker), "record 2: the record's markers are not 36"));
  std::string nan = whole;
  const float bad = std::nanf("");
  std::memcpy(nan.data() + 44 + 4 * 6, &bad, 4);
  CHECK(holds(refused_binary(nan), "record 2: SUN_GND_OBS_DIRECT_TRANSM is not finite"));
  CHECK(holds(refused_binary(whole.substr(44)), "does not start with -9999"));
}
