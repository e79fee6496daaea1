// 8-bit PNG images.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "host/base/output_file.h"

namespace raycube::products {

/// Writes a grey (channels = 1) or RGB (3) image, row by row from the top; text becomes tEXt chunks (Latin-1).
void write_png(base::OutputFile& file, std::uint32_t width, std::uint32_t height, int channels,
               const std::vector<std::uint8_t>& pixels, const std::map<std::string, std::string>& text);

}  // namespace raycube::products
