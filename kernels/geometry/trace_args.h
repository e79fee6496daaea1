/* How to build and launch the tracing kernels: trace_primary, make_surface, trace_sun, trace_sky and, where light goes
 * on from surface to surface, trace_bounce; where there are lamps, trace_lamps.
 * What lies where in their buffers: kernels/shared/tile_layout.h.
 *
 * Chain, all in one in-order queue:
 *   trace_primary -> hits -> make_surface -> surface -> trace_sun -> sun
 *                                                   |-> trace_sky -> met sky -> trace_lamps -> met sky
 *                                                   \-> trace_bounce -> glow
 *
 * Build options (a program is given those that it reads, host/render/tile_shape.cpp; a -D that is missing here has the
 * default below, or that of kernels/shared/tile_layout.h); all else is in the argument `tile`, a TileShape:
 *   RC_CHUNK_SAMPLES    most samples of a pixel that one launch handles: how much a kernel's own arrays hold
 *   RC_MOST_LIGHTS      likewise of sources that have a value for each sample
 *   RC_GRID             of trace_primary: 1: the plain grid over one pixel, which is faster; 0: samples anywhere in the
 *                       field
 *   RC_STACK            CompiledScene::stack_bound() or more
 *   RC_SHAPED, RC_THROUGH, RC_PLATES, RC_GLOSSY, RC_FURTHER, RC_FURTHER_RECORDS  what the scene's matter may ask for:
 *                       kernels/shared/tile_layout.h
 *   RC_SKELETON         of trace_bounce: most wavelengths along paths, whole words
 * Samples of a launch: first_sample .. first_sample + sample_count - 1, sample_count <= RC_CHUNK_SAMPLES; with the grid
 * both are multiples of samples_u, so that a chunk is whole rows.
 *
 * Rays: pixel p of a group (0 .. tile.pixels_per_group - 1) and sample s with (u, v) = rc_sample_uv(...) have
 *   a = (p - (pixels_per_group - 1) / 2) + u,  b = v
 *   start = origin + offset (never added up where hits are decided), offset = d0.w (a du + b dv) + b ov,  direction =
 *   fma(b, dv, fma(a, du, d0)); the sensor lies at origin - d0.w d0 (kernels/geometry/samples.h)
 * so d0 is the direction of the group's centre (for 4: between pixels 1 and 2), du and dv its change per pixel.
 * Groups of a tile: line by line, rc_groups_per_line of them per line; the last may hold fewer pixels. A tile may also
 * be any list of groups: each is then a line of its own, columns = pixels_per_group.
 *
 * Every kernel: any local size (one item is one group, by its global id), global size = groups of the tile; arguments:
 * kernels/shared/camera_arguments.h. The scene's arrays have at least one element each, even in an empty scene. A
 * pixel's number in hashes is its group's (RayGroup.origin.w) plus its place in the group: its place in the image, so
 * results do not depend on tiling.
 *   trace_primary  hits: the closest; of equal distances what the user placed first, then the triangle that stands
 *                  first in its mesh (kernels/geometry/user_order.h). Slots at and past sample_count hold RC_NONE.
 *   make_surface   surface: the point moved off the surface to the viewer's side by its error bound (the origin of
 *                  shadow rays), and the normal. lift: how far along the normal the point was moved (rc_step_back
 *                  undoes it); with shapes the way to the viewer and the surface's shape. Misses: all are 0.
 *   trace_sun      bits of the samples that see the sun: clear for misses and where n . sun <= 0. All samples of a
 *                  group go together.
 *   trace_sky      the pixel sends `rays` rays, each from a sample and in a direction of its own
 *                  (kernels/sampling/sky_rays.h). Plane m of met_sky, in the order of parts and rays: the sum over the
 *                  sample's rays of scale (V - c) cosine A_m / density, where V is 1 where nothing lies ahead (with
 *                  shapes pi f), c the surface's open_share and A_m the sky's map (kernels/light/sky_map.h). A ray
 *                  below the surface's or the scene's horizon brings nothing. Shading adds it to c times the open
 *                  sky's irradiance, which makes the estimate free of bias for any c: with 1 open ground has no noise.
 *   trace_lamps    each side of a sample's surface draws one lamp of every source (kernels/light/lamps.h) and sends a
 *                  ray to it. Its planes of met_sky follow the sky's and are written whole, after trace_sky.
 */
#ifndef RAYCUBE_KERNELS_GEOMETRY_TRACE_ARGS_H
#define RAYCUBE_KERNELS_GEOMETRY_TRACE_ARGS_H

#pragma OPENCL FP_CONTRACT OFF
#include "kernels/shared/tile_layout.h"
#include "kernels/sampling/sampler.h"

#ifndef RC_GRID
#define RC_GRID 0
#endif
#ifndef RC_STACK
#define RC_STACK 128
#endif

#endif
