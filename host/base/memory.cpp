#include "host/base/memory.h"

#include <cctype>
#include <charconv>
#include <cmath>
#include <fstream>

#include <sys/resource.h>

#include <fmt/format.h>

#include "host/base/error.h"

namespace raycube::base {

std::uint64_t parse_memory_size(const std::string& text) {
  const auto refuse = [&](const std::string& what) -> Error {
    return Error(Fault::input, what + " (found \"" + text + "\"); write for example 256M or 8G");
  };
  double number = 0;
  const char* const end = text.data() + text.size();
  const auto [rest, code] = std::from_chars(text.data(), end, number, std::chars_format::fixed);
  if (code != std::errc() || !std::isfinite(number)) throw refuse("a memory size is a number and a unit K, M, G or T");
  std::string unit;
  for (const char* c = rest; c != end; ++c) unit += static_cast<char>(std::toupper(static_cast<unsigned char>(*c)));
  double scale = 1;
  if (!unit.empty() && unit != "B") {
    const std::string tail = unit.substr(1);
    if (tail != "" && tail != "B" && tail != "IB") throw refuse("unknown unit of memory");
    switch (unit[0]) {
      case 'K':
        scale = 0x1p10;
        break;
      case 'M':
        scale = 0x1p20;
        break;
      case 'G':
        scale = 0x1p30;
        break;
      case 'T':
        scale = 0x1p40;
        break;
      default:
        throw refuse("unknown unit of memory");
    }
  }
  const double bytes = number * scale;
  if (!(bytes >= 1)) throw refuse("a memory size must be at least one byte");
  if (bytes > 0x1p60) throw refuse("a memory size must be at most 2^60 bytes");
  return static_cast<std::uint64_t>(bytes);
}

std::string format_bytes(std::uint64_t bytes) {
  if (bytes < 1024) return fmt::format("{} byte{}", bytes, bytes == 1 ? "" : "s");
  static constexpr const char* kUnits[] = {"KiB", "MiB", "GiB", "TiB", "PiB", "EiB"};
  double value = static_cast<double>(bytes) / 1024;
  int unit = 0;
  while (value >= 999.5 && unit < 5) value /= 1024, ++unit;
  return fmt::format("{:.3g} {}", value, kUnits[unit]);
}

std::uint64_t address_space_limit_bytes() noexcept {
  rlimit space{};
  if (::getrlimit(RLIMIT_AS, &space) != 0 || space.rlim_cur == RLIM_INFINITY) return 0;
  return space.rlim_cur;
}

std::string address_space_text() {
  const std::uint64_t limit = address_space_limit_bytes();
  if (limit == 0) return "";
  return "; this process may take " + format_bytes(limit) + " of address space (ulimit -v)";
}

std::uint64_t peak_resident_bytes() {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word) {
    if (word != "VmHWM:") continue;
    std::uint64_t kibibytes = 0;
    status >> kibibytes;
    return kibibytes * 1024;
  }
  return 0;
}

}  // namespace raycube::base
