// Work in pieces that threads take in turn, as the OpenCL runtime does.
#pragma once

#include <immintrin.h>

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace raycube::bench {

template <typename Work>
void in_parallel(std::size_t count, std::size_t piece, int threads, const Work& work) {
  std::atomic<std::size_t> next{0};
  const auto run = [&] {
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);  // as Embree's manual asks
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    for (std::size_t begin; (begin = next.fetch_add(piece)) < count;) work(begin, std::min(begin + piece, count));
  };
  std::vector<std::jthread> workers;
  for (int i = 0; i < threads; ++i) workers.emplace_back(run);
}

}  // namespace raycube::bench
