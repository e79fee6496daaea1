#include <ostream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/base/memory.h"
#include "host/cl/device.h"
#include "host/cli/verb.h"

namespace raycube::cli {
namespace {

using Json = nlohmann::ordered_json;

int list_devices(Invocation& invocation) {
  const auto devices = cl::list_devices();
  Json list = Json::array();
  for (std::size_t i = 0; i < devices.size(); ++i) {
    const cl::DeviceInfo& d = devices[i].info();
    if (invocation.common.json) {
      list.push_back({{"number", i},
                      {"name", d.name},
                      {"vendor", d.vendor},
                      {"platform", d.platform},
                      {"version", d.version},
                      {"c_version", d.c_version},
                      {"driver", d.driver},
                      {"cpu", d.is_cpu},
                      {"compute_units", d.compute_units},
                      {"native_float_width", d.native_float_width},
                      {"fp64", d.fp64},
                      {"global_memory_bytes", d.global_memory_bytes},
                      {"max_alloc_bytes", d.max_alloc_bytes}});
      continue;
    }
    invocation.out << fmt::format("{}  {}\n", i, d.name);
    invocation.out << fmt::format("   {}, {}, {}, driver {}\n", d.platform, d.version, d.c_version, d.driver);
    invocation.out << fmt::format("   {}, {} compute units, native vectors of {} floats, {}double precision\n",
                                  d.is_cpu ? "CPU" : "GPU or accelerator", d.compute_units, d.native_float_width,
                                  d.fp64 ? "" : "no ");
    invocation.out << fmt::format("   memory {}, largest buffer {}\n", base::format_bytes(d.global_memory_bytes),
                                  base::format_bytes(d.max_alloc_bytes));
  }
  if (invocation.common.json) invocation.out << Json{{"devices", list}}.dump(2) << "\n";
  return 0;
}

}  // namespace

Verb verb_devices() {
  Verb verb("devices", "List the OpenCL devices of this machine");
  verb.description =
      "The number or any part of the name can be given to --device. Without any device the exit status is 4.";
  verb.examples = {"raycube devices", "raycube devices --json"};
  verb.run = list_devices;
  return verb;
}

}  // namespace raycube::cli
