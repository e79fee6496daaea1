// Records of a LIDAR's owners (a shot, or a pixel of a shot), made in double; see kernels/lidar/layout.h.
#pragma once

#include <cstdint>
#include <vector>

#include "host/lidar/lidar_plan.h"
#include "kernels/shared/structs.h"

namespace raycube::render {

/// Factor of a thin camera whose image lies on a plane of tangents, pi / (1 + 4 F^2), against pi / (4 F^2); 1 unless
/// asked for.
double camera_factor(const scene::LidarReceiver& receiver);

/// Appends the record of a shot's pixel (transmitter sampling: pixel 0) to `records`, RC_SHOT_FLOAT4S elements.
void append_owner(const lidar::LidarPlan& plan, const scene::CompiledScene& scene, const lidar::Shot& shot, int pixel,
                  std::vector<shared::rc_float4>& records);

}  // namespace raycube::render
