#include "host/base/image_orientation.h"

#include <cstdint>
#include <fstream>

namespace raycube::base {
namespace {

constexpr std::uint64_t kOrientationTag = 274, kMostEntries = 4096, kMostParts = 100000;

class File {
 public:
  explicit File(const std::string& path) : in_(path, std::ios::binary) {}

  /// A whole number of bytes at a place; 0 past the end.
  std::uint64_t number(std::uint64_t at, int bytes, bool big_endian) {
    unsigned char raw[8] = {};
    in_.clear();
    if (at > (std::uint64_t{1} << 62) ||
        !in_.seekg(static_cast<std::streamoff>(at)).read(reinterpret_cast<char*>(raw), bytes))
      return 0;
    std::uint64_t out = 0;
    for (int i = 0; i < bytes; ++i) out = out << 8 | raw[big_endian ? i : bytes - 1 - i];
    return out;
  }
  bool has(std::uint64_t at, const std::string& text) {
    for (std::size_t i = 0; i < text.size(); ++i)
      if (number(at + i, 1, true) != static_cast<unsigned char>(text[i])) return false;
    return true;
  }

 private:
  std::ifstream in_;
};

/// The first directory of a TIFF that begins at `base`: a file of its own, or what EXIF holds.
int of_tiff(File& file, std::uint64_t base) {
  const bool big_endian = file.has(base, "MM");
  if (!big_endian && !file.has(base, "II")) return 1;
  const std::uint64_t version = file.number(base + 2, 2, big_endian);
  const bool wide = version == 43;  // BigTIFF
  if (version != 42 && !wide) return 1;
  const std::uint64_t directory =
      base + (wide ? file.number(base + 8, 8, big_endian) : file.number(base + 4, 4, big_endian));
  const std::uint64_t entries = file.number(directory, wide ? 8 : 2, big_endian), entry_bytes = wide ? 20 : 12;
  for (std::uint64_t i = 0; i < entries && i < kMostEntries; ++i) {
    const std::uint64_t at = directory + (wide ? 8 : 2) + i * entry_bytes;
    if (file.number(at, 2, big_endian) != kOrientationTag) continue;
    const std::uint64_t value = file.number(at + (wide ? 12 : 8), 2, big_endian);
    return value >= 1 && value <= 8 ? static_cast<int>(value) : 1;
  }
  return 1;
}

int of_jpeg(File& file) {
  for (std::uint64_t at = 2, part = 0; part < kMostParts; ++part) {
    const std::uint64_t marker = file.number(at, 2, true), bytes = file.number(at + 2, 2, true);
    if (marker < 0xff00 || marker == 0xffda || bytes < 2) return 1;
    if (marker == 0xffe1 && file.has(at + 4, std::string("Exif\0\0", 6))) return of_tiff(file, at + 10);
    at += 2 + bytes;
  }
  return 1;
}

int of_png(File& file) {
  for (std::uint64_t at = 8, part = 0; part < kMostParts; ++part) {
    if (file.has(at + 4, "eXIf")) return of_tiff(file, at + 8);
    if (file.has(at + 4, "IEND") || file.number(at + 4, 4, true) == 0) return 1;
    at += 12 + file.number(at, 4, true);
  }
  return 1;
}

int of_webp(File& file) {
  for (std::uint64_t at = 12, part = 0; part < kMostParts && file.number(at, 4, true) != 0; ++part) {
    const std::uint64_t bytes = file.number(at + 4, 4, false);
    if (file.has(at, "EXIF")) return of_tiff(file, at + (file.has(at + 8, "Exif") ? 14 : 8));
    at += 8 + bytes + bytes % 2;
  }
  return 1;
}

}  // namespace

int image_orientation(const std::string& path) {
  File file(path);
  if (file.has(0, "\xff\xd8")) return of_jpeg(file);
  if (file.has(0, "\x89PNG")) return of_png(file);
  if (file.has(0, "RIFF") && file.has(8, "WEBP")) return of_webp(file);
  return of_tiff(file, 0);
}

FilePixel file_pixel(int orientation, std::size_t seen_row, std::size_t seen_column, std::size_t rows,
                     std::size_t columns) {
  const bool turned = orientation >= 5;  // the file's first row is seen as a column
  const std::size_t row = turned ? seen_column : seen_row, column = turned ? seen_row : seen_column;
  const bool from_below = orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
  const bool from_right = orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
  // By the tag's words: "3: row 0 is seen at the bottom, column 0 on the right", "6: row 0 on the right, column 0 on
  // top", "8: row 0 on the left, column 0 at the bottom".
  const bool row_back = turned ? from_right : from_below, column_back = turned ? from_below : from_right;
  return {row_back ? rows - 1 - row : row, column_back ? columns - 1 - column : column};
}

std::string orientation_text(int orientation) {
  static const char* const kNames[] = {"upright",
                                       "mirrored",
                                       "turned by a half",
                                       "flipped",
                                       "transposed",
                                       "turned by a quarter to the right",
                                       "transposed about its other diagonal",
                                       "turned by a quarter to the left"};
  return std::string(kNames[orientation - 1]) + " (orientation " + std::to_string(orientation) + ")";
}

}  // namespace raycube::base
