// Device buffers read where they lie, without a copy on the host.
#pragma once

#include <span>

#include "host/base/error.h"
#include "host/cl/buffer.h"
#include "host/cl/context.h"

namespace raycube::render {

/// A buffer's numbers where they lie, as long as this lives.
template <class T>
class Mapped {
 public:
  explicit Mapped(cl::Buffer<T>& buffer) : buffer_(buffer), span_(buffer.map(false)) {}
  ~Mapped() {
    try {
      buffer_.unmap(span_);
    } catch (const base::Error&) {  // the device is gone: the next call tells
    }
  }
  Mapped(const Mapped&) = delete;
  Mapped& operator=(const Mapped&) = delete;
  const T* data() const { return span_.data(); }

 private:
  cl::Buffer<T>& buffer_;
  std::span<T> span_;
};

/// Waits for unmappings: one still under way when a renderer goes away can crash PoCL.
struct Settled {
  const cl::Context& context;
  ~Settled() {
    try {
      context.finish();
    } catch (const base::Error&) {  // the device is gone: the next call tells
    }
  }
};

}  // namespace raycube::render
