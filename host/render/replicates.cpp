#include "host/render/replicates.h"

#include <algorithm>

#include "host/render/truth.h"

namespace raycube::render {

std::uint64_t replicate_seed(std::uint64_t seed, int replicate) {
  constexpr std::uint64_t kStep = 0x85ebca6bu;  // kernels take 32 bits of a seed; trials step by others
  return seed + kStep * static_cast<std::uint64_t>(replicate);
}

void ReplicateSpread::add(const ReplicateSpread& other) {
  pixels += other.pixels;
  for (auto list : {&ReplicateSpread::radiance, &ReplicateSpread::square, &ReplicateSpread::noise}) {
    auto& sums = this->*list;
    const auto& more = other.*list;
    sums.resize(std::max(sums.size(), more.size()));
    for (std::size_t b = 0; b < more.size(); ++b) sums[b] += more[b];
  }
}

ReplicateSums::ReplicateSums(std::size_t pixels, std::size_t bands, std::size_t materials, std::size_t shares)
    : pixels_(pixels),
      bands_(bands),
      materials_(materials),
      shares_(shares),
      layers_(truth::abundance + shares),
      radiance_(pixels * bands),
      square_(pixels * bands),
      truth_(pixels * layers_) {}

void ReplicateSums::add(std::size_t first_pixel, std::size_t pixels, const float* radiance, const float* truth,
                        std::size_t layers) {
  double *sum = radiance_.data() + first_pixel * bands_, *square = square_.data() + first_pixel * bands_;
  for (std::size_t i = 0; i < pixels * bands_; ++i) {
    const double x = radiance[i];
    sum[i] += x, square[i] += x * x;
  }
  for (std::size_t p = 0; p < pixels; ++p)
    add_truth(truth + p * layers, shares_, truth_.data() + (first_pixel + p) * layers_);
}

void ReplicateSums::mean(std::size_t first_pixel, std::size_t pixels, float* radiance, float* truth,
                         std::size_t layers) const {
  for (std::size_t i = 0; i < pixels * bands_; ++i)
    radiance[i] = static_cast<float>(radiance_[first_pixel * bands_ + i] / count_);
  for (std::size_t p = 0; p < pixels; ++p)
    mean_truth(truth_.data() + (first_pixel + p) * layers_, count_, materials_, shares_, truth + p * layers);
}

ReplicateSpread ReplicateSums::spread(std::size_t bands) const {
  ReplicateSpread out{static_cast<double>(pixels_), std::vector<double>(bands), std::vector<double>(bands),
                      std::vector<double>(bands)};
  const double n = count_;
  for (std::size_t p = 0; p < pixels_; ++p)
    for (std::size_t b = 0; b < bands; ++b) {
      const double sum = radiance_[p * bands_ + b];
      const double square = std::max(0.0, square_[p * bands_ + b] - sum * sum / n) / (n * (n - 1));
      out.radiance[b] += sum / n;
      out.square[b] += square;
      out.noise[b] += square * square * 2 / (n + 1);
    }
  return out;
}

}  // namespace raycube::render
