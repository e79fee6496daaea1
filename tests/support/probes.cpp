#include "tests/support/probes.h"

#include <string_view>

namespace raycube::kernels {
/// Made from tests/support/probes.cl by cmake/EmbedKernels.cmake.
std::string_view probe_source(std::string_view name);
}  // namespace raycube::kernels

namespace raycube::test {

std::shared_ptr<const cl::Program> probes(const cl::Context& context, const std::string& options) {
  return context.program("probes", kernels::probe_source("probes"),
                         "-cl-std=CL1.2 -Werror -DRC_STACK=" + std::to_string(kProbeStack) + options);
}

}  // namespace raycube::test
