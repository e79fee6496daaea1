// A loop over independent items on several threads, and one thing beside another.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <future>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "host/base/interrupt.h"

namespace raycube::base {

/// work(own[t], i) for every i below `count`, in any order, on as many threads as there are `own`, each thread t with
/// its own. Where the machine starts no more threads, those there are go on. The first exception stops the loop and is
/// thrown here, and so does a signal: Error(interrupted).
template <class Own, class Work>
void for_each_index_with(std::vector<Own>& own, std::size_t count, const Work& work) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto run = [&](std::size_t thread) {
    for (std::size_t i; (i = next++) < count;) {
      try {
        throw_if_interrupted();
        work(own[thread], i);
      } catch (...) {
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
        next = count;
      }
    }
  };
  std::vector<std::thread> others;
  others.reserve(std::min(own.size(), count));
  try {
    for (std::size_t t = 1; t < std::min(own.size(), count); ++t) others.emplace_back(run, t);
  } catch (const std::system_error&) {
  }
  run(0);
  for (std::thread& thread : others) thread.join();
  if (failure) std::rethrow_exception(failure);
}

/// Threads that `threads` asks for; 0: as many as the machine has.
inline std::size_t thread_count(int threads) {
  return threads > 0 ? static_cast<std::size_t>(threads)
                     : std::max<std::size_t>(1, std::thread::hardware_concurrency());
}

/// work(i) for every i below `count`, on `threads` threads (0: as many as the machine has), as for_each_index_with.
template <class Work>
void for_each_index(std::size_t count, int threads, const Work& work) {
  struct Nothing {};
  std::vector<Nothing> own(thread_count(threads));
  for_each_index_with(own, count, [&](Nothing&, std::size_t i) { work(i); });
}

/// The future of work(), done on a thread of its own; with one thread, or where the machine starts no more, when it is
/// asked for. The future must be asked: its end alone does not run work that waits for that.
template <class Work>
auto beside(int threads, Work work) {
  if (threads != 1) try {
      return std::async(std::launch::async, work);
    } catch (const std::system_error&) {
    }
  return std::async(std::launch::deferred, std::move(work));
}

}  // namespace raycube::base
