// The two sums that analyses of whole cubes spend their time in, in double, by vector instructions that the processor
// has. Each entry is summed in the order of its pixels, multiplied and added apart, so that every processor finds the
// same bits.
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::analysis {

/// Bands are padded with zeros to a multiple of this.
inline constexpr std::size_t kBandPad = 24;
inline constexpr std::size_t padded(std::size_t bands) { return (bands + kBandPad - 1) / kBandPad * kBandPad; }

/// Pixels that are worked on at once: what a core's second cache holds of some hundred bands.
inline constexpr std::size_t kPixelsAtOnce = 96;

/// square[i][j] += sum over pixels of x[p][i] x[p][j], for j from the tile of i on (the upper triangle, and what tiles
/// of it hold besides). x: [pixels][stride]; square: [stride][stride]; stride: padded().
void add_squares(const double* x, std::size_t pixels, std::size_t stride, double* square);

/// sum over bands of (a - b)^2, in eight sums that are then added.
double squared_distance(const double* a, const double* b, std::size_t bands);

/// A symmetric positive matrix's inverse as |W y|^2: y' M^-1 y of many y.
class InverseNorm {
 public:
  /// lower: [bands][bands] row-major, the lower triangular inverse of M's Cholesky factor.
  InverseNorm(const std::vector<double>& lower, std::size_t bands);
  std::size_t stride() const { return stride_; }
  /// norm[p] = |W y_p|^2; y: [pixels][stride()], zero from bands on; pixels: a multiple of kPixelTile.
  void norms(const double* y, std::size_t pixels, double* norm) const;
  static constexpr std::size_t kPixelTile = 6;
  static_assert(kPixelsAtOnce % kPixelTile == 0);

 private:
  std::size_t stride_;
  std::vector<double> columns_;  ///< W transposed: [j][i]
};

}  // namespace raycube::analysis
