/* Layout of the shading stage's output. Valid C++20 and OpenCL C 1.2.
 *
 * Per pixel: a count, `capacity` product keys, and for each key RC_ROW_ACCUMULATORS(sources, heights) sums:
 *   [source * heights + h]  the direct sun where the plan has it (weight * visibility * max(0, n.s)), then the
 *                           components of sky and surroundings (weight * their irradiance), then the temperature nodes
 *                           of emission (weight * node weight of the material's temperature), each split over the
 *                           height nodes by linear weights
 *   [last]                  coverage: sum of sample weights (the material's abundance in the pixel)
 * Product keys: shared/product_key.h. */
#ifndef RAYCUBE_KERNELS_SHARED_ROWS_H
#define RAYCUBE_KERNELS_SHARED_ROWS_H

#define RC_ROW_ACCUMULATORS(sources, heights) ((sources) * (heights) + 1)
/* Sources of a material row, 1 where the sun is one; the last of RC_COMPONENTS that are thermal; temperature nodes. */
#ifdef __OPENCL_C_VERSION__
#ifndef RC_SUN
#define RC_SUN 1
#endif
#ifndef RC_THERMAL_COMPONENTS
#define RC_THERMAL_COMPONENTS 0
#endif
#ifndef RC_TEMPERATURES
#define RC_TEMPERATURES 0
#endif
#endif
#define RC_ROW_OVERFLOW 0xFFFFFFFFu /* count of a pixel that needs more keys than its row holds */

/* Per-pixel truth sums, in this order; each is a sum over the samples that hit, weighted by the sample weight. */
#define RC_TRUTH_HIT 0 /* weight of samples that hit something */
#define RC_TRUTH_SUN 1 /* weight of hit samples that see the sun */
#define RC_TRUTH_X 2   /* hit point, m, scene frame */
#define RC_TRUTH_Y 3
#define RC_TRUTH_Z 4
#define RC_TRUTH_RANGE 5     /* m, sensor to hit */
#define RC_TRUTH_INCIDENCE 6 /* cosine between the normal (facing the viewer) and the sun */
#define RC_TRUTH_SUMS 8      /* floats per pixel; the last is zero */

#endif
