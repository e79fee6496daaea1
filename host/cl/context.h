// A context with one in-order queue on one device. Several can live side by side; those of one device share the
// driver's context and the programs built there.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "host/cl/device.h"
#include "host/cl/handle.h"
#include "host/cl/launch_sizes.h"

namespace raycube::cl {

class Kernel;
class Program;

/// What a kernel's launches took.
struct KernelTime {
  double seconds = 0;
  std::size_t most_items = 0;  ///< of one launch
};

/// Device, context and in-order queue. Buffers, programs and kernels made from it must not outlive it.
class Context {
 public:
  explicit Context(Device device);
  ~Context();
  Context(const Context&) = delete;  // buffers point to it
  Context& operator=(const Context&) = delete;
  const Device& device() const { return device_; }
  cl_context operator()() const;
  cl_command_queue queue() const { return queue_(); }

  /// A program as Program builds it, or the one of the same name, source and options that was built before, while a
  /// context of the device lived, and is among those used last: even a build of compiled kernels takes the driver a
  /// twentieth of a second.
  std::shared_ptr<const Program> program(const std::string& name, std::string_view source,
                                         const std::string& options) const;
  /// For processes that make many contexts one after the other: what those of a device share stays until the process
  /// ends, with so many programs. 0, as it begins: while one of them lives, with a dozen.
  static void keep_programs(std::size_t count);
  /// Enqueues `kernel` over `global` work-items; all arguments must be set. Does not wait. The local size is that of
  /// launch_sizes(), at most what device and kernel allow; items past its last multiple follow in a launch of their
  /// own.
  void launch(const Kernel& kernel, std::size_t global) const;
  const LaunchSizes& launch_sizes() const { return sizes_; }
  void set_launch_sizes(LaunchSizes sizes) { sizes_ = std::move(sizes); }
  /// From now on every launch waits for its end and adds its wall seconds to its kernel's; null: no longer.
  void time_kernels(std::map<std::string, KernelTime>* times) { times_ = times; }
  /// Starts what is enqueued.
  void flush() const;
  /// Waits until everything enqueued has ended.
  void finish() const;

 private:
  struct Shared;
  struct OfDevices;
  static OfDevices& of_devices();
  static std::shared_ptr<Shared> shared_of(const Device& device);
  Device device_;
  std::shared_ptr<Shared> shared_;
  Handle<cl_command_queue, clReleaseCommandQueue> queue_;
  LaunchSizes sizes_;
  std::map<std::string, KernelTime>* times_ = nullptr;
};

}  // namespace raycube::cl
