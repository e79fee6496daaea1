// What a picture holds: OpenEXR by its own library, PNG, JPEG and TIFF by GDAL.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/products/cube_statistics.h"

namespace raycube::products {

struct PictureChannel {
  std::string name;  ///< "incidence.deg", "Red"
  std::string type;  ///< as the file stores it: "half", "float", "Byte"
  std::optional<BandStatistics> statistics;
};

/// One part of a multi-part OpenEXR; of any other picture all of it.
struct PicturePart {
  std::string name;  ///< empty: the file gives none
  std::int64_t width = 0, height = 0;
  std::string compression;  ///< empty: not told
  std::vector<PictureChannel> channels;
  std::map<std::string, std::string> texts;  ///< attributes, or the PNG's text chunks
};

struct Picture {
  std::string format;  ///< "OpenEXR", "Portable Network Graphics"
  std::vector<PicturePart> parts;
  /// Corner and steps on a map, as GDAL has them: x = t0 + t1 column + t2 row, y = t3 + t4 column + t5 row.
  std::optional<std::array<double, 6>> transform;
};

/// Whether the file's first bytes are those of such a picture, or its name an OpenEXR's.
bool is_picture(const std::string& path);

/// Everything of it; of a header alone no statistics, and none of parts that are deep, or of channels with fewer
/// samples than pixels. after_lines: told of each lot of lines that was read. Throws Error(input) where the file is
/// damaged.
Picture read_picture(const std::string& path, bool header_only,
                     const std::function<void(std::int64_t lines)>& after_lines = {});

}  // namespace raycube::products
