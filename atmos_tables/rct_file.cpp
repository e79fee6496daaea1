#include "atmos_tables/rct_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>

#include <nlohmann/json.hpp>

#include "atmos_tables/table_rows.h"
#include "host/base/error.h"
#include "host/base/input_file.h"
#include "host/base/json_text.h"
#include "host/base/sha256.h"
#include "host/base/text.h"

namespace raycube::atmos {

namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "the file is little-endian; swap bytes here first");

/// First 64 bytes of a file. Reserved and padding bytes are 0.
struct Head {
  std::array<char, 8> magic;
  std::uint32_t version;
  std::uint32_t byte_order;    ///< 0x01020304 as written
  std::uint64_t header_bytes;  ///< JSON that follows the head
  std::uint64_t file_bytes;
  std::array<std::uint8_t, 32> hash;  ///< SHA-256 of all bytes from 64 on
};
static_assert(sizeof(Head) == 64);

// A byte above 127 and both line ends, as in PNG: a transfer that alters text is seen at once.
constexpr std::array<char, 8> kMagic = {'\x89', 'R', 'C', 'T', '\r', '\n', '\x1a', '\n'};
constexpr std::uint32_t kByteOrder = 0x01020304;
constexpr std::uint64_t kAlign = 64;

std::uint64_t aligned(std::uint64_t bytes) { return (bytes + kAlign - 1) / kAlign * kAlign; }

/// Calls sink(data, bytes) for every byte from 64 on, in order. Returns the number of header bytes.
template <class Sink>
std::uint64_t encode(const RenderTable& table, Sink&& sink) {
  json header;
  header["format"] = "raycube render table";
  header["version"] = kRctVersion;
  header["arrays"] = "float32, little-endian, last axis fastest; offsets from the end of the header padded to 64 bytes";
  header["medium"] = table.medium;
  header["solar_source"] = table.solar_source;
  header["sun_zenith_deg"] = table.sun_zenith_deg;
  header["sun_azimuth_deg"] = table.sun_azimuth_deg;
  header["sensor_height_m"] = table.sensor_height_m;
  header["provenance"] = table.provenance_json.empty() ? json() : json::parse(table.provenance_json, nullptr, false);
  if (header["provenance"].is_discarded())
    throw base::Error(base::Fault::input, "atmosphere table: provenance is not JSON (found '" +
                                              table.provenance_json.substr(0, 60) + "'); give one JSON value");
  header["axes"] = json::array();
  for (const auto& [name, axis] : table.axes)
    header["axes"].push_back({{"name", name}, {"unit", axis.unit}, {"nodes", axis.nodes}});
  header["rows"] = json::array();
  std::uint64_t offset = 0;
  for (const auto& [name, row] : table.rows) {
    json shape = json::array();
    for (const std::string& axis : row.axes) shape.push_back(table.axis(axis).nodes.size());
    header["rows"].push_back({{"name", name},
                              {"unit", row.unit},
                              {"text", row.text},
                              {"axes", row.axes},
                              {"shape", shape},
                              {"offset", offset}});
    offset += aligned(row.values.size() * sizeof(float));
  }
  const std::string text = header.dump(1);
  const std::array<char, kAlign> zeros{};
  sink(text.data(), text.size());
  sink(zeros.data(), aligned(text.size()) - text.size());
  for (const auto& [name, row] : table.rows) {
    const std::size_t bytes = row.values.size() * sizeof(float);
    sink(row.values.data(), bytes);
    sink(zeros.data(), aligned(bytes) - bytes);
  }
  return text.size();
}

/// Refuses a file: one message with what, where, what was found and the way out.
[[noreturn]] void refuse(const std::string& path, const std::string& what, const std::string& found,
                         const std::string& way_out = "build or import the table again") {
  base::Problems problems;
  problems.add({path, 0, 0, ""}, what, found, way_out);
  problems.throw_if_any();
  throw base::Error(base::Fault::bug, "refuse: no problem recorded");
}

std::string text_of(const json& value, std::size_t limit = 40) {
  const std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return text.size() <= limit ? text : text.substr(0, limit) + "...";
}

/// Member access that names what is missing or of the wrong type.
class Member {
 public:
  Member(const std::string& path, const json& object, std::string where)
      : path_(path), object_(object), where_(std::move(where)) {
    if (!object.is_object()) refuse(path_, where_ + " must be a JSON object", text_of(object));
  }
  const json& at(const char* key) const {
    const auto found = object_.find(key);
    if (found == object_.end()) refuse(path_, where_ + " lacks '" + key + "'", text_of(object_));
    return *found;
  }
  std::string text(const char* key) const {
    const json& value = at(key);
    if (!value.is_string()) refuse(path_, where_ + " '" + key + "' must be text", text_of(value));
    return value.get<std::string>();
  }
  double number(const char* key) const { return number_of(at(key), std::string("'") + key + "'"); }
  double number_of(const json& value, const std::string& name) const {
    if (!value.is_number()) refuse(path_, where_ + " " + name + " must be a finite number", text_of(value));
    return value.get<double>();
  }
  std::uint64_t integer(const json& value, const std::string& name) const {
    if (!value.is_number_unsigned())
      refuse(path_, where_ + " " + name + " must be a whole number from 0", text_of(value));
    return value.get<std::uint64_t>();
  }
  const json& list(const char* key) const {
    const json& value = at(key);
    if (!value.is_array()) refuse(path_, where_ + " '" + key + "' must be a list", text_of(value));
    return value;
  }

 private:
  const std::string& path_;
  const json& object_;
  std::string where_;
};

Axis decode_axis(const std::string& path, const json& value) {
  const Member member(path, value, "an axis of the header");
  Axis axis{member.text("name"), member.text("unit"), {}};
  const Member named(path, value, "axis " + axis.name);
  for (const json& node : named.list("nodes"))
    axis.nodes.push_back(named.number_of(node, "node " + std::to_string(axis.nodes.size())));
  return axis;
}

/// A row without values, and where they lie in the array part.
struct Placed {
  Row row;
  std::uint64_t offset, count;
};

Placed decode_row(const std::string& path, const json& value, const RenderTable& table, std::uint64_t array_bytes) {
  const Member unnamed(path, value, "a row of the header");
  Placed out{{unnamed.text("name"), unnamed.text("unit"), unnamed.text("text"), {}, {}}, 0, 1};
  const Member member(path, value, "row " + out.row.name);
  const json &axes = member.list("axes"), &shape = member.list("shape");
  if (axes.size() != shape.size())
    refuse(path, "row " + out.row.name + " must state one length per axis", text_of(axes) + " and " + text_of(shape));
  for (std::size_t i = 0; i < axes.size(); ++i) {
    if (!axes[i].is_string()) refuse(path, "row " + out.row.name + " axes must be names", text_of(axes[i]));
    const std::string name = axes[i].get<std::string>();
    const auto axis = table.axes.find(name);
    if (axis == table.axes.end()) refuse(path, "row " + out.row.name + " uses an axis that is not there", name);
    const std::uint64_t length = member.integer(shape[i], "shape");
    if (length != axis->second.nodes.size())
      refuse(path,
             "row " + out.row.name + " must be as long as its axis " + name + " (" +
                 base::counted(axis->second.nodes.size(), "node") + ")",
             std::to_string(length));
    // The product stays below the file's size, so it cannot overflow.
    if (length == 0 || out.count > array_bytes / sizeof(float) / length)
      refuse(path,
             "row " + out.row.name + " does not fit the file's " + base::counted(array_bytes, "byte") + " of arrays",
             "shape " + text_of(shape));
    out.count *= length;
    out.row.axes.push_back(name);
  }
  out.offset = member.integer(member.at("offset"), "offset");
  if (out.offset % kAlign != 0)
    refuse(path, "row " + out.row.name + " offset must be a multiple of 64", std::to_string(out.offset));
  if (out.offset > array_bytes || out.count * sizeof(float) > array_bytes - out.offset)
    refuse(path, "row " + out.row.name + " ends beyond the file's " + base::counted(array_bytes, "byte") + " of arrays",
           "offset " + std::to_string(out.offset) + ", " + base::counted(out.count, "value"));
  return out;
}

}  // namespace

std::string content_hash(const RenderTable& table) {
  base::Sha256 hash;
  encode(table, [&](const void* data, std::size_t bytes) { hash.add(data, bytes); });
  return hash.hex();
}

std::string write_rct(const RenderTable& table, const std::string& path, base::IfExists if_exists) {
  validate(table, path);
  base::OutputFile file(path, if_exists);
  Head head{kMagic, kRctVersion, kByteOrder, 0, 0, {}};
  file.append(&head, sizeof head);
  base::Sha256 hash;
  head.header_bytes = encode(table, [&](const void* data, std::size_t bytes) {
    hash.add(data, bytes);
    file.append(data, bytes);
  });
  head.file_bytes = file.size();
  head.hash = hash.digest();
  file.write_at(0, &head, sizeof head);
  file.publish();
  return hash.hex();
}

RenderTable read_rct(const std::string& path) {
  base::refuse_other_than_plain(path);
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file)
    throw base::Error(base::Fault::environment, path + ": cannot be opened; check the path and its permissions");
  const auto end = file.tellg();
  if (end < 0) throw base::Error(base::Fault::environment, path + ": is not a regular file that can be read");
  const std::uint64_t size = static_cast<std::uint64_t>(end);
  const auto fetch = [&](std::uint64_t offset, void* data, std::uint64_t bytes) {
    file.seekg(static_cast<std::streamoff>(offset));
    if (!file.read(static_cast<char*>(data), static_cast<std::streamsize>(bytes)))
      throw base::Error(base::Fault::environment, path + ": " + base::counted(bytes, "byte") + " at offset " +
                                                      std::to_string(offset) + " could not be read");
  };
  Head head{};
  if (size < sizeof head)
    refuse(path, "is no render table: shorter than its 64-byte head", base::counted(size, "byte"));
  fetch(0, &head, sizeof head);
  if (head.magic != kMagic) {
    static const char* digits = "0123456789abcdef";
    std::string found;
    for (const char c : head.magic)
      found += digits[static_cast<unsigned char>(c) >> 4], found += digits[static_cast<unsigned char>(c) & 15];
    refuse(path, "is no render table: its first bytes must be 895243540d0a1a0a in hexadecimal", found,
           "name a .rct file");
  }
  if (head.byte_order != kByteOrder)
    refuse(path, "must be little-endian (byte-order mark 16909060)", std::to_string(head.byte_order));
  if (head.version != kRctVersion)
    refuse(path, "has a format version this program does not read (it reads " + std::to_string(kRctVersion) + ")",
           std::to_string(head.version), "use the program that wrote it, or build the table again");
  if (head.file_bytes != size)
    refuse(path, "is truncated or has bytes appended: its head says " + base::counted(head.file_bytes, "byte"),
           base::counted(size, "byte"), "copy or build it again");
  if (head.header_bytes > size - sizeof head)
    refuse(path, "header length exceeds the file", std::to_string(head.header_bytes) + " of " + std::to_string(size));
  const std::uint64_t data_start = sizeof head + aligned(head.header_bytes);
  if (data_start > size) refuse(path, "ends before its arrays begin", base::counted(size, "byte"));

  base::Sha256 hash;
  std::vector<char> chunk(std::size_t{1} << 20);
  for (std::uint64_t at = sizeof head; at < size;) {
    const std::uint64_t bytes = std::min<std::uint64_t>(chunk.size(), size - at);
    fetch(at, chunk.data(), bytes);
    hash.add(chunk.data(), bytes);
    at += bytes;
  }
  if (hash.digest() != head.hash)
    refuse(path, "is corrupt: its content does not match its hash", hash.hex(), "copy or build it again");

  std::string text(head.header_bytes, '\0');
  fetch(sizeof head, text.data(), text.size());
  const json header = json::parse(base::shallow_json(text), nullptr, false);
  if (header.is_discarded()) refuse(path, "header is not JSON", text.substr(0, 40));
  const Member member(path, header, "the header");
  RenderTable table;
  table.medium = member.text("medium");
  table.solar_source = member.text("solar_source");
  table.sun_zenith_deg = member.number("sun_zenith_deg");
  table.sun_azimuth_deg = member.number("sun_azimuth_deg");
  table.sensor_height_m = member.number("sensor_height_m");
  table.provenance_json = member.at("provenance").is_null() ? "" : member.at("provenance").dump();
  for (const json& value : member.list("axes")) {
    Axis axis = decode_axis(path, value);
    const std::string name = axis.name;
    if (!table.axes.emplace(name, std::move(axis)).second) refuse(path, "holds an axis twice", name);
  }
  for (const json& value : member.list("rows")) {
    Placed placed = decode_row(path, value, table, size - data_start);
    placed.row.values.resize(placed.count);
    fetch(data_start + placed.offset, placed.row.values.data(), placed.count * sizeof(float));
    const std::string name = placed.row.name;
    if (!table.rows.emplace(name, std::move(placed.row)).second) refuse(path, "holds a row twice", name);
  }
  validate(table, path);
  return table;
}

}  // namespace raycube::atmos
