#include "host/base/netcdf_size.h"

#include <algorithm>
#include <fstream>
#include <vector>

namespace raycube::base {
namespace {

constexpr std::uint64_t kMost = std::uint64_t{1} << 56;  // of a sound header's numbers

class Header {
 public:
  explicit Header(const std::string& path) : in_(path, std::ios::binary) {}

  std::uint64_t number(int bytes) {
    std::uint64_t out = 0;
    for (int i = 0; i < bytes && sound_; ++i) {
      const int next = in_.get();
      sound_ = next != std::char_traits<char>::eof();
      out = out << 8 | static_cast<std::uint64_t>(next & 0xff);
    }
    return out;
  }
  /// Of things that follow; at most a header's worth.
  std::uint64_t count() {
    const std::uint64_t out = number(wide ? 8 : 4);
    sound_ = sound_ && out < kMost;
    return sound_ ? out : 0;
  }
  void pass(std::uint64_t bytes) {
    bytes = (bytes + 3) / 4 * 4;
    sound_ = sound_ && bytes < kMost && in_.ignore(static_cast<std::streamsize>(bytes)).good();
  }
  void pass_name() { pass(count()); }
  bool sound() const { return sound_; }

  bool wide = false;  ///< CDF-5

 private:
  std::ifstream in_;
  bool sound_ = true;
};

/// Bytes of one number of a type; 0: no type.
std::uint64_t bytes_of(std::uint64_t type) {
  static constexpr std::uint64_t kBytes[] = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};
  return type < std::size(kBytes) ? kBytes[type] : 0;
}

void pass_attributes(Header& header) {
  header.number(4);  // the list's tag
  for (std::uint64_t left = header.count(); left > 0 && header.sound(); --left) {
    header.pass_name();
    const std::uint64_t type = header.number(4);
    header.pass(header.count() * bytes_of(type));
  }
}

}  // namespace

std::uint64_t netcdf_bytes(const std::string& path) {
  Header header(path);
  if (header.number(3) != 0x434446) return 0;  // "CDF"
  const std::uint64_t version = header.number(1);
  if (version != 1 && version != 2 && version != 5) return 0;
  header.wide = version == 5;
  const std::uint64_t records = header.number(header.wide ? 8 : 4);
  std::vector<std::uint64_t> length;
  header.number(4);
  for (std::uint64_t left = header.count(); left > 0 && header.sound(); --left) {
    header.pass_name();
    length.push_back(header.count());
  }
  pass_attributes(header);
  struct Variable {
    std::uint64_t begin, bytes;  ///< record variables: of one record
    bool by_record;
  };
  std::vector<Variable> variables;
  std::uint64_t of_record = 0, by_records = 0;
  header.number(4);
  for (std::uint64_t left = header.count(); left > 0 && header.sound(); --left) {
    header.pass_name();
    std::uint64_t numbers = 1;
    bool by_record = false;
    for (std::uint64_t dimensions = header.count(); dimensions > 0 && header.sound(); --dimensions) {
      const std::uint64_t which = header.number(header.wide ? 8 : 4);
      if (which >= length.size()) return 0;
      by_record = by_record || length[which] == 0;
      if (__builtin_mul_overflow(numbers, std::max<std::uint64_t>(length[which], 1), &numbers)) return 0;
    }
    pass_attributes(header);
    std::uint64_t bytes = 0;
    if (__builtin_mul_overflow(numbers, bytes_of(header.number(4)), &bytes) || bytes > kMost) return 0;
    header.count();  // vsize, which large variables do not fit
    variables.push_back({header.number(version == 1 ? 4 : 8), bytes, by_record});
    if (by_record) ++by_records, of_record += (bytes + 3) / 4 * 4;
    if (of_record > kMost) return 0;
  }
  if (!header.sound() || records >= 0xffffffff) return 0;
  std::uint64_t out = 0;
  for (const Variable& variable : variables) {
    if (variable.by_record && records == 0) continue;
    // Records of a single variable follow each other without padding (NetCDF Classic Format Specification, note on
    // padding).
    const std::uint64_t each = by_records == 1 ? variable.bytes : of_record;
    std::uint64_t before = 0, end = 0;
    if (variable.by_record && __builtin_mul_overflow(records - 1, each, &before)) return 0;
    if (__builtin_add_overflow(variable.begin + variable.bytes, before, &end)) return 0;
    out = std::max(out, end);
  }
  return out < kMost ? out : 0;
}

}  // namespace raycube::base
