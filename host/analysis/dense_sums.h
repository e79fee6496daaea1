// The sums that analyses of whole cubes spend their time in, in double, by the vector instructions that the processor
// has. Each entry is summed in the order of its pixels, multiplied and added with one rounding (fma), so that every
// processor finds the same bits; one without such an instruction, by a function, takes far longer.
#pragma once

#include <cstddef>
#include <vector>

namespace raycube::analysis {

/// Bands are padded with zeros to a multiple of this.
inline constexpr std::size_t kBandPad = 24;
inline constexpr std::size_t padded(std::size_t bands) { return (bands + kBandPad - 1) / kBandPad * kBandPad; }

/// Pixels that are worked on at once: what a core's second cache holds of some hundred bands.
inline constexpr std::size_t kPixelsAtOnce = 96;

/// Instructions that the sums are made of, in rising order.
enum class Instructions { plain, avx2, avx512 };
/// Those that this processor has.
std::vector<Instructions> known_instructions();
/// The last of them.
Instructions best_instructions();

/// square[i][j] += sum over pixels of x[p][i] x[p][j], for j from the tile of i on (the upper triangle, and what tiles
/// of it hold besides). x: [pixels][stride]; square: [stride][stride]; stride: padded().
void add_squares(const double* x, std::size_t pixels, std::size_t stride, double* square,
                 Instructions by = best_instructions());

/// sum over bands of (a - b)^2, in eight sums that are then added, and the bands past a multiple of eight; floats as
/// the doubles that they are.
double squared_distance(const double* a, const double* b, std::size_t bands, Instructions by = best_instructions());
double squared_distance(const float* a, const double* b, std::size_t bands, Instructions by = best_instructions());

/// sum[b] += sign a[b].
void add_signed(const float* a, double sign, std::size_t bands, double* sum);
void add_signed(const double* a, double sign, std::size_t bands, double* sum);

/// A symmetric positive matrix's inverse as |W y|^2: y' M^-1 y of many y.
class InverseNorm {
 public:
  /// lower: [bands][bands] row-major, the lower triangular inverse of M's Cholesky factor.
  InverseNorm(const std::vector<double>& lower, std::size_t bands);
  std::size_t stride() const { return stride_; }
  /// norm[p] = |W y_p|^2; y: [pixels][stride()], zero from bands on; pixels: a multiple of kPixelTile.
  void norms(const double* y, std::size_t pixels, double* norm, Instructions by = best_instructions()) const;
  static constexpr std::size_t kPixelTile = 6;
  static_assert(kPixelsAtOnce % kPixelTile == 0);

 private:
  std::size_t stride_;
  std::vector<double> columns_;  ///< W transposed: [j][i]
};

}  // namespace raycube::analysis
