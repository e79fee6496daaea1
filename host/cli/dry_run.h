// What `render --dry-run` says of an instrument: its image, its plan, and the memory a render will take.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "host/cli/simulation_job.h"

namespace raycube::cli {

/// tile_samples: of the device (render::DeviceTuning). Bytes are estimates of what raycube itself holds; the OpenCL
/// driver and its compiler come on top (PoCL: about 200 MiB).
nlohmann::json dry_run_json(const scene::CompiledScene& scene, const InstrumentJob& job,
                            const render::RenderOptions& options, std::size_t tile_samples);

/// Seconds a render will take on the renderer's device without reading, planning and building programs: the time of
/// short stretches of four lines spread over the image, times the pixels. Good to about a factor of two: small tiles
/// meet neither the writing nor memory that is touched for the first time.
double estimate_render_s(render::Renderer& renderer, const scene::Simulation& simulation, const InstrumentJob& job);

/// The same for people, a few lines; the time when `item` has "estimated_s".
std::string dry_run_text(const nlohmann::json& item);

}  // namespace raycube::cli
