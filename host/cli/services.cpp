#include "host/cli/services.h"

namespace raycube::cli {

run::Services services_of(const Invocation& invocation) {
  return run::watched_services(invocation.log, invocation.common.threads);
}

render::RenderOptions render_options(const CommonOptions& common) {
  render::RenderOptions options;
  options.device = common.device;
  options.threads = common.threads;
  options.memory_bytes = common.memory_bytes;
  options.tuned = true;
  return options;
}

base::IfExists if_exists(const CommonOptions& common) {
  return common.overwrite ? base::IfExists::replace : base::IfExists::refuse;
}

}  // namespace raycube::cli
