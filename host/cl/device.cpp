#include "host/cl/device.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <mutex>
#include <utility>

#include "host/base/error.h"
#include "host/cl/driver_search.h"
#include "host/cl/kernel_cache.h"
#include "host/cl/status.h"

namespace raycube::cl {
namespace {

using base::Error;
using base::Fault;

std::string text_of(cl_device_id device, cl_device_info what) {
  std::size_t size = 0;
  check(clGetDeviceInfo(device, what, 0, nullptr, &size), "clGetDeviceInfo", "");
  std::string text(size, '\0');
  check(clGetDeviceInfo(device, what, size, text.data(), nullptr), "clGetDeviceInfo", "");
  text.resize(text.find_last_not_of(std::string("\0 ", 2)) + 1);
  return text;
}

template <typename T>
T value_of(cl_device_id device, cl_device_info what) {
  T value{};
  check(clGetDeviceInfo(device, what, sizeof value, &value, nullptr), "clGetDeviceInfo", "");
  return value;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

/// The part of `units` compute units of a device, made when first asked for and never given back. PoCL 3.1 counts no
/// context's or queue's use of a sub-device, and its worker releases a finished command's event, through
/// event->queue->device, after clFinish has returned: a sub-device released by then is somebody else's memory, and the
/// process dies now and then (POclReleaseEvent).
cl_device_id part_of(cl_device_id device, std::uint32_t units, const std::string& name) {
  static std::mutex mutex;
  static auto& parts =
      *new std::map<std::pair<cl_device_id, std::uint32_t>, cl_device_id>;  // workers outlive static objects
  const std::lock_guard lock(mutex);
  cl_device_id& part = parts[{device, units}];
  if (!part) {
    const cl_device_partition_property split[] = {CL_DEVICE_PARTITION_BY_COUNTS,
                                                  static_cast<cl_device_partition_property>(units),
                                                  CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
    check(clCreateSubDevices(device, split, 1, &part, nullptr),
          "clCreateSubDevices, " + std::to_string(units) + " units", name);
  }
  return part;
}

}  // namespace

Device::Device(cl_device_id id) : id_(id) { query(); }

void Device::query() {
  info_.name = text_of(id_, CL_DEVICE_NAME);
  info_.vendor = text_of(id_, CL_DEVICE_VENDOR);
  info_.version = text_of(id_, CL_DEVICE_VERSION);
  info_.driver = text_of(id_, CL_DRIVER_VERSION);
  info_.c_version = text_of(id_, CL_DEVICE_OPENCL_C_VERSION);
  info_.global_memory_bytes = value_of<cl_ulong>(id_, CL_DEVICE_GLOBAL_MEM_SIZE);
  info_.max_alloc_bytes = value_of<cl_ulong>(id_, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
  info_.compute_units = value_of<cl_uint>(id_, CL_DEVICE_MAX_COMPUTE_UNITS);
  std::array<std::size_t, 16> items{};
  check(
      clGetDeviceInfo(id_, CL_DEVICE_MAX_WORK_ITEM_SIZES,
                      std::min<std::size_t>(items.size(), value_of<cl_uint>(id_, CL_DEVICE_MAX_WORK_ITEM_DIMENSIONS)) *
                          sizeof items[0],
                      items.data(), nullptr),
      "clGetDeviceInfo", info_.name);
  info_.max_work_items = std::max<std::size_t>(1, items[0]);
  info_.native_float_width = value_of<cl_uint>(id_, CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT);
  info_.fp64 = text_of(id_, CL_DEVICE_EXTENSIONS).find("cl_khr_fp64") != std::string::npos;
  info_.is_cpu = (value_of<cl_device_type>(id_, CL_DEVICE_TYPE) & CL_DEVICE_TYPE_CPU) != 0;
  info_.rounds_on_demand = !info_.is_cpu && (value_of<cl_device_fp_config>(id_, CL_DEVICE_SINGLE_FP_CONFIG) &
                                             CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  const auto platform = value_of<cl_platform_id>(id_, CL_DEVICE_PLATFORM);
  std::size_t size = 0;
  check(clGetPlatformInfo(platform, CL_PLATFORM_NAME, 0, nullptr, &size), "clGetPlatformInfo", info_.name);
  info_.platform.resize(size);
  check(clGetPlatformInfo(platform, CL_PLATFORM_NAME, size, info_.platform.data(), nullptr), "clGetPlatformInfo",
        info_.name);
  info_.platform.resize(size ? size - 1 : 0);
}

Device Device::with_compute_units(std::uint32_t units) const {
  if (units == 0 || units > info_.compute_units)
    throw Error(Fault::input, "device '" + info_.name + "' has " + std::to_string(info_.compute_units) +
                                  " compute units, found " + std::to_string(units) +
                                  "; give a number of threads from 1 to " + std::to_string(info_.compute_units));
  return Device(units == info_.compute_units ? id_ : part_of(id_, units, info_.name));
}

std::vector<Device> list_devices() {
  prepare_kernel_cache();
  cl_uint count = 0;
  const cl_int status = clGetPlatformIDs(0, nullptr, &count);
  std::vector<cl_platform_id> platforms(count);
  if (status == CL_SUCCESS && count) check(clGetPlatformIDs(count, platforms.data(), nullptr), "clGetPlatformIDs", "");
  std::vector<Device> devices;
  for (cl_platform_id platform : platforms) {
    cl_uint here = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &here) != CL_SUCCESS || here == 0) continue;
    std::vector<cl_device_id> ids(here);
    check(clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, here, ids.data(), nullptr), "clGetDeviceIDs", "");
    for (cl_device_id id : ids) devices.emplace_back(id);
  }
  if (devices.empty()) throw no_device_error();
  return devices;
}

Device find_device(const std::string& wanted) {
  std::vector<Device> devices = list_devices();
  if (wanted.empty()) return std::move(devices.front());
  std::vector<std::size_t> fitting;
  const bool number = std::all_of(wanted.begin(), wanted.end(), [](unsigned char c) { return std::isdigit(c); });
  for (std::size_t i = 0; i < devices.size(); ++i)
    if (number ? wanted == std::to_string(i) : lower(devices[i].name()).find(lower(wanted)) != std::string::npos)
      fitting.push_back(i);
  if (fitting.size() == 1) return std::move(devices[fitting[0]]);
  std::string list;
  for (std::size_t i = 0; i < devices.size(); ++i) list += "\n  " + std::to_string(i) + ": " + devices[i].name();
  throw Error(Fault::input, "device '" + wanted + "' " + (fitting.empty() ? "fits none" : "fits more than one") +
                                " of the OpenCL devices; give the number or a part of the name of one:" + list);
}

}  // namespace raycube::cl
