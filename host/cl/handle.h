// One owner per OpenCL handle: movable, released once, never throws on destruction.
#pragma once

#include <CL/cl.h>

#include <utility>

namespace raycube::cl {

template <typename Raw, cl_int(CL_API_CALL* Release)(Raw)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(Raw raw) : raw_(raw) {}
  Handle(Handle&& other) noexcept : raw_(std::exchange(other.raw_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(raw_, other.raw_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (raw_) Release(raw_);
  }
  Raw operator()() const { return raw_; }
  explicit operator bool() const { return raw_ != nullptr; }

 private:
  Raw raw_ = nullptr;
};

}  // namespace raycube::cl
