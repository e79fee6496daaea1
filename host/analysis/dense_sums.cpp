#include "host/analysis/dense_sums.h"

#include <cstring>

namespace raycube::analysis {
namespace {

constexpr std::size_t kRows = 6, kLanes = 8;  ///< of a tile that stays in registers
static_assert(kBandPad % kRows == 0 && kBandPad % kLanes == 0);

typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));

}  // namespace

// Functions of which the linker takes the copy that fits the processor; the sanitizer's start comes too late for that.
#if defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__) && !defined(__clang__)
#define RAYCUBE_FOR_THE_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define RAYCUBE_FOR_THE_PROCESSOR
#endif

RAYCUBE_FOR_THE_PROCESSOR
void add_squares(const double* x, std::size_t pixels, std::size_t stride, double* square) {
  for (std::size_t i = 0; i < stride; i += kRows)
    for (std::size_t j = i / kLanes * kLanes; j < stride; j += kLanes) {
      Lanes sum[kRows];
      for (std::size_t r = 0; r < kRows; ++r) std::memcpy(&sum[r], square + (i + r) * stride + j, sizeof(Lanes));
      const double *row = x + i, *column = x + j;
      for (std::size_t p = 0; p < pixels; ++p, row += stride, column += stride) {
        Lanes c;
        std::memcpy(&c, column, sizeof c);
        for (std::size_t r = 0; r < kRows; ++r) sum[r] += row[r] * c;
      }
      for (std::size_t r = 0; r < kRows; ++r) std::memcpy(square + (i + r) * stride + j, &sum[r], sizeof(Lanes));
    }
}

RAYCUBE_FOR_THE_PROCESSOR
static void add_norms(const double* columns, const double* y, std::size_t pixels, std::size_t stride, double* norm) {
  for (std::size_t p = 0; p < pixels; p += kRows) {
    Lanes total[kRows] = {};
    for (std::size_t i = 0; i < stride; i += kLanes) {
      Lanes sum[kRows] = {};
      const double* column = columns + i;
      const double* row = y + p * stride;
      for (std::size_t j = 0; j < i + kLanes; ++j, column += stride) {
        Lanes c;
        std::memcpy(&c, column, sizeof c);
        for (std::size_t r = 0; r < kRows; ++r) sum[r] += row[r * stride + j] * c;
      }
      for (std::size_t r = 0; r < kRows; ++r) total[r] += sum[r] * sum[r];
    }
    for (std::size_t r = 0; r < kRows; ++r) {
      norm[p + r] = 0;
      for (std::size_t k = 0; k < kLanes; ++k) norm[p + r] += total[r][k];
    }
  }
}

RAYCUBE_FOR_THE_PROCESSOR
double squared_distance(const double* a, const double* b, std::size_t bands) {
  Lanes sum = {};
  std::size_t i = 0;
  for (; i + kLanes <= bands; i += kLanes) {
    Lanes x, y;
    std::memcpy(&x, a + i, sizeof x), std::memcpy(&y, b + i, sizeof y);
    sum += (x - y) * (x - y);
  }
  double out = 0;
  for (std::size_t k = 0; k < kLanes; ++k) out += sum[k];
  for (; i < bands; ++i) out += (a[i] - b[i]) * (a[i] - b[i]);
  return out;
}

InverseNorm::InverseNorm(const std::vector<double>& lower, std::size_t bands) : stride_(padded(bands)) {
  static_assert(kPixelTile == kRows);
  columns_.assign(stride_ * stride_, 0.0);
  for (std::size_t i = 0; i < bands; ++i)
    for (std::size_t j = 0; j <= i; ++j) columns_[j * stride_ + i] = lower[i * bands + j];
}

void InverseNorm::norms(const double* y, std::size_t pixels, double* norm) const {
  add_norms(columns_.data(), y, pixels, stride_, norm);
}

}  // namespace raycube::analysis
