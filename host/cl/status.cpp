#include "host/cl/status.h"

#include <array>

#include "host/base/error.h"
#include "host/base/memory.h"

namespace raycube::cl {
namespace {

struct Name {
  cl_int status;
  const char* text;
};

#define RC_STATUS(code) \
  { code, #code }
constexpr std::array kNames{Name RC_STATUS(CL_DEVICE_NOT_FOUND),
                            Name RC_STATUS(CL_DEVICE_NOT_AVAILABLE),
                            Name RC_STATUS(CL_COMPILER_NOT_AVAILABLE),
                            Name RC_STATUS(CL_MEM_OBJECT_ALLOCATION_FAILURE),
                            Name RC_STATUS(CL_OUT_OF_RESOURCES),
                            Name RC_STATUS(CL_OUT_OF_HOST_MEMORY),
                            Name RC_STATUS(CL_MEM_COPY_OVERLAP),
                            Name RC_STATUS(CL_BUILD_PROGRAM_FAILURE),
                            Name RC_STATUS(CL_MAP_FAILURE),
                            Name RC_STATUS(CL_LINK_PROGRAM_FAILURE),
                            Name RC_STATUS(CL_DEVICE_PARTITION_FAILED),
                            Name RC_STATUS(CL_INVALID_VALUE),
                            Name RC_STATUS(CL_INVALID_DEVICE),
                            Name RC_STATUS(CL_INVALID_CONTEXT),
                            Name RC_STATUS(CL_INVALID_COMMAND_QUEUE),
                            Name RC_STATUS(CL_INVALID_HOST_PTR),
                            Name RC_STATUS(CL_INVALID_MEM_OBJECT),
                            Name RC_STATUS(CL_INVALID_BINARY),
                            Name RC_STATUS(CL_INVALID_BUILD_OPTIONS),
                            Name RC_STATUS(CL_INVALID_PROGRAM),
                            Name RC_STATUS(CL_INVALID_PROGRAM_EXECUTABLE),
                            Name RC_STATUS(CL_INVALID_KERNEL_NAME),
                            Name RC_STATUS(CL_INVALID_KERNEL),
                            Name RC_STATUS(CL_INVALID_ARG_INDEX),
                            Name RC_STATUS(CL_INVALID_ARG_VALUE),
                            Name RC_STATUS(CL_INVALID_ARG_SIZE),
                            Name RC_STATUS(CL_INVALID_KERNEL_ARGS),
                            Name RC_STATUS(CL_INVALID_WORK_DIMENSION),
                            Name RC_STATUS(CL_INVALID_WORK_GROUP_SIZE),
                            Name RC_STATUS(CL_INVALID_WORK_ITEM_SIZE),
                            Name RC_STATUS(CL_INVALID_GLOBAL_OFFSET),
                            Name RC_STATUS(CL_INVALID_EVENT_WAIT_LIST),
                            Name RC_STATUS(CL_INVALID_EVENT),
                            Name RC_STATUS(CL_INVALID_OPERATION),
                            Name RC_STATUS(CL_INVALID_BUFFER_SIZE),
                            Name RC_STATUS(CL_INVALID_GLOBAL_WORK_SIZE),
                            Name RC_STATUS(CL_INVALID_DEVICE_PARTITION_COUNT),
                            Name{-1001, "CL_PLATFORM_NOT_FOUND_KHR"}};
#undef RC_STATUS

}  // namespace

std::string status_name(cl_int status) {
  for (const Name& name : kNames)
    if (name.status == status) return std::string(name.text) + " (" + std::to_string(status) + ")";
  return "OpenCL status " + std::to_string(status);
}

void check(cl_int status, const std::string& call, const std::string& device) {
  if (status == CL_SUCCESS) return;
  const bool memory =
      status == CL_OUT_OF_HOST_MEMORY || status == CL_OUT_OF_RESOURCES || status == CL_MEM_OBJECT_ALLOCATION_FAILURE;
  const std::string limit = memory ? base::address_space_text() : "";
  throw base::Error(limit.empty() ? base::Fault::device : base::Fault::environment,
                    "OpenCL: " + call + " failed with " + status_name(status) +
                        (device.empty() ? "" : " on device '" + device + "'") + limit);
}

}  // namespace raycube::cl
