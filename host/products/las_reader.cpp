#include "host/products/las_reader.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>

#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/publication.h"
#include "host/products/las_layout.h"

namespace raycube::products {
namespace {

using base::Error;
using base::Fault;
using namespace las;
namespace fs = std::filesystem;

Error bad(const std::string& path, const std::string& what) { return Error(Fault::input, path + ": " + what); }

/// Bytes up to the first zero.
std::string bytes_at(const unsigned char* record, std::size_t at, std::size_t size) {
  const char* text = reinterpret_cast<const char*>(record + at);
  return std::string(text, std::find(text, text + size, '\0'));
}

/// Text of a fixed field, printable whatever stands there.
std::string text_at(const unsigned char* record, std::size_t at, std::size_t size) {
  std::string text = bytes_at(record, at, size);
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  return text;
}

struct File {
  std::string path;
  std::ifstream in;
  std::uint64_t bytes = 0;

  explicit File(const std::string& name) : path(name) {
    base::refuse_other_than_plain(name);
    in.open(name, std::ios::binary);
    std::error_code code;
    bytes = fs::file_size(name, code);
    if (!in || code)
      throw bad(path, "cannot be read" + (code ? " (" + code.message() + ")" : std::string()) + "; is the name right?");
  }
  std::vector<unsigned char> read(std::uint64_t at, std::uint64_t count, const std::string& what) {
    if (at > bytes || count > bytes - at)
      throw bad(path, fmt::format("is cut short: {} needs bytes {} to {}, the file has {}; copy it again", what, at,
                                  at + count, bytes));
    std::vector<unsigned char> out(count);
    in.seekg(static_cast<std::streamoff>(at));
    in.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(count));
    if (!in) throw bad(path, fmt::format("reading {} failed", what));
    return out;
  }
};

/// Walks `count` records from `at` on; returns the byte after the last.
std::uint64_t read_records(File& file, LasInfo& info, std::uint64_t at, std::uint32_t count, bool extended) {
  const std::size_t header_bytes = extended ? kEvlrHeader : kVlrHeader;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto header =
        file.read(at, header_bytes, fmt::format("{} {} of {}", extended ? "extended record" : "record", i + 1, count));
    LasRecord record{text_at(header.data(), 2, 16),
                     get<std::uint16_t>(header.data(), 18),
                     text_at(header.data(), extended ? 28 : 22, 32),
                     at + header_bytes,
                     extended ? get<std::uint64_t>(header.data(), 20) : get<std::uint16_t>(header.data(), 20),
                     extended};
    if (record.bytes > file.bytes - record.at)
      throw bad(file.path, fmt::format("is cut short: record {} \"{}\"/{} has {} bytes from byte {}, the file has {}",
                                       i + 1, record.user, record.id, record.bytes, record.at, file.bytes));
    at = record.at + record.bytes;
    info.records.push_back(std::move(record));
  }
  return at;
}

void understand_ours(LasInfo& info, const std::string& text) {
  unsigned long long pulses = 0, without = 0;
  if (std::sscanf(text.c_str(), "pulses = %llu\npulses without return = %llu", &pulses, &without) == 2) {
    info.pulses = pulses;
    info.pulses_without_return = without;
  }
}

void understand(File& file, LasInfo& info, const LasRecord& record) {
  const auto data = [&] { return file.read(record.at, record.bytes, "a record"); };
  if (record.user == kProjectionUser && record.id == kWktId) {
    const auto bytes = data();
    info.wkt = bytes_at(bytes.data(), 0, bytes.size());
  } else if (record.user == kProjectionUser && record.id == 34735) {
    info.geotiff_keys = true;
  } else if (record.user == kSpecUser && record.id == kExtraBytesId) {
    const auto bytes = data();
    for (std::size_t at = 0; at + kExtraBytes <= bytes.size(); at += kExtraBytes)
      info.extra_fields.push_back(
          {text_at(bytes.data(), at + 4, 32), text_at(bytes.data(), at + 160, 32), bytes[at + 2]});
  } else if (record.user == kSpecUser && record.id >= kFirstDescriptorId && record.id <= kLastDescriptorId &&
             record.bytes == kDescriptor) {
    const auto bytes = data();
    info.descriptors.emplace_back(
        record.id - kFirstDescriptorId + 1,
        LasDescriptor{bytes[0], get<std::uint32_t>(bytes.data(), 2), get<std::uint32_t>(bytes.data(), 6),
                      get<double>(bytes.data(), 10), get<double>(bytes.data(), 18)});
  } else if (record.user == kOurUser && record.id == kOurCountsId && record.bytes <= 4096) {
    const auto bytes = data();
    understand_ours(info, bytes_at(bytes.data(), 0, bytes.size()));
  } else if (record.user == kSpecUser && record.id == kPacketsId && record.extended) {
    info.packet_bytes = record.bytes;
  }
}

/// The .wdp of external waveforms.
void find_packet_file(LasInfo& info) {
  fs::path beside = info.path;
  for (const char* extension : {".wdp", ".WDP"}) {
    beside.replace_extension(extension);
    std::error_code code;
    const auto bytes = fs::file_size(beside, code);
    if (code) continue;
    info.packet_file = beside.string();
    if (bytes < kEvlrHeader)
      throw bad(info.packet_file, fmt::format("is cut short: {} bytes, not even the header's 60", bytes));
    const auto header = File(info.packet_file).read(0, kEvlrHeader, "the header");
    const auto said = get<std::uint64_t>(header.data(), 20);
    if (text_at(header.data(), 2, 16) != kSpecUser || get<std::uint16_t>(header.data(), 18) != kPacketsId) {
      info.warnings.push_back(info.packet_file + ": does not begin with the header of a waveform record");
    } else if (said > bytes - kEvlrHeader) {
      throw bad(info.packet_file, fmt::format("is cut short: {} bytes of waveforms announced, {} there; copy it again",
                                              said, bytes - kEvlrHeader));
    }
    info.packet_bytes = bytes - kEvlrHeader;
    return;
  }
  info.warnings.push_back(
      info.path + ": its waveforms should lie in a file of the same name with the ending .wdp, which is missing");
}

}  // namespace

const char* las_type_name(int type) {
  static const char* const names[] = {"bytes", "u8", "i8", "u16", "i16", "u32", "i32", "u64", "i64", "f32", "f64"};
  return type >= 1 && type <= 10 ? names[type] : names[0];
}

LasInfo read_las_info(const std::string& path) {
  base::finish_publication_around(path);
  File file(path);
  LasInfo info;
  info.path = path;
  info.file_bytes = file.bytes;
  const auto start = file.read(0, std::min<std::uint64_t>(file.bytes, kHeader), "the header");
  if (start.size() < 4 || text_at(start.data(), 0, 4) != "LASF")
    throw bad(path, "is no LAS file: it does not begin with LASF");
  if (start.size() < 227)
    throw bad(path, fmt::format("is cut short: {} bytes, a LAS header has at least 227; copy it again", start.size()));
  const unsigned char* h = start.data();
  info.source_id = get<std::uint16_t>(h, 4);
  info.global_encoding = get<std::uint16_t>(h, 6);
  info.major = h[24], info.minor = h[25];
  if (info.major != 1 || info.minor > 4)
    throw bad(path, fmt::format("is LAS {}.{}; known are 1.0 to 1.4", info.major, info.minor));
  const std::size_t needed = info.minor == 4 ? kHeader : info.minor == 3 ? 235 : 227;
  const auto header_bytes = get<std::uint16_t>(h, 94);
  if (header_bytes < needed)
    throw bad(path, fmt::format("the header says it has {} bytes, LAS 1.{} has at least {}", header_bytes, info.minor,
                                needed));
  if (start.size() < needed)
    throw bad(path, fmt::format("is cut short: {} bytes, the header alone has {}; copy it again", start.size(),
                                header_bytes));
  info.system_id = text_at(h, 26, 32);
  info.software = text_at(h, 58, 32);
  info.creation_day = get<std::uint16_t>(h, 90);
  info.creation_year = get<std::uint16_t>(h, 92);
  const auto point_start = get<std::uint32_t>(h, 96);
  info.compressed = (h[104] & 0xC0) != 0;
  info.format = h[104] & 0x3F;
  info.record_bytes = get<std::uint16_t>(h, 105);
  if (info.format > 10) throw bad(path, fmt::format("has point format {}; LAS knows 0 to 10", info.format));
  if (info.record_bytes < kPointBytes[static_cast<std::size_t>(info.format)])
    throw bad(path, fmt::format("points of format {} have at least {} bytes (found {})", info.format,
                                kPointBytes[static_cast<std::size_t>(info.format)], info.record_bytes));
  const bool wide = info.minor == 4;
  info.points = wide ? get<std::uint64_t>(h, 247) : get<std::uint32_t>(h, 107);
  for (std::size_t i = 0; i < (wide ? 15u : 5u); ++i)
    info.by_return.push_back(wide ? get<std::uint64_t>(h, 255 + 8 * i) : get<std::uint32_t>(h, 111 + 4 * i));
  for (std::size_t i = 0; i < 3; ++i) {
    info.scale[i] = get<double>(h, 131 + 8 * i);
    info.offset[i] = get<double>(h, 155 + 8 * i);
    info.high[i] = get<double>(h, 179 + 16 * i);
    info.low[i] = get<double>(h, 187 + 16 * i);
  }
  const std::uint64_t vlr_end = read_records(file, info, header_bytes, get<std::uint32_t>(h, 100), false);
  if (vlr_end > point_start)
    throw bad(path,
              fmt::format("its records end at byte {}, behind the start of the points at {}", vlr_end, point_start));
  const std::uint64_t room = file.bytes < point_start ? 0 : file.bytes - point_start;
  if (!info.compressed && info.points > room / static_cast<std::uint64_t>(info.record_bytes))
    throw bad(
        path,
        fmt::format("is cut short: {} points of {} bytes from byte {} on do not fit into its {} bytes; copy it again",
                    info.points, info.record_bytes, point_start, file.bytes));
  if (wide && get<std::uint32_t>(h, 243) > 0)
    read_records(file, info, get<std::uint64_t>(h, 235), get<std::uint32_t>(h, 243), true);
  for (std::size_t i = 0; i < info.records.size(); ++i) understand(file, info, info.records[i]);
  if (info.minor >= 3) info.packets_at = get<std::uint64_t>(h, 227);
  if (info.minor >= 3 && has_packets(info.format) && info.packets_at == 0) find_packet_file(info);
  std::uint64_t sum = 0;
  for (const auto n : info.by_return) sum += n;
  if (wide && sum != info.points)
    info.warnings.push_back(
        fmt::format("{}: its counts by return add up to {}, not to its {} points", path, sum, info.points));
  return info;
}

}  // namespace raycube::products
