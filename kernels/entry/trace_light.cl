/* Rays from the first surface to sun, sky and lamps as one program: a compiler reads its own headers and ours once, not
 * four times. Rays to the first surface (trace_primary.cl) and paths between surfaces (trace_bounce.cl) are programs of
 * their own: their options, samples and skeletons, would have these kernels, which read none of them, compiled once
 * more for each, and the sky's and the matter's would have those. */
#include "kernels/entry/make_surface.cl"
#include "kernels/entry/trace_sun.cl"
#include "kernels/entry/trace_sky.cl"
#if RC_LAMPS
#include "kernels/entry/trace_lamps.cl"
#endif
#if RC_FIRST_OPAQUE
#include "kernels/entry/first_opaque.cl"
#endif
