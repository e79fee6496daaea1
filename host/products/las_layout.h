// LAS 1.4 R16 (ASPRS, 2025): places and sizes of the records that writer and reader share. Everything is little endian.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string_view>

namespace raycube::products::las {

static_assert(std::endian::native == std::endian::little, "LAS records are copied as they lie in memory");

constexpr std::size_t kHeader = 375, kVlrHeader = 54, kEvlrHeader = 60, kDescriptor = 26, kExtraBytes = 192;
constexpr std::uint16_t kWktId = 2112, kExtraBytesId = 4, kFirstDescriptorId = 100, kLastDescriptorId = 354,
                        kPacketsId = 65535;
constexpr char kProjectionUser[] = "LASF_Projection", kSpecUser[] = "LASF_Spec", kOurUser[] = "raycube";
constexpr std::uint16_t kOurCountsId = 1;  ///< user id "raycube": pulses fired and pulses without return, as text

/// Bits of the global encoding.
constexpr std::uint16_t kAdjustedGpsTime = 1, kInternalPackets = 2, kExternalPackets = 4, kSyntheticReturns = 8,
                        kWkt = 16;

/// Bytes of a point record without extra bytes, formats 0 to 10.
constexpr std::array<std::uint16_t, 11> kPointBytes = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
/// Formats whose points carry waveform packets.
constexpr bool has_packets(int format) { return format == 4 || format == 5 || format == 9 || format == 10; }

/// Bytes of the extra bytes' data types 1 (u8) to 10 (f64); 0: undocumented or an array type of LAS 1.4 before R14.
constexpr std::array<std::uint8_t, 11> kExtraTypeBytes = {0, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};

template <class T>
void put(unsigned char* record, std::size_t at, T value) {
  std::memcpy(record + at, &value, sizeof value);
}
template <class T>
T get(const unsigned char* record, std::size_t at) {
  T value;
  std::memcpy(&value, record + at, sizeof value);
  return value;
}
/// Text into a field of `size` zeroed bytes; what does not fit is left out.
inline void put_text(unsigned char* record, std::size_t at, std::size_t size, std::string_view text) {
  std::memcpy(record + at, text.data(), text.size() < size ? text.size() : size);
}

}  // namespace raycube::products::las
