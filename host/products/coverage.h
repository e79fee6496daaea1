// Which pixels of an image have come, where its pieces come in any order.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace raycube::products {

/// A rectangle of an image: whole lines, or `samples` of each from `first_sample` on.
struct Piece {
  std::int64_t first_line = 0, lines = 0;
  std::int64_t first_sample = 0, samples = 0;
};

class Coverage {
 public:
  /// Of an image called `name` in messages.
  Coverage(std::string name, std::int64_t samples, std::int64_t lines);

  /// Throws Error(bug) when the piece leaves the image, or some of it has come before.
  void add(const Piece& piece);
  bool whole() const { return missing_ == 0; }
  bool has(std::int64_t first_line, std::int64_t lines) const;
  /// Throws Error(bug) that names the first pixel that is missing, and how many are.
  void require_whole() const;

 private:
  using Span = std::pair<std::int64_t, std::int64_t>;  ///< first sample and the one after the last

  std::string name_;
  std::int64_t samples_, lines_;
  std::int64_t missing_;                  ///< pixels
  std::vector<std::vector<Span>> spans_;  ///< [line], in order, apart from each other
};

}  // namespace raycube::products
