// Arguments of a LIDAR's kernels as structs, from kernels/lidar/arguments.h.
#pragma once

#include "host/cl/arguments.h"
#include "kernels/lidar/arguments.h"

namespace raycube::render {

RC_ARGUMENT_STRUCT(LidarShotsArguments, "lidar_shots", RC_LIDAR_SHOTS_ARGUMENTS)
RC_ARGUMENT_STRUCT(LidarBeamArguments, "lidar_beam", RC_LIDAR_BEAM_ARGUMENTS)
RC_ARGUMENT_STRUCT(LidarAirArguments, "lidar_air", RC_LIDAR_AIR_ARGUMENTS)

}  // namespace raycube::render
