#include "host/cl/context.h"

#include <algorithm>
#include <chrono>

#include "host/base/doing.h"
#include "host/cl/kernel.h"
#include "host/cl/kernel_cache.h"
#include "host/cl/program.h"
#include "host/cl/status.h"

namespace raycube::cl {

namespace {

/// Programs that are kept while nobody holds them: those of a few shapes of tiles.
constexpr std::size_t kMostPrograms = 12;

}  // namespace

struct Context::Built {
  std::string source;
  std::shared_ptr<const Program> program;
};

Context::Context(Device device) : device_(std::move(device)), sizes_(default_launch_sizes(device_.info())) {
  cl_int status = CL_SUCCESS;
  const cl_device_id id = device_();
  context_ = Handle<cl_context, clReleaseContext>(clCreateContext(nullptr, 1, &id, nullptr, nullptr, &status));
  check(status, "clCreateContext", device_.name());
  queue_ = Handle<cl_command_queue, clReleaseCommandQueue>(clCreateCommandQueue(context_(), id, 0, &status));
  check(status, "clCreateCommandQueue", device_.name());
}

Context::~Context() = default;

std::shared_ptr<const Program> Context::program(const std::string& name, std::string_view source,
                                                const std::string& options) const {
  const std::lock_guard lock(building_);
  const auto known = std::find_if(built_.begin(), built_.end(), [&](const Built& one) {
    return one.program->name() == name && one.program->options() == options && one.source == source;
  });
  if (known != built_.end()) {
    std::rotate(known, known + 1, built_.end());
    return built_.back().program;
  }
  auto program = std::make_shared<const Program>(*this, name, source, options);
  if (built_.size() == kMostPrograms) built_.erase(built_.begin());
  built_.push_back({std::string(source), program});
  return program;
}

void Context::launch(const Kernel& kernel, std::size_t global) const {
  const base::Doing doing("launching kernel", kernel.name());  // which PoCL compiles when it is new
  base::remember_launch(kernel.name());
  const DriverWork work;
  if (times_) finish();
  const auto start = std::chrono::steady_clock::now();
  const auto enqueue = [&](std::size_t first, std::size_t count, std::size_t local) {
    const cl_int status = clEnqueueNDRangeKernel(queue_(), kernel(), 1, &first, &count, &local, 0, nullptr, nullptr);
    if (status != CL_SUCCESS) blame_full_disk();
    check(status,
          "clEnqueueNDRangeKernel of '" + kernel.name() + "', " + std::to_string(count) + " work-items by " +
              std::to_string(local),
          device_.name());
  };
  const std::size_t local = std::clamp<std::size_t>(sizes_.of(kernel.name()), 1, kernel.most_local()),
                    whole = global / local * local;
  if (whole > 0 || global == 0) enqueue(0, whole, local);
  if (global > whole) enqueue(whole, global - whole, sizes_.rest_together ? global - whole : 1);
  if (!times_) return;
  finish();
  KernelTime& time = (*times_)[kernel.name()];
  time.seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  time.most_items = std::max(time.most_items, global);
}

void Context::flush() const {
  const DriverWork work;
  check(clFlush(queue_()), "clFlush", device_.name());
}

void Context::finish() const {
  const DriverWork work;
  check(clFinish(queue_()), "clFinish", device_.name());
}

}  // namespace raycube::cl
