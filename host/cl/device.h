// OpenCL devices of this machine, and the parts of one (sub-devices) that a thread limit asks for.
#pragma once

#include <CL/cl.h>

#include <cstdint>
#include <string>
#include <vector>

namespace raycube::cl {

/// What `raycube devices` prints and what tiling needs.
struct DeviceInfo {
  std::string name, vendor, platform, version, driver;
  std::string c_version;  ///< OpenCL C version
  std::uint64_t global_memory_bytes = 0;
  std::uint64_t max_alloc_bytes = 0;  ///< largest buffer; changes between runs on PoCL: ask, never remember
  std::uint32_t compute_units = 0;
  std::size_t max_work_items = 1;  ///< of a work-group along its first dimension
  std::uint32_t native_float_width = 0;
  bool fp64 = false;
  bool is_cpu = false;
  bool rounds_on_demand = false;  ///< no CPU, but can round quotients and roots of floats exactly
};

/// One device, whole or part of one; nobody owns it, parts live as long as the process (device.cpp says why).
class Device {
 public:
  explicit Device(cl_device_id id);
  const DeviceInfo& info() const { return info_; }
  const std::string& name() const { return info_.name; }
  cl_device_id operator()() const { return id_; }

  /// The same device limited to `units` compute units (1..compute_units; all of them returns the whole device). Throws
  /// Error(input) when out of range and Error(device) when the driver cannot split.
  Device with_compute_units(std::uint32_t units) const;

 private:
  void query();
  cl_device_id id_ = nullptr;
  DeviceInfo info_;
};

/// All devices of all platforms, in the loader's order; where an OpenCL program begins (kernel_cache.h). Throws
/// Error(device) when there are none.
std::vector<Device> list_devices();

/// The device whose number ("0") or part of whose name (any case) is given; empty: the first. Throws Error(input) that
/// lists the devices when nothing or more than one fits.
Device find_device(const std::string& wanted);

}  // namespace raycube::cl
