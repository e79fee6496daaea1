// How many work-items a launch puts into one work-group, by kernel.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "host/cl/device.h"

namespace raycube::cl {

/// Local sizes. Every kernel's items are independent and know themselves by their global id, so that none can change a bit; which is the
/// fastest depends on device and driver (`raycube tune`, host/render/tuner.h).
struct LaunchSizes {
  std::size_t other = 1;                     ///< of kernels not in the list
  std::map<std::string, std::size_t> local;  ///< of kernels by name
  std::size_t of(const std::string& kernel) const {
    const auto found = local.find(kernel);
    return found == local.end() ? other : found->second;
  }
};

/// What is used where nothing was tuned: 1 on CPUs, whose cores take one item at a time; 64 elsewhere, since a device that runs 32 or 64
/// items in step would leave all but one of its lanes idle.
inline LaunchSizes default_launch_sizes(const DeviceInfo& device) { return {device.is_cpu ? std::size_t{1} : std::size_t{64}, {}}; }

}  // namespace raycube::cl
