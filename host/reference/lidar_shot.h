// One shot of a LIDAR by the book: the radiometry at the top of host/lidar/lidar_plan.h in double, primitives by
// Embree.
#pragma once

#include <cstdint>
#include <vector>

#include "host/reference/lidar_rows.h"
#include "host/reference/lidar_tracer.h"

namespace raycube::reference {

struct LidarShotOptions {
  /// Key of the random numbers; the plan's own seed gives the device's draws.
  std::uint64_t seed = 0;
  bool own_seed = false;        ///< `seed` counts instead of the plan's
  bool scattered_only = false;  ///< leaves returns of air and volumes out
  double slope_s = 0;           ///< > 0: rows of changes by a delay instead, see LidarGate
  int cells_per_bin = 8;        ///< of air and volume returns: steps along a ray
  int air_pixel_step = 1;       ///< receiver sampling: returns of air and volumes of every so many pixels alone
  /// Judges every way to the receiver in double as well and counts those that rounding may decide either way.
  bool count_uncertain = false;
};

struct LidarReference {
  LidarRows rows;
  std::vector<lidar::Ledger> ledger;  ///< [line]
  std::vector<Hit> hits;              ///< first surface of each sub-ray, or [pixel][sample]
  double deepest_m = 0;               ///< of all first surfaces, from where their ray enters the scene's box
  std::uint64_t connections = 0, uncertain = 0;
};

/// What a sub-ray or a pixel's sample starts as.
struct LidarRay {
  glm::dvec3 origin{0}, direction{0};  ///< unit
  int pixel = 0, number = 0;           ///< number: of the sub-ray, or of the sample
};
/// All rays of a shot, in the order of LidarReference::hits.
std::vector<LidarRay> lidar_rays(const lidar::LidarPlan& plan, const lidar::Shot& shot);

/// Background light is left out. Not in it: returns of earlier pulses.
LidarReference reference_shot(const scene::CompiledScene& scene, const EmbreeScene& embree,
                              const lidar::LidarPlan& plan, const lidar::Shot& shot,
                              const LidarShotOptions& options = {});

}  // namespace raycube::reference
