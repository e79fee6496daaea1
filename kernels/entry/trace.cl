/* Rays to the first surface and from there to sun, sky and lamps as one program: a compiler reads its own headers and
 * ours once, not four times. Paths between surfaces are a program of their own (trace_bounce.cl): their options would
 * have these kernels, which read none of them, compiled once more for each. */
#include "kernels/entry/trace_primary.cl"
#include "kernels/entry/make_surface.cl"
#include "kernels/entry/trace_sun.cl"
#include "kernels/entry/trace_sky.cl"
#if RC_LAMPS
#include "kernels/entry/trace_lamps.cl"
#endif
#if RC_FIRST_OPAQUE
#include "kernels/entry/first_opaque.cl"
#endif
