// Orientation of pictures: the tag where four kinds of file have it, and what it means. Oracle: TIFF 6.0, page 36,
// which says on which side the file's first row and first column are seen.
#include "host/base/image_orientation.h"

#include <doctest/doctest.h>

#include <fstream>

#include "tests/unit/test_folder.h"

using namespace raycube::base;

namespace {

std::string number(std::uint64_t value, int bytes, bool big_endian) {
  std::string out;
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> 8 * (big_endian ? bytes - 1 - i : i));
  return out;
}

/// A directory of two entries, the second of them the orientation.
std::string tiff(int orientation, bool big_endian, bool wide) {
  const auto n = [&](std::uint64_t value, int bytes) { return number(value, bytes, big_endian); };
  const int many = wide ? 8 : 4;
  std::string out = big_endian ? "MM" : "II";
  out += wide ? n(43, 2) + n(8, 2) + n(0, 2) + n(16, 8) : n(42, 2) + n(8, 4);
  out += n(2, wide ? 8 : 2);
  for (const auto& [tag, value] : {std::pair{256, 7}, std::pair{274, orientation}})
    out += n(tag, 2) + n(3, 2) + n(1, many) + n(value, 2) + std::string(many - 2, '\0');
  return out + n(0, many);
}

std::string chunk(const std::string& kind, const std::string& data) {
  return number(data.size(), 4, true) + kind + data + "crc.";
}

}  // namespace

TEST_CASE("orientation: read of TIFF in both byte orders, BigTIFF, and EXIF of JPEG, PNG and WebP") {
  const raycube::testing::TestFolder folder;
  const auto of = [&](const std::string& content) {
    const std::string path = folder / "x";
    std::ofstream(path, std::ios::binary) << content;
    return image_orientation(path);
  };
  for (int orientation = 1; orientation <= 8; ++orientation) {
    for (const bool big_endian : {false, true})
      for (const bool wide : {false, true}) CHECK(of(tiff(orientation, big_endian, wide)) == orientation);
    const std::string exif = tiff(orientation, true, false);
    const std::string application = std::string("Exif\0\0", 6) + exif;
    CHECK(of("\xff\xd8\xff\xe0" + number(4, 2, true) + "ab\xff\xe1" + number(application.size() + 2, 2, true) +
             application + "\xff\xda") == orientation);
    CHECK(of("\x89PNG\r\n\x1a\n" + chunk("IHDR", "0123456789abc") + chunk("eXIf", exif) + chunk("IEND", "")) ==
          orientation);
    CHECK(of("RIFF1234WEBPVP8X" + number(10, 4, false) + "0123456789EXIF" + number(exif.size(), 4, false) + exif) ==
          orientation);
  }
  for (const std::string& none :
       {std::string(), std::string("ncols 5\n"), tiff(9, false, false), tiff(0, true, true), std::string("\xff\xd8"),
        std::string("\x89PNG\r\n\x1a\n"), tiff(6, false, false).substr(0, 12), std::string("II*\0\xff\xff\xff\xff", 8)})
    CHECK(of(none) == 1);
}

TEST_CASE("orientation: first row and first column of the file are seen where the format says") {
  constexpr std::size_t kRows = 2, kColumns = 3;
  struct Side {
    int orientation;
    const char *row, *column;
  };
  for (const auto& [orientation, row_side, column_side] :
       {Side{1, "top", "left"}, Side{2, "top", "right"}, Side{3, "bottom", "right"}, Side{4, "bottom", "left"},
        Side{5, "left", "top"}, Side{6, "right", "top"}, Side{7, "right", "bottom"}, Side{8, "left", "bottom"}}) {
    CAPTURE(orientation);
    const std::size_t seen_rows = orientation >= 5 ? kColumns : kRows,
                      seen_columns = orientation >= 5 ? kRows : kColumns;
    const auto at_side = [&](const std::string& side, std::size_t row, std::size_t column) {
      return side == "top"      ? row == 0
             : side == "bottom" ? row == seen_rows - 1
             : side == "left"   ? column == 0
                                : column == seen_columns - 1;
    };
    for (std::size_t row = 0; row < seen_rows; ++row)
      for (std::size_t column = 0; column < seen_columns; ++column) {
        const FilePixel from = file_pixel(orientation, row, column, kRows, kColumns);
        CHECK(from.row < kRows);
        CHECK(from.column < kColumns);
        CHECK((from.row == 0) == at_side(row_side, row, column));
        CHECK((from.column == 0) == at_side(column_side, row, column));
      }
  }
}
