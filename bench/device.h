// The device render would pick, limited to the bench's threads.
#pragma once

#include "host/cl/device.h"

namespace raycube::bench {

inline cl::Device pick_device(int threads) {
  cl::Device device = cl::find_device("");
  if (device.info().is_cpu && threads < static_cast<int>(device.info().compute_units))
    return device.with_compute_units(static_cast<std::uint32_t>(threads));
  return device;
}

}  // namespace raycube::bench
