// Lines of an image that come in any order and in pieces, for those who must see them in order: a digest, a picture, a
// format that is a stream. What comes as the next whole lines is handed on as it comes; the rest follows when the image
// is whole, read back from where it was written.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>

#include "host/products/coverage.h"

namespace raycube::products {

class InOrder {
 public:
  InOrder(std::int64_t samples, std::int64_t lines) : samples_(samples), lines_(lines) {}

  /// Whether these lines are the next ones; if so the caller hands them on.
  bool takes(const Piece& piece) {
    if (piece.first_line != next_line_ || piece.first_sample != 0 || piece.samples != samples_) return false;
    next_line_ += piece.lines;
    return true;
  }
  /// The lines that did not come in order, a few at a time.
  void rest(std::int64_t lines_each, const std::function<void(std::int64_t first_line, std::int64_t lines)>& read) {
    for (; next_line_ < lines_; next_line_ += lines_each) read(next_line_, std::min(lines_each, lines_ - next_line_));
  }

 private:
  std::int64_t samples_, lines_, next_line_ = 0;
};

}  // namespace raycube::products
