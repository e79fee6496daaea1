// Arguments of a camera's kernels as structs, from kernels/shared/camera_arguments.h.
#pragma once

#include "host/cl/arguments.h"
#include "kernels/shared/camera_arguments.h"

namespace raycube::render {

RC_ARGUMENT_STRUCT(TracePrimaryArguments, "trace_primary", RC_TRACE_PRIMARY_ARGUMENTS)
RC_ARGUMENT_STRUCT(MakeSurfaceArguments, "make_surface", RC_MAKE_SURFACE_ARGUMENTS)
RC_ARGUMENT_STRUCT(TraceSunArguments, "trace_sun", RC_TRACE_SUN_ARGUMENTS)
RC_ARGUMENT_STRUCT(TraceSkyArguments, "trace_sky", RC_TRACE_SKY_ARGUMENTS)
RC_ARGUMENT_STRUCT(TraceLampsArguments, "trace_lamps", RC_TRACE_LAMPS_ARGUMENTS)
RC_ARGUMENT_STRUCT(TraceBounceArguments, "trace_bounce", RC_TRACE_BOUNCE_ARGUMENTS)
RC_ARGUMENT_STRUCT(FirstOpaqueArguments, "first_opaque", RC_FIRST_OPAQUE_ARGUMENTS)
RC_ARGUMENT_STRUCT(ShadeArguments, "shade", RC_SHADE_ARGUMENTS)
RC_ARGUMENT_STRUCT(ResolveArguments, "resolve", RC_RESOLVE_ARGUMENTS)
RC_ARGUMENT_STRUCT(IntegrateBandsArguments, "integrate_bands", RC_INTEGRATE_BANDS_ARGUMENTS)

}  // namespace raycube::render
