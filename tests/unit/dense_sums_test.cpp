// The sums of the analyses by every kind of instructions that this processor has: the same bits, and those of sums
// written out with one rounding a step.
#include "host/analysis/dense_sums.h"

#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <vector>

using namespace raycube::analysis;

namespace {

constexpr std::size_t kPixels = 18;

/// [pixel][padded], zero from bands on.
std::vector<double> numbers(std::size_t bands, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.3, 1);
  std::vector<double> out(kPixels * padded(bands), 0.0);
  for (std::size_t p = 0; p < kPixels; ++p)
    for (std::size_t b = 0; b < bands; ++b) out[p * padded(bands) + b] = normal(random);
  return out;
}

}  // namespace

TEST_CASE("S49 squares are the same bits by all instructions, and those of fma one by one") {
  for (const std::size_t bands : {1, 5, 8, 23, 24, 25, 61, 100}) {
    CAPTURE(bands);
    const std::size_t stride = padded(bands);
    const std::vector<double> x = numbers(bands, 7);
    std::vector<double> expected(stride * stride, 0.0);
    for (std::size_t i = 0; i < bands; ++i)
      for (std::size_t j = i; j < bands; ++j)
        for (std::size_t p = 0; p < kPixels; ++p)
          expected[i * stride + j] = std::fma(x[p * stride + i], x[p * stride + j], expected[i * stride + j]);
    for (const Instructions by : known_instructions()) {
      CAPTURE(static_cast<int>(by));
      std::vector<double> square(stride * stride, 0.0);
      add_squares(x.data(), kPixels, stride, square.data(), by);
      for (std::size_t i = 0; i < bands; ++i)
        for (std::size_t j = i; j < bands; ++j) REQUIRE(square[i * stride + j] == expected[i * stride + j]);
    }
  }
}

TEST_CASE("S53 norms and distances are the same bits by all instructions") {
  for (const std::size_t bands : {1, 7, 24, 50, 77}) {
    CAPTURE(bands);
    const std::size_t stride = padded(bands);
    const std::vector<double> y = numbers(bands, 11), w = numbers(bands * bands / 18 + 18, 13);
    std::vector<double> lower(bands * bands, 0.0);
    for (std::size_t i = 0; i < bands; ++i)
      for (std::size_t j = 0; j <= i; ++j) lower[i * bands + j] = w[(i * bands + j) % w.size()];
    const InverseNorm inverse(lower, bands);
    std::vector<double> first(kPixels);
    inverse.norms(y.data(), kPixels, first.data(), Instructions::plain);
    for (std::size_t p = 0; p < kPixels; ++p) {
      double norm = 0;
      for (std::size_t i = 0; i < bands; ++i) {
        double row = 0;
        for (std::size_t j = 0; j <= i; ++j) row += lower[i * bands + j] * y[p * stride + j];
        norm += row * row;
      }
      CHECK(first[p] == doctest::Approx(norm).epsilon(1e-13));
    }
    for (const Instructions by : known_instructions()) {
      std::vector<double> norm(kPixels);
      inverse.norms(y.data(), kPixels, norm.data(), by);
      CHECK(norm == first);
      const std::vector<float> floats(y.begin(), y.end());
      const std::vector<double> same(floats.begin(), floats.end());
      for (std::size_t p = 1; p < kPixels; ++p) {
        const double apart = squared_distance(y.data(), y.data() + p * stride, bands, Instructions::plain);
        CHECK(squared_distance(y.data(), y.data() + p * stride, bands, by) == apart);
        double sum = 0;
        for (std::size_t b = 0; b < bands; ++b) sum += std::pow(y[b] - y[p * stride + b], 2);
        CHECK(apart == doctest::Approx(sum).epsilon(1e-13));
        CHECK(squared_distance(floats.data() + p * stride, y.data(), bands, by) ==
              squared_distance(same.data() + p * stride, y.data(), bands, by));
      }
    }
  }
}
