/* The arithmetic of scattering shapes, and what they ask of two directions at a surface. Valid C++20 (double) and
 * OpenCL C 1.2 (float): the same closed forms serve kernels and the reference. */
#ifndef RAYCUBE_KERNELS_MATERIALS_ANGLES_H
#define RAYCUBE_KERNELS_MATERIALS_ANGLES_H

#ifdef __OPENCL_C_VERSION__
typedef float rc_real;
#define RC_REAL(x) x##f
#define RC_TABLE_SPACE global
#define RC_NO_TABLE
#else
#include <cmath>
typedef double rc_real;
#define RC_REAL(x) x
#define RC_TABLE_SPACE
#define RC_NO_TABLE = nullptr
#endif

#define RC_INVERSE_PI RC_REAL(0.318309886183790672)

/* Of a shape, in the order of its entry; where its table lies, if it has one (measured.h). */
typedef struct RcParameters {
  rc_real of[6];
  RC_TABLE_SPACE const float* table RC_NO_TABLE;
} RcParameters;

/* Two unit vectors away from a surface of unit normal n: `in` to where light comes from, `out` to where it goes. */
typedef struct RcAngles {
  rc_real cos_in, cos_out; /* to the normal */
  rc_real cos_half;        /* normal and half vector of the two */
  rc_real sin2_half;       /* square of the sine between them: of narrow lobes the cosine has few digits */
  rc_real cos_turn;        /* in and half vector */
  rc_real sin_in, sin_out; /* to the normal: lengths of their parts in the surface's plane */
  rc_real along, across;   /* of those parts: dot product and length of the cross product */
  rc_real apart2;          /* of those over the cosines, the tangents of both zenith angles: square of their distance */
  /* The half vector along what is east and north on the surface: the map's directions, turned with the vertical into
   * the normal by the shortest way (Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 6(1), 2017); of a
   * surface that faces straight down as they are. */
  rc_real half_east, half_north;
} RcAngles;

/* What a vector of horizontal part `flat`, dot product with that of a unit normal, has along its z there, to be taken
 * from the vector as many times as the normal's horizontal part: flat / (1 + nz), without the loss of digits of normals
 * that face down. n2: square of the normal's horizontal part. */
static inline rc_real rc_turned(rc_real flat, rc_real nz, rc_real n2) {
  if (nz >= 0) return flat / (RC_REAL(1.0) + nz);
  return n2 > 0 ? flat * (RC_REAL(1.0) - nz) / n2 : 0;
}

/* A direction in a frame whose z is the normal. */
typedef struct RcLocal {
  rc_real x, y, z;
} RcLocal;

#ifdef __OPENCL_C_VERSION__
/* From a Lobe record of `lobes`, behind which tables lie. */
static inline RcParameters rc_parameters(global const Lobe* lobes, Lobe lobe) {
  const float* p = lobe.parameter;
  const RcParameters out = {{p[0], p[1], p[2], p[3], p[4], p[5]}, (global const float*)lobes};
  return out;
}

static inline RcAngles rc_angles(float4 normal, float4 in, float4 out) {
  const float4 half_way = normalize(in + out);
  RcAngles a;
  a.cos_in = dot(normal, in);
  a.cos_out = dot(normal, out);
  a.cos_half = fmin(dot(normal, half_way), 1.0f);
  a.cos_turn = clamp(dot(in, half_way), 0.0f, 1.0f);
  const float4 flat_in = in - a.cos_in * normal, flat_out = out - a.cos_out * normal;
  const float4 turn = cross(flat_in, flat_out), apart = flat_in / a.cos_in - flat_out / a.cos_out;
  const float4 beside = half_way - dot(normal, half_way) * normal;
  const float turned = half_way.z + rc_turned(half_way.x * normal.x + half_way.y * normal.y, normal.z,
                                              normal.x * normal.x + normal.y * normal.y);
  a.sin2_half = dot(beside, beside);
  a.sin_in = sqrt(dot(flat_in, flat_in));
  a.sin_out = sqrt(dot(flat_out, flat_out));
  a.along = dot(flat_in, flat_out);
  a.across = sqrt(dot(turn, turn));
  a.apart2 = dot(apart, apart);
  a.half_east = half_way.x - normal.x * turned;
  a.half_north = half_way.y - normal.y * turned;
  return a;
}
#else
/* x, y, z of each in any one frame. */
static inline RcAngles rc_angles(const RcLocal& normal, const RcLocal& in, const RcLocal& out) {
  const auto dot = [](const RcLocal& a, const RcLocal& b) { return a.x * b.x + a.y * b.y + a.z * b.z; };
  const auto along = [](const RcLocal& a, double f, const RcLocal& b) {
    return RcLocal{a.x + f * b.x, a.y + f * b.y, a.z + f * b.z};
  };
  const RcLocal sum = along(in, 1, out);
  const double length = std::sqrt(dot(sum, sum)), over = length > 0 ? 1 / length : 0;
  RcAngles a;
  a.cos_in = dot(normal, in);
  a.cos_out = dot(normal, out);
  a.cos_half = std::fmin(over * dot(normal, sum), 1.0);
  a.cos_turn = std::fmin(std::fmax(over * dot(in, sum), 0.0), 1.0);
  const RcLocal f = along(in, -a.cos_in, normal), g = along(out, -a.cos_out, normal);
  const RcLocal turn{f.y * g.z - f.z * g.y, f.z * g.x - f.x * g.z, f.x * g.y - f.y * g.x};
  const RcLocal tangent = along({0, 0, 0}, 1 / a.cos_in, f), apart = along(tangent, -1 / a.cos_out, g);
  const RcLocal beside = along(sum, -dot(normal, sum), normal);
  const double turned = over * (sum.z + rc_turned(sum.x * normal.x + sum.y * normal.y, normal.z,
                                                  normal.x * normal.x + normal.y * normal.y));
  a.sin2_half = over * over * dot(beside, beside);
  a.sin_in = std::sqrt(dot(f, f));
  a.sin_out = std::sqrt(dot(g, g));
  a.along = dot(f, g);
  a.across = std::sqrt(dot(turn, turn));
  a.apart2 = dot(apart, apart);
  a.half_east = over * sum.x - normal.x * turned;
  a.half_north = over * sum.y - normal.y * turned;
  return a;
}
#endif

/* The same with zenith angles no larger than that of cosine `least`, azimuths as they are: models of ground are not
 * meant to hold towards the horizon. What concerns the half vector stays. */
static inline RcAngles rc_held(RcAngles a, rc_real least) {
  if (a.cos_in >= least && a.cos_out >= least) return a;
  const rc_real in = fmax(a.cos_in, least), out = fmax(a.cos_out, least), one = RC_REAL(1.0);
  const rc_real was = (one - a.cos_in * a.cos_in) * (one - a.cos_out * a.cos_out);
  const rc_real sines = sqrt(fmax((one - in * in) * (one - out * out), RC_REAL(0.0)));
  const rc_real scale = was > 0 ? sines / sqrt(was) : one;
  a.along *= scale;
  a.across *= scale;
  a.apart2 = (one - in * in) / (in * in) + (one - out * out) / (out * out) - RC_REAL(2.0) * a.along / (in * out);
  a.apart2 = fmax(a.apart2, RC_REAL(0.0));
  a.cos_in = in;
  a.cos_out = out;
  return a;
}

/* Directions by the cosine law: pdf cos / pi. */
static inline RcLocal rc_cosine_law(rc_real u, rc_real v) {
  const rc_real r = sqrt(u), angle = RC_REAL(6.283185307179586) * v;
  RcLocal out;
  out.x = r * cos(angle);
  out.y = r * sin(angle);
  out.z = sqrt(RC_REAL(1.0) - u);
  return out;
}

#endif
