/* The tracing stages as one program: a compiler reads its own headers and ours once, not four times. */
#include "kernels/entry/trace_primary.cl"
#include "kernels/entry/make_surface.cl"
#include "kernels/entry/trace_sun.cl"
#include "kernels/entry/trace_sky.cl"
#if RC_BOUNCES
#include "kernels/entry/trace_bounce.cl"
#endif
