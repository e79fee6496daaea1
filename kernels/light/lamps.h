/* Light of lamps on a point of a surface: of each source one lamp is drawn, about as likely as what it sends there
 * unhindered, and one point of it. Lambert's law of distances, E = I cos / d^2; nothing absorbs on the way. Without
 * shadows the estimate of points and spots on Lambertian surfaces has no noise. */
#ifndef RAYCUBE_KERNELS_LIGHT_LAMPS_H
#define RAYCUBE_KERNELS_LIGHT_LAMPS_H

#include "kernels/geometry/any_hit.h"
#include "kernels/sampling/lamp_draws.h"
#include "kernels/sampling/sky_rays.h"
#include "kernels/shared/structs.h"

#define RC_KEPT_CHANCES 64u /* lamps of a source whose chances are not worked out twice */

typedef struct LampTables {
  global const Lamp* lamps;
  global const uint* first; /* of each source, and the end */
  global const float* distribution;
} LampTables;

/* What a draw said; of no light irradiance is 0. */
typedef struct LampDraw {
  float4 at;        /* m, scene frame: the lamp's point */
  float4 direction; /* unit, to there */
  float clear;      /* m, before it, where nothing hides it */
  float irradiance; /* if nothing is in the way, over the chance that it was drawn */
} LampDraw;

/* Index of the interval of `count` ascending nodes that x lies in, and how far along it; outside, at its end. */
static inline uint rc_interval(global const float* nodes, uint count, float x, float* along) {
  uint low = 0, high = count - 1u;
  while (high - low > 1u) {
    const uint middle = (low + high) / 2u;
    if (nodes[middle] <= x)
      low = middle;
    else
      high = middle;
  }
  *along = clamp((x - nodes[low]) / (nodes[high] - nodes[low]), 0.0f, 1.0f);
  return low;
}

/* Intensity over the largest one, of a direction that the lamp shines to (unit). */
static inline float rc_lamp_shines(const LampTables* t, global const Lamp* lamp, float4 to) {
  const float up = dot(lamp->axis.xyz, to.xyz);
  if (lamp->shape == RC_LAMP_SPOT) {
    const float in = clamp((up - lamp->along.w) / (lamp->across.w - lamp->along.w), 0.0f, 1.0f);
    return in * in;
  }
  if (lamp->verticals == 0u) return 1.0f;
  const uint rows = lamp->verticals, columns = lamp->horizontals;
  global const float* vertical = t->distribution + lamp->distribution;
  global const float* horizontal = vertical + rows;
  global const float* value = horizontal + columns;
  const float angle = acos(clamp(up, -1.0f, 1.0f)) * 57.2957795f;
  if (angle < vertical[0] || angle > vertical[rows - 1u]) return 0.0f;
  float f, g = 0.0f;
  const uint v = rc_interval(vertical, rows, angle, &f);
  uint h = 0u;
  if (columns > 1u) {
    const float turn = atan2(dot(lamp->along.xyz, to.xyz), dot(lamp->across.xyz, to.xyz)) * 57.2957795f;
    h = rc_interval(horizontal, columns, turn < 0.0f ? turn + 360.0f : turn, &g);
  }
  global const float* near = value + h * rows + v;
  global const float* far = near + (columns > 1u ? rows : 0u);
  return mix(mix(near[0], near[1], f), mix(far[0], far[1], f), g);
}

/* What a lamp sends onto a point of a surface of this normal, at most about: above 0 wherever some of its light may
 * come there. */
static inline float rc_lamp_chance(const LampTables* t, global const Lamp* lamp, float4 point, float4 normal) {
  const float4 way = (float4)(lamp->position.xyz - point.xyz, 0.0f);
  const float d2 = dot(way.xyz, way.xyz), radius = lamp->axis.w;
  if (!(d2 > 0.0f)) return 0.0f;
  const float4 to = way * rsqrt(d2);
  const float wide = radius * rsqrt(d2);
  const float facing = fmin(dot(to.xyz, normal.xyz) + wide, 1.0f);
  if (!(facing > 0.0f)) return 0.0f;
  const float sent =
      lamp->shape < RC_LAMP_RECTANGLE ? rc_lamp_shines(t, lamp, -to) : fmin(-dot(to.xyz, lamp->axis.xyz) + wide, 1.0f);
  return sent > 0.0f ? lamp->position.w * sent * facing / (d2 + radius * radius) : 0.0f;
}

/* Of a source's lamps, for u, v and w uniform in [0, 1). */
static inline LampDraw rc_draw_lamp(const LampTables* t, uint source, float4 point, float4 normal, float u, float v,
                                    float w) {
  LampDraw out;
  out.irradiance = out.clear = 0.0f, out.at = out.direction = (float4)(0.0f, 0.0f, 1.0f, 0.0f);
  float all = 0.0f;
  const uint first = t->first[source], end = t->first[source + 1u];
  float kept[RC_KEPT_CHANCES];
  for (uint i = first; i < end; ++i) {
    const float here = rc_lamp_chance(t, t->lamps + i, point, normal);
    if (i - first < RC_KEPT_CHANCES) kept[i - first] = here;
    all += here;
  }
  if (!(all > 0.0f)) return out;
  const float wanted = u * all;
  float so_far = 0.0f, chance = 0.0f;
  uint drawn = first;
  for (uint i = first; i < end && !(so_far > wanted); ++i) {
    const float here = i - first < RC_KEPT_CHANCES ? kept[i - first] : rc_lamp_chance(t, t->lamps + i, point, normal);
    if (here > 0.0f) drawn = i, chance = here;
    so_far += here;
  }
  global const Lamp* lamp = t->lamps + drawn;
  out.at = (float4)(lamp->position.xyz, 0.0f);
  const bool flat = lamp->shape >= RC_LAMP_RECTANGLE;
  if (flat) {
    float a = 2.0f * v - 1.0f, b = 2.0f * w - 1.0f;
    if (lamp->shape == RC_LAMP_DISC) {
      const float r = sqrt(v);
      rc_turn(w, &a, &b);
      a *= r, b *= r;
    }
    out.at += (float4)(a * lamp->across.xyz + b * lamp->along.xyz, 0.0f);
  }
  const float4 way = out.at - (float4)(point.xyz, 0.0f);
  const float d2 = dot(way.xyz, way.xyz);
  if (!(d2 > 0.0f)) return out;
  out.direction = way / sqrt(d2);
  const float facing = dot(out.direction.xyz, normal.xyz);
  const float sent = flat ? -dot(out.direction.xyz, lamp->axis.xyz) : rc_lamp_shines(t, lamp, -out.direction);
  if (!(facing > 0.0f) || !(sent > 0.0f)) return out;
  out.clear = lamp->clear;
  out.irradiance = lamp->position.w * sent * facing / d2 * (all / chance);
  return out;
}

/* Whether anything lies between a point off a surface and the lamp that was drawn there. Not inlined, for compile time.
 */
__attribute__((noinline)) static bool rc_lamp_hidden(SceneArrays scene, float4 from, LampDraw lamp) {
  const float4 way = (float4)(lamp.at.xyz - from.xyz, 0.0f);
  return rc_any_before(scene, 0u, from, way, 1.0f - lamp.clear / length(way.xyz), RC_NONE);
}

#endif
