/* The rays by which a pixel sees how much of the sky is open: which sample sends each of them, where it goes and with
 * what density. Valid C++20 and OpenCL C 1.2; contraction off, so that where division and root are rounded
 * exactly (CPUs; other devices may be 2.5 and 3 ulp off) host and device agree on every ray but for the rounding of the
 * surface's normal. */
#ifndef RAYCUBE_KERNELS_SAMPLING_SKY_RAYS_H
#define RAYCUBE_KERNELS_SAMPLING_SKY_RAYS_H

#include "kernels/sampling/sampler.h"

#ifdef __OPENCL_C_VERSION__
typedef ulong rc_u64;
#define RC_SQRT(x) sqrt(x)
#else
#include <cmath>
typedef std::uint64_t rc_u64;
#define RC_SQRT(x) std::sqrt(x)
#endif

#define RC_SKY_DIMENSION 21u /* of rc_hash, and the next one */

/* Samples and rays of one of the interleaved parts whose spread tells a pixel's standard error
 * (host/sensors/psf.h): of a grid the samples of even and odd columns and rows, else every fourth. A pixel of fewer
 * than four samples or rays is one part. */
typedef struct SkyPart {
  rc_u32 samples, columns; /* columns: of the part of a grid; 0: samples are counted one after the other */
  rc_u32 rays;
  float scale; /* samples that each ray stands for */
} SkyPart;

RC_INLINE rc_u32 rc_sky_parts(rc_u32 samples, rc_u32 rays) { return samples < 4u || rays < 4u ? 1u : 4u; }

/* Part `part` of a pixel whose samples are nu x nv (kind: RC_SAMPLER_*) and that sends `rays` in all. Where they cannot
 * be shared out alike, the pixel's hash says which parts have one more. */
RC_INLINE SkyPart rc_sky_shares(int kind, rc_u32 nu, rc_u32 nv, rc_u32 rays, rc_u32 seed, rc_u32 pixel, rc_u32 part) {
  SkyPart out;
  const rc_u32 samples = nu * nv, parts = rc_sky_parts(samples, rays);
  const rc_u32 turned = (part + rc_hash(seed, pixel, 0u, RC_SKY_DIMENSION)) % parts;
  out.columns = parts == 1u || kind == RC_SAMPLER_LATTICE || nu < 2u || nv < 2u ? 0u : (nu + 1u - part % 2u) / 2u;
  out.samples = out.columns != 0u ? out.columns * ((nv + 1u - part / 2u) / 2u) : (samples + parts - 1u - part) / parts;
  out.rays = rays / parts + (turned < rays % parts ? 1u : 0u);
  out.scale = (float)out.samples / (float)out.rays;
  return out;
}

/* Sample of the pixel that sends ray `ray` of a part. Rays are spread over the part's samples: each lies in its own of
 * out.rays equal stretches, at places a golden section further from stretch to stretch, so that the stretches' rays lie
 * on a lattice where a stretch is a row. Every sample is as likely as any other. */
RC_INLINE rc_u32 rc_sky_sample(SkyPart of, rc_u32 nu, rc_u32 samples, rc_u32 rays, rc_u32 seed, rc_u32 pixel,
                               rc_u32 part, rc_u32 ray) {
  const rc_u32 start = rc_hash(seed, pixel, 1u + part, RC_SKY_DIMENSION), place = start + ray * 2654435769u;
  const rc_u64 along = ((rc_u64)ray << 16) + (place >> 16); /* in stretches, times 2^16 */
  const rc_u32 i = (rc_u32)(along * of.samples / of.rays >> 16);
  if (of.columns == 0u) return i * rc_sky_parts(samples, rays) + part;
  return (2u * (i / of.columns) + part / 2u) * nu + 2u * (i % of.columns) + part % 2u;
}

/* Where the rays go: a share `cosine` by the cosine about the normal, of the rest a share `sun` about the sun by
 * Henyey and Greenstein's law of asymmetry g, all else evenly over the upper hemisphere. The first makes it positive
 * wherever light can come from, below the horizon too; g in (0, 1). */
typedef struct SkyDensity {
  float cosine, sun, g;
  float sun_x, sun_y, sun_z; /* unit */
} SkyDensity;

typedef struct SkyRay {
  float x, y, z; /* unit, to where it goes */
  float facing;  /* cosine with the normal; not above 0: no light comes from there */
  float density; /* sr-1 */
} SkyRay;

/* cos and sin of 2 pi v, v in [0, 1): by quarters of the circle, series about their middles' ends to 4e-8. */
RC_INLINE void rc_turn(float v, float* cosine, float* sine) {
  const float quarters = 4.0f * v;
  const int k = (int)(quarters + 0.5f);
  const float t = (quarters - (float)k) * 1.57079632679489662f, q = t * t;
  const float s = t * (1.0f + q * (-0.16666667f + q * (0.0083333333f + q * (-0.00019841270f + q * 2.7557319e-6f))));
  const float c = 1.0f + q * (-0.5f + q * (0.041666667f + q * (-0.0013888889f + q * 2.4801587e-5f)));
  const int turn = k & 3;
  *cosine = turn == 0 ? c : turn == 1 ? -s : turn == 2 ? -c : s;
  *sine = turn == 0 ? s : turn == 1 ? c : turn == 2 ? -s : -c;
}

/* A unit vector at cosine `up` with the axis (unit), turned about it by the angle of `cosine` and `sine`. The frame
 * changes where the axis' height passes 0.83, which no wall, floor or common roof does: two roundings of one normal
 * have one frame. */
RC_INLINE void rc_about(float ax, float ay, float az, float up, float cosine, float sine, float* x, float* y,
                        float* z) {
  const float flat = 1.0f - up * up, out = RC_SQRT(flat > 0.0f ? flat : 0.0f);
  const int steep = az > 0.83f || az < -0.83f;
  /* t = (0, az, -ay) or (-ay, ax, 0), made unit; b = axis x t */
  const float length = steep ? RC_SQRT(az * az + ay * ay) : RC_SQRT(ax * ax + ay * ay);
  const float tx = steep ? 0.0f : -ay / length, ty = (steep ? az : ax) / length, tz = steep ? -ay / length : 0.0f;
  const float bx = ay * tz - az * ty, by = az * tx - ax * tz, bz = ax * ty - ay * tx;
  const float c = out * cosine, s = out * sine;
  *x = up * ax + (c * tx + s * bx);
  *y = up * ay + (c * ty + s * by);
  *z = up * az + (c * tz + s * bz);
}

/* Density of a direction at cosine `facing` with the normal, sr-1. */
RC_INLINE float rc_sky_density(SkyDensity law, float x, float y, float z, float facing) {
  const float alone = (facing > 0.0f ? facing : 0.0f) * 0.318309886f;
  if (law.cosine >= 1.0f) return alone;
  const float around = 1.0f + law.g * law.g - 2.0f * law.g * (x * law.sun_x + y * law.sun_y + z * law.sun_z);
  const float lobe = (1.0f - law.g * law.g) / (around * RC_SQRT(around)) * 0.0795774715f;
  const float even = z > 0.0f ? 0.159154943f : 0.0f;
  return law.cosine * alone + (1.0f - law.cosine) * (law.sun * lobe + (1.0f - law.sun) * even);
}

/* Number of a ray among all of its pixel's: a part's rays follow one another, so that they are spread as evenly as so
 * many can be (every fourth of the sequence lies within a third of it) and their mean's spread tells the whole's. */
RC_INLINE rc_u32 rc_sky_number(rc_u32 samples, rc_u32 rays, rc_u32 part, rc_u32 ray) {
  const rc_u32 parts = rc_sky_parts(samples, rays);
  return part * ((rays + parts - 1u) / parts) + ray;
}

/* The two draws of ray `number` of a pixel: its rays follow the R2 sequence (Roberts 2018: powers of the plastic
 * number) from a start of its own. */
RC_INLINE void rc_sky_draws(rc_u32 seed, rc_u32 pixel, rc_u32 number, float* u, float* v) {
  *u = rc_unit_float(rc_hash(seed, pixel, 0u, RC_SKY_DIMENSION + 1u) + (number + 1u) * 3242174889u);
  *v = rc_unit_float(rc_hash(seed, pixel, 1u, RC_SKY_DIMENSION + 1u) + (number + 1u) * 2447445414u);
}

/* Direction by the law, u and v in [0, 1), without its density: Henyey and Greenstein's part is inverted in
 * closed form (Witt, Astrophys. J. Suppl. 35, 1977, equation 19). */
RC_INLINE SkyRay rc_sky_way(SkyDensity law, float u, float v, float nx, float ny, float nz) {
  SkyRay ray;
  const float lobe = law.cosine + (1.0f - law.cosine) * law.sun;
  float c, s;
  rc_turn(v, &c, &s);
  if (u < law.cosine) {
    u = u / law.cosine;
    rc_about(nx, ny, nz, RC_SQRT(1.0f - u), c, s, &ray.x, &ray.y, &ray.z);
  } else if (u < lobe) {
    u = (u - law.cosine) / (lobe - law.cosine);
    const float part = (1.0f - law.g * law.g) / (1.0f - law.g + 2.0f * law.g * u);
    const float up = (1.0f + law.g * law.g - part * part) / (2.0f * law.g);
    rc_about(law.sun_x, law.sun_y, law.sun_z, up < 1.0f ? up : 1.0f, c, s, &ray.x, &ray.y, &ray.z);
  } else {
    u = (u - lobe) / (1.0f - lobe);
    rc_about(0.0f, 0.0f, 1.0f, u < 1.0f ? u : 1.0f, c, s, &ray.x, &ray.y, &ray.z);
  }
  ray.facing = ray.x * nx + (ray.y * ny + ray.z * nz);
  ray.density = 0.0f;
  return ray;
}

/* Ray `number` of a pixel from a surface of this normal (unit). */
RC_INLINE SkyRay rc_sky_ray(SkyDensity law, rc_u32 seed, rc_u32 pixel, rc_u32 number, float nx, float ny, float nz) {
  float u, v;
  rc_sky_draws(seed, pixel, number, &u, &v);
  SkyRay ray = rc_sky_way(law, u, v, nx, ny, nz);
  ray.density = rc_sky_density(law, ray.x, ray.y, ray.z, ray.facing);
  return ray;
}

#define RC_GLOSS_SHARE 0.5f /* of a glossy surface's rays: mirrored at its facets */

/* Direction by the gloss of a surface, roughness alpha, u and v in [0, 1), without its density: a share is mirrored at
 * facets drawn from the GGX distribution (Walter et al. 2007, equations 35 and 36), the others go by the law. vx, vy,
 * vz: to the viewer, unit. */
RC_INLINE SkyRay rc_mirrored_way(SkyDensity law, float alpha, float u, float v, float nx, float ny, float nz, float vx,
                                 float vy, float vz) {
  SkyRay ray;
  if (u < RC_GLOSS_SHARE) {
    float c, s, hx, hy, hz;
    u = u / RC_GLOSS_SHARE;
    rc_turn(v, &c, &s);
    rc_about(nx, ny, nz, 1.0f / RC_SQRT(1.0f + alpha * alpha * u / (1.0f - u)), c, s, &hx, &hy, &hz);
    const float twice = 2.0f * (hx * vx + (hy * vy + hz * vz));
    ray.x = twice * hx - vx;
    ray.y = twice * hy - vy;
    ray.z = twice * hz - vz;
    ray.facing = ray.x * nx + (ray.y * ny + ray.z * nz);
  } else {
    ray = rc_sky_way(law, (u - RC_GLOSS_SHARE) / (1.0f - RC_GLOSS_SHARE), v, nx, ny, nz);
  }
  ray.density = 0.0f;
  return ray;
}

/* The same of ray `number` of a pixel. */
RC_INLINE SkyRay rc_gloss_way(SkyDensity law, float alpha, rc_u32 seed, rc_u32 pixel, rc_u32 number, float nx, float ny,
                              float nz, float vx, float vy, float vz) {
  float u, v;
  rc_sky_draws(seed, pixel, number, &u, &v);
  return rc_mirrored_way(law, alpha, u, v, nx, ny, nz, vx, vy, vz);
}

#endif
