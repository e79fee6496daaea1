// A context with one in-order queue on one device. Several can live side by side.
#pragma once

#include "host/cl/device.h"

namespace raycube::cl {

class Kernel;

/// Device, context and in-order profiling queue. Buffers, programs and kernels made from it must not outlive it.
class Context {
 public:
  explicit Context(Device device);
  Context(const Context&) = delete;  // buffers point to it
  Context& operator=(const Context&) = delete;
  const Device& device() const { return device_; }
  cl_context operator()() const { return context_(); }
  cl_command_queue queue() const { return queue_(); }

  /// Enqueues `kernel` over `global` work-items with local size `local`; all arguments must be set. Does not wait.
  void launch(const Kernel& kernel, std::size_t global, std::size_t local = 1) const;
  /// Starts what is enqueued.
  void flush() const;
  /// Waits until everything enqueued has ended.
  void finish() const;

 private:
  Device device_;
  Handle<cl_context, clReleaseContext> context_;
  Handle<cl_command_queue, clReleaseCommandQueue> queue_;
};

}  // namespace raycube::cl
