// What `render --dry-run` says of an instrument: its image, its plan, and the memory a render will take.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/cli/simulation_job.h"

namespace raycube::cli {

/// Bytes are estimates of what raycube itself holds; the OpenCL driver and its compiler come on top (PoCL: about 200 MiB).
nlohmann::json dry_run_json(const scene::CompiledScene& scene, const InstrumentJob& job, const render::RenderOptions& options);

/// The same for people, a few lines.
std::string dry_run_text(const nlohmann::json& item);

}  // namespace raycube::cli
