// Host and device must see the same bytes: a probe kernel reports every size and offset of structs.def.
#include <doctest/doctest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "host/base/error.h"
#include "host/cl/kernel.h"
#include "kernels/kernel_source.h"
#include "kernels/shared/structs.h"

namespace {

struct Entry {
  std::string name;
  std::uint32_t value;
};

std::vector<Entry> host_layout() {
  using namespace raycube::shared;
  std::vector<Entry> list;
#define RC_STRUCT_BEGIN(name, text)   \
  {                                   \
    using This = name;                \
    const std::string prefix = #name; \
    list.push_back({prefix + " size", sizeof(This)});
#define RC_FIELD(type, name, text) list.push_back({prefix + "." #name, offsetof(This, name)});
#define RC_ARRAY(type, name, count, text) list.push_back({prefix + "." #name, offsetof(This, name)});
#define RC_STRUCT_END(name, bytes) }
#include "kernels/shared/structs.def"
#undef RC_STRUCT_BEGIN
#undef RC_FIELD
#undef RC_ARRAY
#undef RC_STRUCT_END
  return list;
}

}  // namespace

TEST_CASE("S4: every device lays out the shared structs as the host does") {
  const std::vector<Entry> host = host_layout();
  for (raycube::cl::Device& device : raycube::cl::list_devices()) {
    CAPTURE(device.name());
    const raycube::cl::Context context(std::move(device));
    const raycube::cl::Program program(context, "probe_structs", raycube::kernels::kernel_source("probe_structs"),
                                       "-cl-std=CL1.2 -Werror");
    raycube::cl::Kernel kernel(program, "probe_structs");
    raycube::cl::Buffer<std::uint32_t> report(context, host.size(), raycube::cl::Access::read_write, "struct layout");
    kernel.arguments(report);
    context.launch(kernel, 1);
    const std::vector<std::uint32_t> found = report.read_all();
    for (std::size_t i = 0; i < host.size(); ++i) {
      CAPTURE(host[i].name);
      CHECK(found[i] == host[i].value);
    }
  }
}

TEST_CASE("device errors: a kernel that does not compile names device, options and the real file and line") {
  const raycube::cl::Context context(std::move(raycube::cl::list_devices().front()));
  std::string message;
  try {
    raycube::cl::Program(context, "broken",
                         "#line 7 \"kernels/entry/broken.cl\"\nkernel void f(global int* x) { x[0] = nowhere; }\n",
                         "-DRC_MARK=3");
  } catch (const raycube::base::Error& error) {
    message = error.what();
    CHECK(error.exit_status() == 4);
  }
  CAPTURE(message);
  CHECK(message.find("kernels/entry/broken.cl:7") != std::string::npos);
  CHECK(message.find("nowhere") != std::string::npos);
  CHECK(message.find("-DRC_MARK=3") != std::string::npos);
  CHECK(message.find(context.device().name()) != std::string::npos);
}

TEST_CASE("device errors: a device that does not exist is refused with the list of those that do") {
  CHECK_THROWS_WITH_AS(raycube::cl::find_device("no such device"), doctest::Contains("0: "), raycube::base::Error);
}
