// How pictures say that they are to be turned before they are looked at, which GDAL passes over.
#pragma once

#include <string>

namespace raycube::base {

/// The orientation that a TIFF or the EXIF data of a JPEG, PNG or WebP file declares (tag 274, TIFF 6.0 page 36; Exif
/// 2.32): 1: rows and columns stand as they are seen; 2 to 4: mirrored, turned by half a turn, flipped; 5 to 8: rows
/// are seen as columns. 1 where the file declares none.
int image_orientation(const std::string& path);

/// Row and column in the file of what is seen in a row and a column of the picture. rows, columns: of the file.
struct FilePixel {
  std::size_t row, column;
};
FilePixel file_pixel(int orientation, std::size_t seen_row, std::size_t seen_column, std::size_t rows,
                     std::size_t columns);

/// "turned by a quarter to the right (6)".
std::string orientation_text(int orientation);

}  // namespace raycube::base
