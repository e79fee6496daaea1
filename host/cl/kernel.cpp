#include "host/cl/kernel.h"

#include <algorithm>

#include "host/base/error.h"
#include "host/cl/status.h"

namespace raycube::cl {

Kernel::Kernel(const Program& program, const std::string& name) : name_(name), device_name_(program.device_name()) {
  cl_int status = CL_SUCCESS;
  kernel_ = Handle<cl_kernel, clReleaseKernel>(clCreateKernel(program(), name.c_str(), &status));
  check(status, "clCreateKernel of '" + name + "' in program '" + program.name() + "'", device_name_);
  check(clGetKernelWorkGroupInfo(kernel_(), program.device(), CL_KERNEL_WORK_GROUP_SIZE, sizeof most_local_,
                                 &most_local_, nullptr),
        "clGetKernelWorkGroupInfo of '" + name + "'", device_name_);
  most_local_ = std::min(most_local_, program.most_local());
}

void Kernel::set(cl_uint index, const RawBuffer& buffer) {
  const cl_mem memory = buffer();
  set_bytes(index, &memory, sizeof memory);
}

void Kernel::set_bytes(cl_uint index, const void* value, std::size_t bytes) {
  check(clSetKernelArg(kernel_(), index, bytes, value),
        "clSetKernelArg " + std::to_string(index) + " of '" + name_ + "'", device_name_);
}

void Kernel::check_name(const std::string& of_list) const {
  if (of_list != name_)
    throw base::Error(base::Fault::bug, "kernel '" + name_ + "' is given arguments of '" + of_list + "'");
}

void Kernel::check_count(std::size_t given) const {
  cl_uint expected = 0;
  check(clGetKernelInfo(kernel_(), CL_KERNEL_NUM_ARGS, sizeof expected, &expected, nullptr),
        "clGetKernelInfo of '" + name_ + "'", device_name_);
  if (given != expected)
    throw base::Error(base::Fault::bug, "kernel '" + name_ + "' takes " + std::to_string(expected) +
                                            " arguments, found " + std::to_string(given));
}

}  // namespace raycube::cl
