/* Rays from the first surface to sun, sky and lamps as one program: a compiler reads its own headers and ours once, not
 * five times. Rays to the first surface (trace_primary.cl) and paths between surfaces (trace_bounce.cl) are programs of
 * their own: first rays know nothing of matter, and most scenes follow no paths. */
#include "kernels/entry/make_surface.cl"
#include "kernels/entry/trace_sun.cl"
#include "kernels/entry/trace_sky.cl"
#include "kernels/entry/trace_lamps.cl"
#include "kernels/entry/first_opaque.cl"
