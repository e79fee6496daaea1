/* Gas and particles along a straight piece of a ray. Valid C++20 and OpenCL C 1.2, float. What a volume holds is its
 * field:
 *   box    1 inside
 *   grid   its values, at cell centres, trilinear between; the outer half cells keep the border's value, so that the
 *   sum of
 *          values times cell volume is what the box holds; 0 outside
 *   plume  concentration in g/m3: Q/(2 pi u sy sz) exp(-y^2/2 sy^2) [exp(-(z-H)^2/2 sz^2) + exp(-(z+H)^2/2 sz^2)],
 *   above its foot
 * Gas has strength.x ppm at a field of 1, particles have particles.x extinction per metre. */
#ifndef RAYCUBE_KERNELS_LIDAR_VOLUME_H
#define RAYCUBE_KERNELS_LIDAR_VOLUME_H

#include "kernels/shared/structs.h"

#ifdef __OPENCL_C_VERSION__
#define RC_VOLUME_GLOBAL global
#define RC_VOLUME_POINT float4
#else
#include <cmath>
#define RC_VOLUME_GLOBAL
#define RC_VOLUME_POINT rc_float4
namespace raycube::shared {
using std::exp, std::fabs, std::floor, std::fma, std::fmax, std::fmin, std::sqrt;
#endif

#define RC_PLUME_START_M 1e-3f /* the law's widths vanish at the source itself */
#define RC_PLUME_PANELS 160

/* A ray in the volume's frame, and the part of it in question: p + t d, first <= t <= last. */
typedef struct VolumeRay {
  float px, py, pz, dx, dy, dz, first, last;
} VolumeRay;

static inline void rc_volume_clip(float p, float d, float lo, float hi, float* first, float* last) {
  if (fabs(d) < 1e-12f) {
    if (p < lo || p > hi) *last = *first - 1.0f;
    return;
  }
  const float a = (lo - p) / d, b = (hi - p) / d;
  *first = fmax(*first, fmin(a, b));
  *last = fmin(*last, fmax(a, b));
}

/* Counts from the point between t0 and t1 nearest to the middle of the volume: a chord then has the precision of its
 * own or of the volume's length, not of the ray's way to it. first > last when the ray misses. */
static inline VolumeRay rc_volume_ray(RC_VOLUME_GLOBAL const LidarVolume* volume, RC_VOLUME_POINT origin,
                                      RC_VOLUME_POINT direction_unit, float t0, float t1) {
  const float c = volume->lo.w, s = volume->hi.w;
  const float ox = origin.x - volume->place.x, oy = origin.y - volume->place.y, oz = origin.z - volume->place.z;
  VolumeRay ray;
  ray.px = fma(c, ox, -s * oy), ray.py = fma(s, ox, c * oy), ray.pz = oz;
  ray.dx = fma(c, direction_unit.x, -s * direction_unit.y), ray.dy = fma(s, direction_unit.x, c * direction_unit.y),
  ray.dz = direction_unit.z;
  const float mx = 0.5f * (volume->lo.x + volume->hi.x), my = 0.5f * (volume->lo.y + volume->hi.y),
              mz = 0.5f * (volume->lo.z + volume->hi.z);
  const float t = fmin(fmax((mx - ray.px) * ray.dx + (my - ray.py) * ray.dy + (mz - ray.pz) * ray.dz, t0), t1);
  ray.px = fma(t, ray.dx, ray.px), ray.py = fma(t, ray.dy, ray.py), ray.pz = fma(t, ray.dz, ray.pz);
  ray.first = t0 - t, ray.last = t1 - t;
  rc_volume_clip(ray.px, ray.dx, volume->lo.x, volume->hi.x, &ray.first, &ray.last);
  rc_volume_clip(ray.py, ray.dy, volume->lo.y, volume->hi.y, &ray.first, &ray.last);
  rc_volume_clip(ray.pz, ray.dz, volume->lo.z, volume->hi.z, &ray.first, &ray.last);
  return ray;
}

/* One axis of a trilinear value: lower node and the share of the upper one. x: in cells from the first centre. */
static inline int rc_grid_node(float x, rc_uint cells, float* share) {
  const float last = (float)(cells - 1u), at = fmin(fmax(x, 0.0f), last);
  const int node = (int)fmin(floor(at), fmax(last - 1.0f, 0.0f));
  *share = at - (float)node;
  return node;
}

static inline float rc_grid_value(RC_VOLUME_GLOBAL const LidarVolume* volume, RC_VOLUME_GLOBAL const float* grid_values,
                                  float x, float y, float z) {
  float fx, fy, fz;
  const int i = rc_grid_node(x, volume->cells[0], &fx), j = rc_grid_node(y, volume->cells[1], &fy),
            k = rc_grid_node(z, volume->cells[2], &fz);
  const int row = (int)volume->cells[0], layer = row * (int)volume->cells[1];
  const int right = row > 1 ? 1 : 0, ahead = volume->cells[1] > 1u ? row : 0, above = volume->cells[2] > 1u ? layer : 0;
  RC_VOLUME_GLOBAL const float* v = grid_values + volume->first_value + (k * layer + j * row + i);
  const float a = v[0] + fx * (v[right] - v[0]), b = v[ahead] + fx * (v[ahead + right] - v[ahead]);
  v += above;
  const float e = v[0] + fx * (v[right] - v[0]), f = v[ahead] + fx * (v[ahead + right] - v[ahead]);
  const float low = a + fy * (b - a), high = e + fy * (f - e);
  return low + fz * (high - low);
}

/* Distance to the next plane of cell centres along an axis, and its step to the one after; 1e30: none. */
static inline float rc_grid_next(float g, float dg, rc_uint cells, float at) {
  const float x = g + at * dg;
  const float plane = dg > 0.0f ? fmax(floor(x) + 1.0f, 0.0f) : fmin(-floor(-x) - 1.0f, (float)(cells - 1u));
  if (fabs(dg) < 1e-12f || plane > (float)(cells - 1u) || plane < 0.0f) return 1e30f;
  return (plane - g) / dg;
}

/* Between planes of cell centres the field is a cubic along the ray, which Simpson's rule integrates exactly. */
static inline float rc_grid_path(RC_VOLUME_GLOBAL const LidarVolume* volume, RC_VOLUME_GLOBAL const float* grid_values,
                                 const VolumeRay* ray) {
  const float nx = (float)volume->cells[0] / (volume->hi.x - volume->lo.x),
              ny = (float)volume->cells[1] / (volume->hi.y - volume->lo.y);
  const float nz = (float)volume->cells[2] / (volume->hi.z - volume->lo.z);
  const float gx = (ray->px - volume->lo.x) * nx - 0.5f, gy = (ray->py - volume->lo.y) * ny - 0.5f,
              gz = (ray->pz - volume->lo.z) * nz - 0.5f;
  const float dx = ray->dx * nx, dy = ray->dy * ny, dz = ray->dz * nz;
  float tx = rc_grid_next(gx, dx, volume->cells[0], ray->first),
        ty = rc_grid_next(gy, dy, volume->cells[1], ray->first);
  float tz = rc_grid_next(gz, dz, volume->cells[2], ray->first);
  const float sx = 1.0f / fabs(dx), sy = 1.0f / fabs(dy), sz = 1.0f / fabs(dz);
  float t = ray->first, sum = 0.0f, from = rc_grid_value(volume, grid_values, gx + t * dx, gy + t * dy, gz + t * dz);
  const int most = (int)(volume->cells[0] + volume->cells[1] + volume->cells[2]) + 4;
  for (int i = 0; i < most && t < ray->last; ++i) {
    const float to_t = fmin(fmin(tx, ty), fmin(tz, ray->last)), mid = 0.5f * (t + to_t);
    const float middle = rc_grid_value(volume, grid_values, gx + mid * dx, gy + mid * dy, gz + mid * dz);
    const float to = rc_grid_value(volume, grid_values, gx + to_t * dx, gy + to_t * dy, gz + to_t * dz);
    if (to_t > t) sum += (to_t - t) * (from + 4.0f * middle + to);
    if (tx <= to_t) tx += sx;
    if (ty <= to_t) ty += sy;
    if (tz <= to_t) tz += sz;
    t = fmax(t, to_t), from = to;
  }
  return sum * (1.0f / 6.0f);
}

static inline float rc_plume_sigma(float x, float a, float b, float fixed) {
  return fixed > 0.0f ? fixed : a * x / sqrt(1.0f + b * x);
}

static inline float rc_plume_value(RC_VOLUME_GLOBAL const LidarVolume* volume, float across, float downwind, float up) {
  const float x = fmax(downwind, RC_PLUME_START_M);
  const float sy = rc_plume_sigma(x, volume->spread.x, volume->spread.y, volume->fixed.x),
              sz = rc_plume_sigma(x, volume->spread.z, volume->spread.w, volume->fixed.y);
  const float y = across / sy, below = (up - volume->place.w) / sz, above = (up + volume->place.w) / sz;
  return volume->strength.y / (sy * sz) * exp(-0.5f * y * y) *
         (exp(-0.5f * below * below) + exp(-0.5f * above * above));
}

/* Gauss-Legendre panels of five points, each at most 1.25 widths long and a third of the way to the source: a bell's
 * relative error is 5e-9 a panel ((b-a)^11 (5!)^4 / (11 (10!)^3) times the tenth derivative, at most 945). Stretches
 * further than 6.5 widths from the axis are stepped over: the widths grow by no more than fixed.z and .w a metre. */
static inline float rc_plume_path(RC_VOLUME_GLOBAL const LidarVolume* volume, const VolumeRay* ray) {
  const float node1 = 0.5384693101f, node2 = 0.9061798459f, weight0 = 0.5688888889f, weight1 = 0.4786286705f,
              weight2 = 0.2369268851f;
  const float h = volume->place.w, ax = fabs(ray->dx), ay = fabs(ray->dy), az = fabs(ray->dz);
  const float narrows = volume->fixed.x > 0.0f && volume->fixed.y > 0.0f ? 0.0f : 3.75f;
  float t = ray->first, sum = 0.0f;
  for (int i = 0; i < RC_PLUME_PANELS && t < ray->last; ++i) {
    const float x = fmax(ray->py + t * ray->dy, RC_PLUME_START_M), y = fabs(ray->px + t * ray->dx),
                z = ray->pz + t * ray->dz;
    const float sy = rc_plume_sigma(x, volume->spread.x, volume->spread.y, volume->fixed.x),
                sz = rc_plume_sigma(x, volume->spread.z, volume->spread.w, volume->fixed.y);
    const float off_y = y - RC_PLUME_WIDTHS * sy, off_z = fmax(z - h, fmin(h - z, h + z)) - RC_PLUME_WIDTHS * sz;
    const float skip = fmax(off_y / fmax(ax + RC_PLUME_WIDTHS * volume->fixed.z * ay, 1e-12f),
                            off_z / fmax(az + RC_PLUME_WIDTHS * volume->fixed.w * ay, 1e-12f));
    const float u = ax / sy, v = az / sz, w = narrows * ay / x;
    const float left = ray->last - t, step = fmin(1.25f / fmax(sqrt(u * u + v * v + w * w), 1e-12f), left);
    if (skip > step) {
      t += fmin(skip, left);
      if (skip >= left) break;
      continue;
    }
    const float half_m = i + 1 < RC_PLUME_PANELS ? 0.5f * step : 0.5f * left, m = t + half_m;
    float panel = weight0 * rc_plume_value(volume, ray->px + m * ray->dx, ray->py + m * ray->dy, ray->pz + m * ray->dz);
    for (int side = -1; side <= 1; side += 2) {
      const float a = m + (float)side * node1 * half_m, b = m + (float)side * node2 * half_m;
      panel += weight1 * rc_plume_value(volume, ray->px + a * ray->dx, ray->py + a * ray->dy, ray->pz + a * ray->dz);
      panel += weight2 * rc_plume_value(volume, ray->px + b * ray->dx, ray->py + b * ray->dy, ray->pz + b * ray->dz);
    }
    sum += half_m * panel;
    if (step >= left) break;
    t += step;
  }
  return sum;
}

/* Integral of the field along origin + t direction, t0 <= t <= t1 (m; a plume: g/m2). direction_unit has length 1. */
static inline float rc_volume_path(RC_VOLUME_GLOBAL const LidarVolume* volume,
                                   RC_VOLUME_GLOBAL const float* grid_values, RC_VOLUME_POINT origin,
                                   RC_VOLUME_POINT direction_unit, float t0, float t1) {
  VolumeRay ray = rc_volume_ray(volume, origin, direction_unit, t0, t1);
  if (!(ray.first < ray.last)) return 0.0f;
  if (volume->shape == RC_VOLUME_BOX) return ray.last - ray.first;
  if (volume->shape == RC_VOLUME_GRID) return rc_grid_path(volume, grid_values, &ray);
  /* The bounds are as wide as the plume at its end: narrow them to its width where the ray is. */
  const float x = fmax(fmax(ray.py + ray.first * ray.dy, ray.py + ray.last * ray.dy), RC_PLUME_START_M),
              h = volume->place.w;
  const float sy = RC_PLUME_WIDTHS * rc_plume_sigma(x, volume->spread.x, volume->spread.y, volume->fixed.x);
  const float sz = RC_PLUME_WIDTHS * rc_plume_sigma(x, volume->spread.z, volume->spread.w, volume->fixed.y);
  rc_volume_clip(ray.px, ray.dx, -sy, sy, &ray.first, &ray.last);
  rc_volume_clip(ray.pz, ray.dz, fmax(h - sz, 0.0f), h + sz, &ray.first, &ray.last);
  return ray.first < ray.last ? rc_plume_path(volume, &ray) : 0.0f;
}

#ifndef __OPENCL_C_VERSION__
} /* namespace raycube::shared */
#endif
#endif
