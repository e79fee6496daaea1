// Converged results kept on disk, so that a second chart of the same scene starts at once.
#pragma once

#include <functional>
#include <string>

#include "host/lidar/lidar_plan.h"
#include "host/study/converged.h"

namespace raycube::study {

/// Name of what `converge` would give: SHA-256 of everything it depends on, this program's own bytes included. Empty
/// when the scene has no content hash (made in memory): nothing is kept then.
std::string key_of(const scene::Simulation& simulation, const scene::Instrument& instrument, const plan::Plan& plan,
                   const atmos::RenderTable& table, const std::vector<render::Tile>& tiles,
                   const ConvergedSettings& settings);

/// The same for pulses of a LIDAR: Converged holds their photons, a bin for a band.
std::string key_of(const scene::Simulation& simulation, const lidar::LidarPlan& plan,
                   const std::vector<std::int64_t>& pulses);

/// How it went.
struct Kept {
  bool found = false;   ///< false: computed now
  std::string warning;  ///< a file that was damaged; empty: none
};

/// The result under `key` in `folder` (empty key or folder: nothing is kept), else compute() and keep it. A file that
/// is damaged or of another key is computed anew and replaced; one that cannot be written costs the next run its time,
/// no more.
Converged kept_or(const std::string& folder, const std::string& key, const std::function<Converged()>& compute,
                  Kept* what = nullptr);

}  // namespace raycube::study
