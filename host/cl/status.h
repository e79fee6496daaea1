// OpenCL status codes turned into Error(Fault::device) that names the call, the device and the code.
#pragma once

#include <CL/cl.h>

#include <string>

namespace raycube::cl {

/// "CL_OUT_OF_RESOURCES (-5)"; unknown codes by number.
std::string status_name(cl_int status);

/// Throws Error(device) unless status is CL_SUCCESS. call: "clCreateBuffer, 12 MiB"; device: its name, or empty.
void check(cl_int status, const std::string& call, const std::string& device);

}  // namespace raycube::cl
