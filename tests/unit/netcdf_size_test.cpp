// Bytes of netCDF files of the classic formats, by files written here after their specification.
#include "host/base/netcdf_size.h"

#include <doctest/doctest.h>

#include "tests/unit/test_folder.h"

using raycube::base::netcdf_bytes;

namespace {

struct Written {
  std::string bytes;
  int version;

  void number(std::uint64_t value, int size) {
    for (int i = size - 1; i >= 0; --i) bytes += static_cast<char>(value >> 8 * i);
  }
  void count(std::uint64_t value) { number(value, version == 5 ? 8 : 4); }
  void name(const std::string& text) {
    count(text.size());
    bytes += text + std::string((4 - text.size() % 4) % 4, '\0');
  }
};

/// y = 2, x = 3, and time, unlimited; z(y, x) of floats, an attribute of three shorts; t(time, x) of shorts: 6 bytes,
/// which stand in 8 where u(time, x) follows, and in 6 where t is alone.
std::string file(int version, std::uint64_t records, bool alone = false, std::uint64_t x = 3) {
  Written w{"CDF", version};
  w.number(static_cast<std::uint64_t>(version), 1);
  w.count(records);
  w.number(10, 4), w.count(3);
  w.name("y"), w.count(2), w.name("x"), w.count(x), w.name("time"), w.count(0);
  w.number(0, 4), w.count(0);
  w.number(11, 4), w.count(alone ? 2 : 3);
  const auto variable = [&](const std::string& name, std::uint64_t first, std::uint64_t type, std::uint64_t bytes) {
    w.name(name), w.count(2), w.count(first), w.count(1);
    w.number(12, 4), w.count(1), w.name("range"), w.number(3, 4), w.count(3), w.bytes += std::string(8, '\1');
    w.number(type, 4), w.count(bytes);
    const std::size_t begin = w.bytes.size();
    w.number(0, version == 1 ? 4 : 8);
    return begin;
  };
  const std::size_t z = variable("z", 0, 5, 24), t = variable("t", 2, 3, 8), u = alone ? 0 : variable("u", 2, 3, 8);
  const auto begins = [&](std::size_t at, std::uint64_t value) {
    const int size = version == 1 ? 4 : 8;
    for (int i = 0; i < size; ++i)
      w.bytes[at + static_cast<std::size_t>(i)] = static_cast<char>(value >> 8 * (size - 1 - i));
  };
  begins(z, w.bytes.size()), begins(t, w.bytes.size() + 24);
  if (!alone) begins(u, w.bytes.size() + 32);
  const std::uint64_t of_records = alone ? 6 * records : records > 0 ? 16 * records - 2 : 0;
  return w.bytes + std::string(24 + of_records, '\2');
}

}  // namespace

TEST_CASE("netCDF: bytes that a header counts, of three versions, with and without records") {
  const raycube::testing::TestFolder folder;
  const auto bytes_of = [&](const std::string& content) {
    folder.write("x.nc", content);
    return netcdf_bytes(folder / "x.nc");
  };
  for (const int version : {1, 2, 5})
    for (const std::uint64_t records : {0, 1, 2, 3, 6, 7}) {
      const bool alone = records >= 6 || records == 2;
      CAPTURE(version);
      CAPTURE(records);
      const std::string whole = file(version, records, alone);
      CHECK(bytes_of(whole) == whole.size());
      CHECK(bytes_of(whole.substr(0, whole.size() - 5)) == whole.size());
    }
  for (const std::string& none : {std::string(), std::string("CDF"), std::string("CDF\3"), std::string("\x89HDF\r\n"),
                                  file(1, 0).substr(0, 60), "CDF\1" + std::string(40, '\xff')})
    CHECK(bytes_of(none) == 0);
  // Lengths whose product is beyond 64 bits: nothing is said of the size.
  CHECK(bytes_of(file(5, 3, false, (std::uint64_t{1} << 55) + 1)) == 0);
}
