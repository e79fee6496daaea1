// The table's file: round trip, and every way a file can be wrong. Oracle: the format's own rules
// (docs/table_format.md).
#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <sstream>

#include <nlohmann/json.hpp>

#include "atmos_tables/clear_sky.h"
#include "atmos_tables/rct_file.h"
#include "atmos_tables/row_registry.h"
#include "atmos_tables/synthetic.h"
#include "atmos_tables/table_rows.h"
#include "host/base/error.h"
#include "host/base/sha256.h"

using namespace raycube;
using namespace raycube::atmos;
namespace fs = std::filesystem;

namespace {

struct Folder {
  fs::path path = fs::temp_directory_path() / ("raycube-rct-" + std::to_string(reinterpret_cast<std::uintptr_t>(this)));
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  std::string file(const char* name) const { return (path / name).string(); }
};

std::string slurp(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

void spit(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// A file with its lengths and hash made right again, so that the deeper checks are reached.
std::string sealed(const nlohmann::json& header, const std::string& arrays) {
  std::string text = header.dump();
  const std::uint64_t header_bytes = text.size();
  text.resize((text.size() + 63) / 64 * 64, '\0');
  const std::string body = text + arrays;
  std::string head("\x89RCT\r\n\x1a\n", 8);
  const std::uint32_t version = 1, order = 0x01020304;
  const std::uint64_t file_bytes = 64 + body.size();
  head.append(reinterpret_cast<const char*>(&version), 4).append(reinterpret_cast<const char*>(&order), 4);
  head.append(reinterpret_cast<const char*>(&header_bytes), 8).append(reinterpret_cast<const char*>(&file_bytes), 8);
  const auto digest = base::Sha256().add(body).digest();
  head.append(reinterpret_cast<const char*>(digest.data()), 32);
  return head + body;
}

struct Parts {
  nlohmann::json header;
  std::string arrays;
};
Parts take_apart(const std::string& bytes) {
  std::uint64_t header_bytes;
  std::memcpy(&header_bytes, bytes.data() + 16, 8);
  return {nlohmann::json::parse(bytes.substr(64, header_bytes)), bytes.substr(64 + (header_bytes + 63) / 64 * 64)};
}

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const base::Error& error) {
    CHECK(error.fault() == base::Fault::input);
    return error.what();
  }
  return "no error";
}

nlohmann::json& row_named(nlohmann::json& header, const std::string& name) {
  for (auto& row : header["rows"])
    if (row["name"] == name) return row;
  throw std::runtime_error("no row " + name);
}

}  // namespace

TEST_CASE("S18 a table survives its file bit by bit, and its hash is stable") {
  const Folder folder;
  scene::Sun sun;
  sun.zenith_deg = 40;
  sun.azimuth_deg = 160.25;
  const RenderTable made = build_clear_sky({}, sun, 610, {0.4, 0.5501234567890123, 0.94}, {-3, 0.1, 200});
  const std::string hash = write_rct(made, folder.file("a.rct"), base::IfExists::refuse);
  const RenderTable read = read_rct(folder.file("a.rct"));
  CHECK(hash == content_hash(made));
  CHECK(hash == content_hash(read));
  CHECK(read.sun_azimuth_deg == made.sun_azimuth_deg);
  CHECK(read.sensor_height_m == 610);
  CHECK(read.solar_source == made.solar_source);
  CHECK(read.provenance_json == made.provenance_json);
  REQUIRE(read.axes.size() == made.axes.size());
  for (const auto& [name, axis] : made.axes) CHECK(read.axis(name).nodes == axis.nodes);
  REQUIRE(read.rows.size() == made.rows.size());
  for (const auto& [name, row] : made.rows) {
    const Row& back = read.rows.at(name);
    CHECK(back.axes == row.axes);
    CHECK(back.text == row.text);
    CHECK(back.unit == row.unit);
    REQUIRE(back.values.size() == row.values.size());
    CHECK(std::memcmp(back.values.data(), row.values.data(), row.values.size() * 4) == 0);
  }
  CHECK_THROWS_AS(write_rct(made, folder.file("a.rct"), base::IfExists::refuse), base::Error);
  RenderTable changed = made;
  changed.rows.at("two_way_factor").values[0] += 1e-3f;
  CHECK(content_hash(changed) != hash);
}

TEST_CASE("S18 every array of a file lies on 64 bytes, and the head is as documented") {
  const Folder folder;
  write_rct(uniform_table({}, {0.4, 0.5, 0.6}), folder.file("a.rct"), base::IfExists::refuse);
  const std::string bytes = slurp(folder.file("a.rct"));
  CHECK(bytes.size() % 64 == 0);
  Parts parts = take_apart(bytes);
  CHECK(parts.header["format"] == "raycube render table");
  for (const auto& row : parts.header["rows"]) CHECK(row["offset"].get<std::uint64_t>() % 64 == 0);
  float value;
  std::memcpy(&value,
              parts.arrays.data() + row_named(parts.header, "solar_irradiance")["offset"].get<std::size_t>() + 8, 4);
  CHECK(value == 1000.0f);
  CHECK(sealed(parts.header, parts.arrays).size() > 64);
}

TEST_CASE("S18 S20 a damaged file is refused with its reason") {
  const Folder folder;
  const std::string path = folder.file("a.rct"), bad = folder.file("bad.rct");
  write_rct(uniform_table({}, {0.4, 0.5, 0.6}), path, base::IfExists::refuse);
  const std::string good = slurp(path);
  const auto reason = [&](std::string bytes) {
    spit(bad, bytes);
    return message_of([&] { read_rct(bad); });
  };
  const auto patched = [&](std::size_t at, std::uint64_t value, std::size_t bytes) {
    std::string out = good;
    std::memcpy(out.data() + at, &value, bytes);
    return out;
  };
  CHECK(reason("") ==
        bad + ": is no render table: shorter than its 64-byte head (found 0 bytes); build or import the table again");
  CHECK(reason(good.substr(0, 63)).find("shorter than") != std::string::npos);
  CHECK(reason(std::string(200, 'x')).find("first bytes must be") != std::string::npos);
  CHECK(reason(good.substr(0, good.size() - 1)).find("truncated") != std::string::npos);
  CHECK(reason(good + "x").find("appended") != std::string::npos);
  CHECK(reason(patched(8, 2, 4)).find("version") != std::string::npos);
  CHECK(reason(patched(12, 0x04030201, 4)).find("little-endian") != std::string::npos);
  CHECK(reason(patched(16, ~std::uint64_t{0}, 8)).find("header length") != std::string::npos);
  CHECK(reason(patched(16, good.size(), 8)).find("header length") != std::string::npos);
  for (std::size_t at : {std::size_t{40}, std::size_t{70}, good.size() / 2, good.size() - 64}) {
    std::string flipped = good;
    flipped[at] = static_cast<char>(flipped[at] ^ 1);
    CHECK(reason(flipped).find("corrupt") != std::string::npos);
  }
  CHECK_THROWS_WITH_AS(read_rct(folder.file("none.rct")), doctest::Contains("cannot be opened"), base::Error);
  CHECK_THROWS_AS(read_rct(folder.path.string()), base::Error);
}

TEST_CASE("S18 S20 a well-sealed file with wrong content is refused with its reason") {
  const Folder folder;
  const std::string path = folder.file("a.rct"), bad = folder.file("bad.rct");
  write_rct(uniform_table({}, {0.4, 0.5, 0.6}), path, base::IfExists::refuse);
  const Parts good = take_apart(slurp(path));
  const auto reason = [&](const std::function<void(Parts&)>& change) {
    Parts parts = good;
    change(parts);
    spit(bad, sealed(parts.header, parts.arrays));
    return message_of([&] { read_rct(bad); });
  };
  const auto has = [](const std::string& text, const char* part) {
    CAPTURE(text);
    return text.find(part) != std::string::npos;
  };
  const auto set_value = [](Parts& p, const char* row, float value) {
    std::memcpy(p.arrays.data() + row_named(p.header, row)["offset"].get<std::size_t>() + 4, &value, 4);
  };
  CHECK(reason([](Parts&) {}) == "no error");
  CHECK(has(reason([](Parts& p) { p.header = nlohmann::json::array(); }), "must be a JSON object"));
  CHECK(has(reason([](Parts& p) { p.header.erase("rows"); }), "lacks 'rows'"));
  CHECK(has(reason([](Parts& p) { p.header["medium"] = "water"; }), "vacuum or air"));
  CHECK(has(reason([](Parts& p) { p.header["medium"] = 3; }), "must be text"));
  CHECK(has(reason([](Parts& p) { p.header["sun_zenith_deg"] = nullptr; }), "finite number"));
  CHECK(has(reason([](Parts& p) { p.header["sun_zenith_deg"] = 200; }), "sun zenith"));
  CHECK(has(reason([](Parts& p) { row_named(p.header, "solar_irradiance")["shape"][0] = 4; }), "as long as its axis"));
  CHECK(has(reason([](Parts& p) { row_named(p.header, "solar_irradiance")["shape"][0] = -3; }), "whole number"));
  CHECK(has(reason([](Parts& p) { row_named(p.header, "solar_irradiance")["offset"] = 1; }), "multiple of 64"));
  CHECK(has(reason([](Parts& p) { row_named(p.header, "solar_irradiance")["offset"] = 1 << 20; }), "ends beyond"));
  CHECK(has(reason([](Parts& p) { row_named(p.header, "solar_irradiance")["unit"] = "W"; }), "unit must be"));
  CHECK(has(reason([](Parts& p) { row_named(p.header, "solar_irradiance")["name"] = "sunshine"; }), "unknown row"));
  CHECK(has(reason([](Parts& p) { p.header["rows"].push_back(p.header["rows"][0]); }), "row twice"));
  CHECK(has(reason([](Parts& p) { p.header["axes"].push_back(p.header["axes"][0]); }), "axis twice"));
  CHECK(has(reason([](Parts& p) { p.arrays.resize(64); }), "beyond the file"));
  const auto wavelength = [](Parts& p) -> nlohmann::json& {
    for (auto& axis : p.header["axes"])
      if (axis["name"] == "wavelength") return axis["nodes"];
    throw std::runtime_error("no wavelengths");
  };
  CHECK(has(reason([&](Parts& p) { wavelength(p) = {0.5, 0.4, 0.6}; }), "ascend strictly"));
  CHECK(has(reason([&](Parts& p) { wavelength(p) = {0.4, 0.4, 0.6}; }), "ascend strictly"));
  CHECK(has(reason([&](Parts& p) { wavelength(p) = {0.4, nullptr, 0.6}; }), "finite number"));
  CHECK(has(reason([&](Parts& p) { wavelength(p) = {-0.4, 0.5, 0.6}; }), "must lie in"));
  CHECK(has(reason([&](Parts& p) { set_value(p, "solar_irradiance", std::nanf("")); }), "finite"));
  CHECK(has(reason([&](Parts& p) { set_value(p, "solar_irradiance", std::numeric_limits<float>::infinity()); }),
            "finite"));
  CHECK(has(reason([&](Parts& p) { set_value(p, "path_radiance_solar", -1e-6f); }), "must lie in 0"));
  CHECK(has(reason([&](Parts& p) { set_value(p, "sun_transmission", 1.0001f); }), "must lie in 0 to 1"));
  // A dimension whose product would overflow 64 bits is met by the size of the file before anything is allocated.
  CHECK(has(reason([&](Parts& p) {
              nlohmann::json row = row_named(p.header, "path_radiance_solar");
              for (auto& axis : p.header["axes"])
                if (axis["name"] != "wavelength") axis["nodes"] = nlohmann::json(std::vector<double>(3000, 1.0));
              row["shape"] = {3, 3000, 3000, 3000};
              p.header["rows"] = nlohmann::json::array({row});
            }),
            "does not fit the file"));
}

TEST_CASE("S18 every row of the format round-trips, and the document lists the registry") {
  const Folder folder;
  RenderTable table = uniform_table({}, {0.4, 0.5});
  for (const AxisSpec& axis : axis_registry())
    if (!table.axes.count(axis.name)) add_axis(table, axis.name, {std::max(axis.min, 0.0) + 1});
  for (const RowSpec& spec : row_registry()) {
    Row& row = add_row(table, spec.name, "test");
    const double value = std::string(spec.name) == "air_temperature"         ? 280
                         : std::string(spec.name).ends_with("optical_depth") ? 0
                                                                             : 1;
    std::fill(row.values.begin(), row.values.end(), static_cast<float>(value));
  }
  write_rct(table, folder.file("all.rct"), base::IfExists::refuse);
  CHECK(read_rct(folder.file("all.rct")).rows.size() == row_registry().size());
  const std::string document = slurp(std::string(RAYCUBE_SOURCE_DIR) + "/docs/table_format.md");
  CHECK(document.find(registry_markdown()) != std::string::npos);
}

TEST_CASE("S18 an absent row is absent by name") {
  RenderTable table = uniform_table({}, {0.4, 0.5});
  table.rows.erase("sky_radiance_solar");
  validate(table, "test");
  CHECK_THROWS_WITH_AS(table.need("sky_radiance_solar", "skylight"), doctest::Contains("no row 'sky_radiance_solar'"),
                       base::Error);
  CHECK_THROWS_WITH_AS(table.need("path_radiance_thermal", "a thermal band"), doctest::Contains("a thermal band"),
                       base::Error);
}
