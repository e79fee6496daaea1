/* Random draws of scattered LIDAR paths, the same numbers on host and device. Valid C++20 and OpenCL C 1.2.
 * draw = rc_unit_float(rc_hash(seed, draw_key, sub-ray, dimension)); scattering n counts from 1. */
#ifndef RAYCUBE_KERNELS_SAMPLING_LIDAR_DRAWS_H
#define RAYCUBE_KERNELS_SAMPLING_LIDAR_DRAWS_H

#include "kernels/sampling/sampler.h"

/* Dimensions of step n of a path (from vertex n to the next; a plate gone through is a step too): lobe, radius, angle.
 * */
#define RC_DRAW_LOBE(step) (40u + 4u * (step))
#define RC_DRAW_RADIUS(step) (41u + 4u * (step))
#define RC_DRAW_ANGLE(step) (42u + 4u * (step))

/* Lobe: reflection below rho / s, diffuse transmission below (rho + tau) / s, else straight on (plates); s = rho + tau
 * + plate, each the mean over the lines. Cosine lobe about n with draws u (radius), v (angle):
 *   sqrt(u) cos(2 pi v) t + sqrt(u) sin(2 pi v) b + sqrt(1 - u) n
 * Basis of Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017: s = copysign(1, nz), a = -1 / (s +
 * nz), c = nx ny a, t = (1 + s nx^2 a, s c, -s nx), b = (c, s + ny^2 a, -ny). */

#endif
