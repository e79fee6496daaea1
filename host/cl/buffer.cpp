#include "host/cl/buffer.h"

#include "host/base/error.h"
#include "host/cl/kernel_cache.h"
#include "host/cl/status.h"

namespace raycube::cl {
namespace {

std::string mib(std::size_t bytes) { return std::to_string((bytes + (1u << 20) - 1) >> 20) + " MiB"; }

}  // namespace

RawBuffer::RawBuffer(const Context& context, std::size_t bytes, Access access, const std::string& what)
    : context_(&context), bytes_(bytes), what_(what) {
  const DeviceInfo& device = context.device().info();
  if (bytes > device.max_alloc_bytes)
    throw base::Error(base::Fault::device, "OpenCL: the buffer for " + what + " needs " + mib(bytes) +
                                               ", the largest that device '" + device.name + "' allows is " +
                                               mib(device.max_alloc_bytes) + "; use smaller tiles (--memory)");
  const cl_mem_flags flags = access == Access::read_only    ? CL_MEM_READ_ONLY
                             : access == Access::write_only ? CL_MEM_WRITE_ONLY
                                                            : CL_MEM_READ_WRITE;
  cl_int status = CL_SUCCESS;
  memory_ = Handle<cl_mem, clReleaseMemObject>(clCreateBuffer(context(), flags, bytes, nullptr, &status));
  check(status, "clCreateBuffer for " + what + ", " + mib(bytes), device.name);
}

void RawBuffer::write(const void* from, std::size_t bytes, std::size_t offset) {
  const DriverWork work;
  if (offset + bytes > bytes_) throw base::Error(base::Fault::bug, "write past the end of the buffer for " + what_);
  check(clEnqueueWriteBuffer(context_->queue(), memory_(), CL_TRUE, offset, bytes, from, 0, nullptr, nullptr),
        "clEnqueueWriteBuffer of " + what_, context_->device().name());
}

void RawBuffer::read(void* to, std::size_t bytes, std::size_t offset) const {
  const DriverWork work;
  if (offset + bytes > bytes_) throw base::Error(base::Fault::bug, "read past the end of the buffer for " + what_);
  check(clEnqueueReadBuffer(context_->queue(), memory_(), CL_TRUE, offset, bytes, to, 0, nullptr, nullptr),
        "clEnqueueReadBuffer of " + what_, context_->device().name());
}

void* RawBuffer::map(bool for_writing) {
  const DriverWork work;
  cl_int status = CL_SUCCESS;
  void* mapped =
      clEnqueueMapBuffer(context_->queue(), memory_(), CL_TRUE, for_writing ? CL_MAP_WRITE | CL_MAP_READ : CL_MAP_READ,
                         0, bytes_, 0, nullptr, nullptr, &status);
  check(status, "clEnqueueMapBuffer of " + what_, context_->device().name());
  return mapped;
}

void RawBuffer::unmap(void* mapped) {
  check(clEnqueueUnmapMemObject(context_->queue(), memory_(), mapped, 0, nullptr, nullptr),
        "clEnqueueUnmapMemObject of " + what_, context_->device().name());
}

}  // namespace raycube::cl
