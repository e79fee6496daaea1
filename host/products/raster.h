// An RGB image in memory with just enough drawing for charts that need no other program: boxes and small letters.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace raycube::products {

using Colour = std::array<std::uint8_t, 3>;

/// Letters are 5 x 7 dots, 6 dots apart; a dot is `scale` pixels.
inline constexpr int kLetterAdvance = 6, kLetterHeight = 7;

class Raster {
 public:
  Raster(int width, int height, const Colour& background);

  int width() const { return width_; }
  int height() const { return height_; }
  const std::vector<std::uint8_t>& rgb() const { return rgb_; }

  /// What lies outside the image is left out.
  void fill(int x, int y, int width, int height, const Colour& colour);
  /// Upper left corner of the first letter. Digits, English letters and " ()+,-./:=<>%"; any other character becomes a
  /// box.
  void text(int x, int y, const std::string& text, int scale, const Colour& colour);

  static int text_width(const std::string& text, int scale) {
    return static_cast<int>(text.size()) * kLetterAdvance * scale;
  }

 private:
  int width_, height_;
  std::vector<std::uint8_t> rgb_;
};

}  // namespace raycube::products
