// A picture of a cube for people: one or three bands, each stretched linearly from its 2nd to its 98th percentile.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/base/output_file.h"
#include "host/products/envi_writer.h"

namespace raycube::products {

/// Bands nearest to 0.65, 0.55 and 0.45 um where the range holds them all; else those at 5/6, 1/2 and 1/6 of the range;
/// one band when there are fewer than three. 0-based, red first.
std::vector<int> default_quicklook_bands(const std::vector<double>& wavelength_um);

class Quicklook {
 public:
  struct Stretch {
    int band = 0;              ///< 0-based
    double low = 0, high = 0;  ///< values shown black and full, in the cube's unit
  };

  /// One (grey) or three (RGB) 0-based bands. Images above 2^20 pixels are averaged over squares, so memory is bounded;
  /// each pixel of a small one is shown as a square, so that its longer side has about 512.
  Quicklook(std::int64_t samples, std::int64_t lines, std::vector<int> bands);
  /// Next lines of the cube, in line order; the strip must state its pixel stride.
  void add(const Strip& strip);
  /// Stretches and writes the PNG; its tEXt chunk "Description" says bands, limits, averaging and squares.
  /// `band_text[i]` names band i of the constructor ("650 nm").
  std::vector<Stretch> write(base::OutputFile& file, const std::vector<std::string>& band_text) const;

  int averaged_over() const { return step_; }  ///< side of the averaged squares, pixels
  int enlarged_by() const;                     ///< side of the square that each pixel is shown as

 private:
  std::int64_t samples_, lines_, width_, height_, next_line_ = 0;
  int step_ = 1;
  std::vector<int> bands_;
  std::vector<float> sum_;  ///< [y][x][channel]
  std::vector<std::uint16_t> count_;
};

}  // namespace raycube::products
