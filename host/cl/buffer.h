// Typed device memory. Every access is checked against the size before the driver sees it.
#pragma once

#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "host/cl/context.h"

namespace raycube::cl {

enum class Access { read_only, write_only, read_write };  ///< as kernels see it

/// Untyped part of Buffer.
class RawBuffer {
 public:
  RawBuffer(const Context& context, std::size_t bytes, Access access, const std::string& what);
  std::size_t bytes() const { return bytes_; }
  cl_mem operator()() const { return memory_(); }

 protected:
  void write(const void* from, std::size_t bytes, std::size_t offset);
  void read(void* to, std::size_t bytes, std::size_t offset) const;
  void* map(bool for_writing);
  void unmap(void* mapped);

 private:
  const Context* context_;
  std::size_t bytes_;
  std::string what_;
  Handle<cl_mem, clReleaseMemObject> memory_;
};

/// `count` elements of T on the device. `what` names the contents in errors ("hits of a tile"). A count of 0 allocates
/// one element, since OpenCL knows no empty buffer. Blocking calls; the context must outlive the buffer.
template <typename T>
class Buffer : public RawBuffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  Buffer(const Context& context, std::size_t count, Access access, const std::string& what)
      : RawBuffer(context, (count ? count : 1) * sizeof(T), access, what), count_(count) {}
  /// Allocates and fills.
  Buffer(const Context& context, std::span<const T> from, Access access, const std::string& what)
      : Buffer(context, from.size(), access, what) {
    write(from);
  }
  std::size_t size() const { return count_; }
  void write(std::span<const T> from, std::size_t first = 0) {
    if (!from.empty()) RawBuffer::write(from.data(), from.size_bytes(), first * sizeof(T));
  }
  void read(std::span<T> to, std::size_t first = 0) const {
    if (!to.empty()) RawBuffer::read(to.data(), to.size_bytes(), first * sizeof(T));
  }
  std::vector<T> read_all() const {
    std::vector<T> all(count_);
    read(all);
    return all;
  }
  /// Maps the whole buffer (no copy on CPU devices), waiting for what is enqueued; unmap before kernels use it again.
  std::span<T> map(bool for_writing) { return {static_cast<T*>(RawBuffer::map(for_writing)), count_}; }
  void unmap(std::span<T> mapped) { RawBuffer::unmap(mapped.data()); }

 private:
  std::size_t count_;
};

}  // namespace raycube::cl
