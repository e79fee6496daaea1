#include "host/analysis/dense_sums.h"

#include <cmath>
#include <cstring>

// This file alone is compiled so that a product and a sum become one fma where the function's instructions have it.
namespace raycube::analysis {
namespace {

constexpr std::size_t kRows = 6, kLanes = 8;  ///< of a tile that stays in registers
static_assert(kBandPad % kRows == 0 && kBandPad % kLanes == 0);
static_assert(InverseNorm::kPixelTile == kRows);

typedef double Lanes __attribute__((vector_size(kLanes * sizeof(double))));

#define RAYCUBE_BODY static inline __attribute__((always_inline))

/// sum + a b, of eight, with one rounding.
struct Contracted {
  RAYCUBE_BODY void add(Lanes& sum, double a, const Lanes& b) { sum += a * b; }
  RAYCUBE_BODY void add(Lanes& sum, const Lanes& a, const Lanes& b) { sum += a * b; }
};
struct Called {
  RAYCUBE_BODY void add(Lanes& sum, double a, const Lanes& b) {
    for (std::size_t k = 0; k < kLanes; ++k) sum[k] = std::fma(a, b[k], sum[k]);
  }
  RAYCUBE_BODY void add(Lanes& sum, const Lanes& a, const Lanes& b) {
    for (std::size_t k = 0; k < kLanes; ++k) sum[k] = std::fma(a[k], b[k], sum[k]);
  }
};

template <class Fused>
RAYCUBE_BODY void squares(const double* x, std::size_t pixels, std::size_t stride, double* square) {
  for (std::size_t i = 0; i < stride; i += kRows)
    for (std::size_t j = i / kLanes * kLanes; j < stride; j += kLanes) {
      Lanes sum[kRows];
      for (std::size_t r = 0; r < kRows; ++r) std::memcpy(&sum[r], square + (i + r) * stride + j, sizeof(Lanes));
      const double *row = x + i, *column = x + j;
      for (std::size_t p = 0; p < pixels; ++p, row += stride, column += stride) {
        Lanes c;
        std::memcpy(&c, column, sizeof c);
        for (std::size_t r = 0; r < kRows; ++r) Fused::add(sum[r], row[r], c);
      }
      for (std::size_t r = 0; r < kRows; ++r) std::memcpy(square + (i + r) * stride + j, &sum[r], sizeof(Lanes));
    }
}

template <class Fused>
RAYCUBE_BODY void inverse_norms(const double* columns, const double* y, std::size_t pixels, std::size_t stride,
                                double* norm) {
  for (std::size_t p = 0; p < pixels; p += kRows) {
    Lanes total[kRows] = {};
    for (std::size_t i = 0; i < stride; i += kLanes) {
      Lanes sum[kRows] = {};
      const double *column = columns + i, *row = y + p * stride;
      for (std::size_t j = 0; j < i + kLanes; ++j, column += stride) {
        Lanes c;
        std::memcpy(&c, column, sizeof c);
        for (std::size_t r = 0; r < kRows; ++r) Fused::add(sum[r], row[r * stride + j], c);
      }
      for (std::size_t r = 0; r < kRows; ++r) Fused::add(total[r], sum[r], sum[r]);
    }
    for (std::size_t r = 0; r < kRows; ++r) {
      norm[p + r] = 0;
      for (std::size_t k = 0; k < kLanes; ++k) norm[p + r] += total[r][k];
    }
  }
}

typedef float Floats __attribute__((vector_size(kLanes * sizeof(float))));

RAYCUBE_BODY void load(const double* from, Lanes& to) { std::memcpy(&to, from, sizeof to); }
RAYCUBE_BODY void load(const float* from, Lanes& to) {
  Floats floats;
  std::memcpy(&floats, from, sizeof floats);
  to = __builtin_convertvector(floats, Lanes);
}

template <class Fused, class Number>
RAYCUBE_BODY double distance(const Number* a, const double* b, std::size_t bands) {
  Lanes sum = {};
  std::size_t i = 0;
  for (; i + kLanes <= bands; i += kLanes) {
    Lanes x, y;
    load(a + i, x), load(b + i, y);
    const Lanes off = x - y;
    Fused::add(sum, off, off);
  }
  double out = 0;
  for (std::size_t k = 0; k < kLanes; ++k) out += sum[k];
  for (; i < bands; ++i) {
    const double off = static_cast<double>(a[i]) - b[i];
    out = std::fma(off, off, out);
  }
  return out;
}

#if defined(__x86_64__)
__attribute__((target("avx512f"))) void squares_avx512(const double* x, std::size_t n, std::size_t stride, double* s) {
  squares<Contracted>(x, n, stride, s);
}
__attribute__((target("avx2,fma"))) void squares_avx2(const double* x, std::size_t n, std::size_t stride, double* s) {
  squares<Contracted>(x, n, stride, s);
}
__attribute__((target("avx512f"))) void norms_avx512(const double* w, const double* y, std::size_t n,
                                                     std::size_t stride, double* norm) {
  inverse_norms<Contracted>(w, y, n, stride, norm);
}
__attribute__((target("avx2,fma"))) void norms_avx2(const double* w, const double* y, std::size_t n, std::size_t stride,
                                                    double* norm) {
  inverse_norms<Contracted>(w, y, n, stride, norm);
}
template <class Number>
__attribute__((target("avx512f"))) double distance_avx512(const Number* a, const double* b, std::size_t bands) {
  return distance<Contracted>(a, b, bands);
}
template <class Number>
__attribute__((target("avx2,fma"))) double distance_avx2(const Number* a, const double* b, std::size_t bands) {
  return distance<Contracted>(a, b, bands);
}
#endif

}  // namespace

std::vector<Instructions> known_instructions() {
  std::vector<Instructions> out = {Instructions::plain};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) out.push_back(Instructions::avx2);
  if (__builtin_cpu_supports("avx512f")) out.push_back(Instructions::avx512);
#endif
  return out;
}

Instructions best_instructions() {
  static const Instructions best = known_instructions().back();
  return best;
}

void add_squares(const double* x, std::size_t pixels, std::size_t stride, double* square, Instructions by) {
#if defined(__x86_64__)
  if (by == Instructions::avx512) return squares_avx512(x, pixels, stride, square);
  if (by == Instructions::avx2) return squares_avx2(x, pixels, stride, square);
#endif
  squares<Called>(x, pixels, stride, square);
}

template <class Number>
static double distance_by(const Number* a, const double* b, std::size_t bands, Instructions by) {
#if defined(__x86_64__)
  if (by == Instructions::avx512) return distance_avx512(a, b, bands);
  if (by == Instructions::avx2) return distance_avx2(a, b, bands);
#endif
  return distance<Called>(a, b, bands);
}
double squared_distance(const double* a, const double* b, std::size_t bands, Instructions by) {
  return distance_by(a, b, bands, by);
}
double squared_distance(const float* a, const double* b, std::size_t bands, Instructions by) {
  return distance_by(a, b, bands, by);
}

void add_signed(const float* a, double sign, std::size_t bands, double* sum) {
  for (std::size_t b = 0; b < bands; ++b) sum[b] += sign * static_cast<double>(a[b]);
}
void add_signed(const double* a, double sign, std::size_t bands, double* sum) {
  for (std::size_t b = 0; b < bands; ++b) sum[b] += sign * a[b];
}

InverseNorm::InverseNorm(const std::vector<double>& lower, std::size_t bands) : stride_(padded(bands)) {
  columns_.assign(stride_ * stride_, 0.0);
  for (std::size_t i = 0; i < bands; ++i)
    for (std::size_t j = 0; j <= i; ++j) columns_[j * stride_ + i] = lower[i * bands + j];
}

void InverseNorm::norms(const double* y, std::size_t pixels, double* norm, Instructions by) const {
#if defined(__x86_64__)
  if (by == Instructions::avx512) return norms_avx512(columns_.data(), y, pixels, stride_, norm);
  if (by == Instructions::avx2) return norms_avx2(columns_.data(), y, pixels, stride_, norm);
#endif
  inverse_norms<Called>(columns_.data(), y, pixels, stride_, norm);
}

}  // namespace raycube::analysis
