#include "scene_compiler/texel_cut.h"

#include <algorithm>
#include <cmath>

namespace raycube::scene {
namespace {

using Piece = std::vector<ImageCorner>;

std::array<double, 2> range(const std::array<ImageCorner, 3>& triangle, std::size_t axis) {
  const auto [low, high] =
      std::minmax({triangle[0].in_image[axis], triangle[1].in_image[axis], triangle[2].in_image[axis]});
  return {low, high};
}

/// Ends of the cells along one axis: the triangle's own, and the texels' edges between.
std::vector<double> cell_ends(const std::array<ImageCorner, 3>& triangle, const TexelCounts& counts, std::size_t axis) {
  const auto [low, high] = range(triangle, axis);
  std::vector<double> out{low, high};
  for (const int count : counts[axis])
    for (double k = std::floor(low * count) + 1; k / count < high; ++k)
      if (k / count > low) out.push_back(k / count);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin() + 1, out.end()), out.end());  // one cell where the range is a point
  if (out.size() < 2) out.push_back(high);
  return out;
}

/// The part of a convex piece on one side of a line, sign 1: from it on, -1: up to it (Sutherland & Hodgman, Commun.
/// ACM 17(1), 1974).
Piece clipped(const Piece& piece, std::size_t axis, double line, double sign) {
  Piece out;
  for (std::size_t i = 0; i < piece.size(); ++i) {
    const ImageCorner &a = piece[i], &b = piece[(i + 1) % piece.size()];
    const double beyond_a = sign * (a.in_image[axis] - line), beyond_b = sign * (b.in_image[axis] - line);
    if (beyond_a >= 0) out.push_back(a);
    if (!(beyond_a < 0 && beyond_b > 0) && !(beyond_a > 0 && beyond_b < 0)) continue;
    const double part = beyond_a / (beyond_a - beyond_b);
    ImageCorner& on = out.emplace_back();
    for (std::size_t k = 0; k < 3; ++k) on.position[k] = a.position[k] + part * (b.position[k] - a.position[k]);
    on.in_image[1 - axis] = a.in_image[1 - axis] + part * (b.in_image[1 - axis] - a.in_image[1 - axis]);
    on.in_image[axis] = line;
  }
  return out;
}

class Cutter {
 public:
  Cutter(std::array<std::vector<double>, 2> ends, bool join, const std::function<std::uint32_t(double, double)>& of,
         const std::function<void(const Piece&, std::uint32_t)>& take)
      : ends_(std::move(ends)), join_(join), of_(of), take_(take) {}

  /// Cells first .. last - 1 of each axis, which the piece lies in.
  void cut(const Piece& piece, std::array<std::size_t, 2> first, std::array<std::size_t, 2> last) const {
    if (piece.size() < 3) return;
    const std::size_t axis = last[0] - first[0] >= last[1] - first[1] ? 0 : 1, cells = last[axis] - first[axis];
    if (cells == 1 || (join_ && alike(first, last))) {
      take_(piece, number(first[0], first[1]));
      return;
    }
    const std::size_t middle = first[axis] + cells / 2;
    auto low_last = last, high_first = first;
    low_last[axis] = high_first[axis] = middle;
    cut(clipped(piece, axis, ends_[axis][middle], -1), first, low_last);
    cut(clipped(piece, axis, ends_[axis][middle], 1), high_first, last);
  }

 private:
  std::uint32_t number(std::size_t i, std::size_t j) const {
    return of_(0.5 * (ends_[0][i] + ends_[0][i + 1]), 0.5 * (ends_[1][j] + ends_[1][j + 1]));
  }
  bool alike(std::array<std::size_t, 2> first, std::array<std::size_t, 2> last) const {
    const std::uint32_t one = number(first[0], first[1]);
    for (std::size_t j = first[1]; j < last[1]; ++j)
      for (std::size_t i = first[0]; i < last[0]; ++i)
        if (number(i, j) != one) return false;
    return true;
  }

  std::array<std::vector<double>, 2> ends_;
  bool join_;
  const std::function<std::uint32_t(double, double)>& of_;
  const std::function<void(const Piece&, std::uint32_t)>& take_;
};

}  // namespace

double texel_cells(const std::array<ImageCorner, 3>& triangle, const TexelCounts& counts) {
  double cells = 1;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    const auto [low, high] = range(triangle, axis);
    double along = 1;
    for (const int count : counts[axis]) along += (high - low) * count;
    cells *= along;
  }
  return cells;
}

void cut_by_texels(const std::array<ImageCorner, 3>& triangle, const TexelCounts& counts, bool join,
                   const std::function<std::uint32_t(double u, double v)>& of,
                   const std::function<void(const std::vector<ImageCorner>& piece, std::uint32_t number)>& take) {
  const std::array<std::vector<double>, 2> ends{cell_ends(triangle, counts, 0), cell_ends(triangle, counts, 1)};
  const std::array<std::size_t, 2> last{ends[0].size() - 1, ends[1].size() - 1};
  Cutter(ends, join, of, take).cut({triangle.begin(), triangle.end()}, {0, 0}, last);
}

}  // namespace raycube::scene
