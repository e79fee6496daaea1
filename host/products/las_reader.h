// What a LAS file says of itself: versions 1.0 to 1.4, any point format, LAZ too as far as its header goes. Points are
// not read.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/products/las_writer.h"

namespace raycube::products {

/// A variable length record (VLR), or an extended one (EVLR) behind the points.
struct LasRecord {
  std::string user;
  std::uint16_t id = 0;
  std::string description;
  std::uint64_t at = 0, bytes = 0;  ///< of its data
  bool extended = false;
};

struct LasExtraField {
  std::string name, description;
  int type = 0;  ///< 1 u8, 2 i8, 3 u16, 4 i16, 5 u32, 6 i32, 7 u64, 8 i64, 9 f32, 10 f64; else undocumented
};
/// "u8" ... "f64"; "bytes" for other types.
const char* las_type_name(int type);

struct LasInfo {
  std::string path;
  std::uint64_t file_bytes = 0;
  int major = 1, minor = 4, format = 6, record_bytes = 0;
  bool compressed = false;  ///< LAZ
  std::uint16_t source_id = 0, global_encoding = 0;
  std::string system_id, software;
  int creation_day = 0, creation_year = 0;
  std::uint64_t points = 0;
  std::vector<std::uint64_t> by_return;  ///< 5, or 15 from version 1.4 on
  std::array<double, 3> scale{}, offset{}, low{}, high{};
  std::vector<LasRecord> records;
  std::string wkt;                                         ///< coordinate system as OGC WKT, empty when there is none
  bool geotiff_keys = false;                               ///< coordinate system as GeoTIFF keys
  std::vector<std::pair<int, LasDescriptor>> descriptors;  ///< index as points give it (from 1), contents
  std::vector<LasExtraField> extra_fields;
  std::uint64_t packets_at = 0;    ///< internal waveforms: byte of their record, else 0
  std::string packet_file;         ///< external waveforms: the .wdp beside the file, empty when it is missing
  std::uint64_t packet_bytes = 0;  ///< of the waveforms, headers left out
  std::optional<std::uint64_t> pulses, pulses_without_return;  ///< in files of ours
  std::vector<std::string> warnings;
};

/// Throws Error(input), one clear message, for a file that is missing, no LAS, or shorter than its header says.
LasInfo read_las_info(const std::string& path);

}  // namespace raycube::products
