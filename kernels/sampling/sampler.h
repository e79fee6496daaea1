/* Where a pixel's samples lie. Valid C++20 and OpenCL C 1.2; only exactly rounded operations, so host and device agree
 * to the bit (contraction off). Positions are relative to the pixel centre, in pixels: u along the line, v across
 * lines. */
#ifndef RAYCUBE_KERNELS_SAMPLING_SAMPLER_H
#define RAYCUBE_KERNELS_SAMPLING_SAMPLER_H

#ifdef __OPENCL_C_VERSION__
#define RC_INLINE inline
typedef uint rc_u32;
#else
#include <cstdint>
#define RC_INLINE inline
typedef std::uint32_t rc_u32;
#endif

#define RC_SAMPLER_GRID 0
#define RC_SAMPLER_LATTICE 1
#define RC_SAMPLER_JITTERED 2

/* Counter-based random bits: PCG-RXS-M-XS style hash of (seed, pixel, sample, dimension), 32 bits out.
 * Source: Jarzynski & Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020 (pcg4d). */
RC_INLINE rc_u32 rc_hash(rc_u32 seed, rc_u32 pixel, rc_u32 sample, rc_u32 dimension) {
  rc_u32 x = seed * 1664525u + 1013904223u, y = pixel * 1664525u + 1013904223u;
  rc_u32 z = sample * 1664525u + 1013904223u, w = dimension * 1664525u + 1013904223u;
  x += y * w;
  y += z * x;
  z += x * y;
  w += y * z;
  x ^= x >> 16;
  y ^= y >> 16;
  z ^= z >> 16;
  w ^= w >> 16;
  x += y * w;
  y += z * x;
  z += x * y;
  w += y * z;
  return x ^ w;
}

/* Uniform in [0, 1): 24 bits, exact in float. */
RC_INLINE float rc_unit_float(rc_u32 bits) { return (float)(bits >> 8) * 5.9604644775390625e-8f; }

/* How far a pixel's lattice is moved, in its own widths, 0 .. 1 each way. */
typedef struct LatticeShift {
  float x, y;
} LatticeShift;
RC_INLINE LatticeShift rc_lattice_shift(rc_u32 seed, rc_u32 pixel) {
  LatticeShift out;
  out.x = rc_unit_float(rc_hash(seed, pixel, 0u, 11u));
  out.y = rc_unit_float(rc_hash(seed, pixel, 1u, 11u));
  return out;
}
/* Sample s of n of a lattice, in its own widths, 0 .. 1 each way. */
RC_INLINE void rc_lattice_xy(int n, LatticeShift shift, int s, float* x, float* y) {
  const int wrapped = s + (int)((1.0f - shift.x) * (float)n + 0.5f), k = wrapped < n ? wrapped : wrapped - n;
  *x = ((float)k + 0.5f) / (float)n + shift.x;
  *y = rc_unit_float((rc_u32)k * 2654435769u) + shift.y;
  *x = *x >= 1.0f ? *x - 1.0f : *x;
  *y = *y >= 1.0f ? *y - 1.0f : *y;
}

/* Position of sample s of nu * nv, over a square of `support` pixels. pixel = line * pixels_per_line + sample index.
 *   grid:     cell centres, row by row (u fastest)
 *   jittered: a random point in each cell
 *   lattice:  rank-1 golden-ratio lattice (x = (s + 0.5) / N, y = frac(s * 0.6180339887)), shifted per pixel, wrapped,
 *             counted from its left edge, so that samples that follow one another share a strip of the pixel */
RC_INLINE void rc_sample_uv(int kind, int nu, int nv, float support, rc_u32 seed, rc_u32 pixel, int s, float* u,
                            float* v) {
  float x, y;
  if (kind == RC_SAMPLER_LATTICE) {
    rc_lattice_xy(nu * nv, rc_lattice_shift(seed, pixel), s, &x, &y);
  } else {
    const int j = s / nu, i = s - j * nu;
    const float ju = kind == RC_SAMPLER_JITTERED ? rc_unit_float(rc_hash(seed, pixel, (rc_u32)s, 12u)) : 0.5f;
    const float jv = kind == RC_SAMPLER_JITTERED ? rc_unit_float(rc_hash(seed, pixel, (rc_u32)s, 13u)) : 0.5f;
    x = ((float)i + ju) / (float)nu;
    y = ((float)j + jv) / (float)nv;
  }
  *u = (x - 0.5f) * support;
  *v = (y - 0.5f) * support;
}

#endif
