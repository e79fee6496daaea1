// Why no OpenCL device is found: what the system's loader says of each driver that is installed.
#pragma once

#include "host/base/error.h"

namespace raycube::cl {

/// To be thrown where the OpenCL loader offers no device. A driver that is named and cannot be loaded, or a limit on
/// address space, is Error(environment) with what dlopen() says; else no driver is there: Error(device).
base::Error no_device_error();

}  // namespace raycube::cl
