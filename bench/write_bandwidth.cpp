#include "bench/write_bandwidth.h"

#include <thread>
#include <vector>

namespace raycube::bench {

using Float16 = float __attribute__((vector_size(64)));

void fill16(float* buffer, std::size_t count, float value, int threads) {
  const auto fill = [=](std::size_t begin, std::size_t end) {
    const Float16 v = Float16{} + value;
    auto* out = reinterpret_cast<Float16*>(buffer);
    for (std::size_t i = begin; i < end; ++i) out[i] = v;
  };
  const std::size_t vectors = count / 16;
  std::vector<std::jthread> workers;
  for (int t = 0; t < threads; ++t)
    workers.emplace_back(fill, vectors * static_cast<std::size_t>(t) / static_cast<std::size_t>(threads),
                         vectors * static_cast<std::size_t>(t + 1) / static_cast<std::size_t>(threads));
}

}  // namespace raycube::bench
