#include "host/cl/context.h"

#include "host/cl/kernel.h"
#include "host/cl/status.h"

namespace raycube::cl {

Context::Context(Device device) : device_(std::move(device)) {
  cl_int status = CL_SUCCESS;
  const cl_device_id id = device_();
  context_ = Handle<cl_context, clReleaseContext>(clCreateContext(nullptr, 1, &id, nullptr, nullptr, &status));
  check(status, "clCreateContext", device_.name());
  queue_ = Handle<cl_command_queue, clReleaseCommandQueue>(clCreateCommandQueue(context_(), id, 0, &status));
  check(status, "clCreateCommandQueue", device_.name());
}

void Context::launch(const Kernel& kernel, std::size_t global, std::size_t local) const {
  check(clEnqueueNDRangeKernel(queue_(), kernel(), 1, nullptr, &global, &local, 0, nullptr, nullptr),
        "clEnqueueNDRangeKernel of '" + kernel.name() + "', " + std::to_string(global) + " work-items", device_.name());
}

void Context::flush() const { check(clFlush(queue_()), "clFlush", device_.name()); }

void Context::finish() const { check(clFinish(queue_()), "clFinish", device_.name()); }

}  // namespace raycube::cl
