// What `render --dry-run` says.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "host/run/forecast.h"
#include "host/run/render_lidar.h"

namespace raycube::cli {

/// estimated_s: what a render will take, where a device could tell.
nlohmann::json dry_run_json(const run::CameraJob& job, const run::CameraForecast& forecast,
                            std::optional<double> estimated_s);
nlohmann::json dry_run_json(const scene::Lidar& lidar, const run::LidarForecast& forecast);

/// The same for people, a few lines.
std::string dry_run_text(const run::CameraJob& job, const run::CameraForecast& forecast,
                         std::optional<double> estimated_s);
std::string dry_run_text(const scene::Lidar& lidar, const run::LidarForecast& forecast);

}  // namespace raycube::cli
