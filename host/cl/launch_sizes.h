// How many work-items a launch puts into one work-group, by kernel.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "host/cl/device.h"

namespace raycube::cl {

/// Local sizes. Every kernel's items are independent and know themselves by their global id, so that none can change a
/// bit; which is the fastest depends on device and driver (`raycube tune`, host/render/tuner.h).
struct LaunchSizes {
  std::size_t other = 1;                     ///< of kernels not in the list
  std::map<std::string, std::size_t> local;  ///< of kernels by name
  bool rest_together = false;  ///< items past the last whole work-group: one work-group of them all, else one each
  std::size_t of(const std::string& kernel) const {
    const auto found = local.find(kernel);
    return found == local.end() ? other : found->second;
  }
};

/// What is used where nothing was tuned: 1 on CPUs, whose cores take one item at a time; 64 elsewhere, since a device
/// that runs 32 or 64 items in step would leave all but one of its lanes idle. PoCL compiles a kernel anew for every
/// local size, so that on CPUs what is left of a launch goes one by one.
inline LaunchSizes default_launch_sizes(const DeviceInfo& device) {
  return {device.is_cpu ? std::size_t{1} : std::size_t{64}, {}, !device.is_cpu};
}

}  // namespace raycube::cl
