#include "host/cl/context.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <vector>

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

struct Context::Shared {
  struct Built {
    std::string source;
    std::shared_ptr<const Program> program;
  };
  Handle<cl_context, clReleaseContext> context;
  std::mutex building;
  std::vector<Built> built;  ///< the last used one last; gone before the context
};

struct Context::OfDevices {
  std::mutex mutex;
  std::map<cl_device_id, std::weak_ptr<Shared>> shared;
  std::vector<std::shared_ptr<Shared>>* kept = nullptr;
  std::atomic<std::size_t> kept_programs = 0;
};

Context::OfDevices& Context::of_devices() {
  static OfDevices of;
  return of;
}

std::shared_ptr<Context::Shared> Context::shared_of(const Device& device) {
  OfDevices& of = of_devices();
  const std::lock_guard lock(of.mutex);
  const cl_device_id id = device();
  std::shared_ptr<Shared> shared = of.shared[id].lock();
  if (shared) return shared;
  shared = std::make_shared<Shared>();
  cl_int status = CL_SUCCESS;
  shared->context = Handle<cl_context, clReleaseContext>(clCreateContext(nullptr, 1, &id, nullptr, nullptr, &status));
  check(status, "clCreateContext", device.name());
  of.shared[id] = shared;
  if (of.kept_programs) {
    static std::vector<std::shared_ptr<Shared>> kept;  // goes before what the first use of a device set up
    of.kept = &kept;
    kept.push_back(shared);
  }
  return shared;
}

void Context::keep_programs(std::size_t count) {
  OfDevices& of = of_devices();
  const std::lock_guard lock(of.mutex);
  of.kept_programs = count;
  if (of.kept) of.kept->clear();
}

Context::Context(Device device)
    : device_(std::move(device)), shared_(shared_of(device_)), sizes_(default_launch_sizes(device_.info())) {
  cl_int status = CL_SUCCESS;
  queue_ = Handle<cl_command_queue, clReleaseCommandQueue>(clCreateCommandQueue((*this)(), device_(), 0, &status));
  check(status, "clCreateCommandQueue", device_.name());
}

Context::~Context() = default;

cl_context Context::operator()() const { return shared_->context(); }

std::shared_ptr<const Program> Context::program(const std::string& name, std::string_view source,
                                                const std::string& options) const {
  const std::lock_guard lock(shared_->building);
  auto& built = shared_->built;
  const auto known = std::find_if(built.begin(), built.end(), [&](const Shared::Built& one) {
    return one.program->name() == name && one.program->options() == options && one.source == source;
  });
  if (known != built.end()) {
    std::rotate(known, known + 1, built.end());
    return built.back().program;
  }
  auto program = std::make_shared<const Program>(*this, name, source, options);
  const std::size_t kept = of_devices().kept_programs, most = kept ? kept : kMostPrograms;
  if (built.size() >= most) built.erase(built.begin(), built.end() - static_cast<std::ptrdiff_t>(most - 1));
  built.push_back({std::string(source), program});
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
