// What a verb hands to a run of the common options.
#pragma once

#include "host/base/output_file.h"
#include "host/cli/verb.h"
#include "host/render/types.h"
#include "host/run/services.h"

namespace raycube::cli {

/// The program's log, bar and signals, and --threads.
run::Services services_of(const Invocation& invocation);

/// --device, --threads and --memory, with the sizes that `tune` kept.
render::RenderOptions render_options(const CommonOptions& common);

/// --overwrite.
base::IfExists if_exists(const CommonOptions& common);

}  // namespace raycube::cli
