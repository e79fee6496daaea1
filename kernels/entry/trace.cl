/* The tracing stages as one program: a compiler reads its own headers and ours once, not four times. */
#include "kernels/entry/trace_primary.cl"
#include "kernels/entry/make_surface.cl"
#include "kernels/entry/trace_sun.cl"
#include "kernels/entry/trace_sky.cl"
#if RC_LAMPS
#include "kernels/entry/trace_lamps.cl"
#endif
#if RC_BOUNCES || RC_FIRST_OPAQUE /* here for both: a program has each file once */
#include "kernels/geometry/ray_trace.h"
#include "kernels/light/path_ends.h"
#endif
#if RC_BOUNCES
#include "kernels/entry/trace_bounce.cl"
#endif
#if RC_FIRST_OPAQUE
#include "kernels/entry/first_opaque.cl"
#endif
