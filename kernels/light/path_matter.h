/* Paths of light, sixteen side by side, and what they ask of matter: by what it scatters, and its curves at the
 * skeleton wavelengths. Nothing here knows which of them is which. */
#ifndef RAYCUBE_KERNELS_LIGHT_PATH_MATTER_H
#define RAYCUBE_KERNELS_LIGHT_PATH_MATTER_H

#include "kernels/light/lobe_albedo.h"
#include "kernels/light/path_ends.h"
#include "kernels/light/sky_map.h"
#include "kernels/shared/product_key.h"
#include "kernels/light/lamps.h" /* last: a program has each file once, and others here want what these bring */

/* What a black body at a material's temperature sends beyond one at the surroundings', over the light of all sources
 * together: the role after all others (plan::Bounces::curve). */
#define RC_CURVE_HEAT RC_CURVE_LEANING(RC_FURTHER_RECORDS)
#define RC_PATH_DIMENSION 25u /* of rc_hash, and the next three */
#define RC_LAMP_DRAW 11u /* after them, and past the photons' and RC_LAMP_DIMENSION: six for each source of lamps */

#define RC_MOST_LAMPS 12 /* sources of lamps */

/* What paths ask of matter and light. */
typedef struct PathTables {
  const TileShape* tile;
  global const Lobe* lobes;           /* [surface][RC_LOBE_STRIDE] */
  global const float4* scattering;    /* [surface]: x chance of the near side, y largest reflectance + transmittance */
  global const float* skeleton_curve; /* [curve - 1][skeleton]; then RC_CURVE_HEAT's where there is heat */
  global const float* source_share;   /* [sun, components][skeleton]: a source's light over that of all */
  global const float* ground_around;  /* [skeleton]: pi times its radiance over the light of all */
  SkyMap sky;
  float4 sun;   /* direction to it */
  float lowest; /* z of the scene, m */
  uint sun_up, levels, seed;
  LampTables lamps;
  global PathStep* log; /* of the group's first pixel */
  uint log_paths;       /* of a pixel, as they are numbered; 0: steps are not handed over */
#if RC_SHAPED
  LobeAlbedos albedos;
#endif
} PathTables;

/* Adds a product to sixteen wavelengths of what is gained. */
static inline void rc_add16(float16 factor, float16 light, float* gained) {
  vstore16(fma(factor, light, vload16(0, gained)), 0, gained);
}

typedef struct Paths16 {
  Rays16 rays;
  float carried[16][RC_SKELETON];
  float gained[16][(1 + RC_MOST_LAMPS) * RC_SKELETON]; /* of all sources but lamps, then of each of those */
  float reach[16];           /* bound of what is carried: product of the surfaces' largest R + T */
  float scale[16];           /* samples that the path stands for, times their weight */
  uint pixel[16], part[16];  /* of the group; part of its samples */
  uint number[16], path[16]; /* of the pixel in the image, of the path in the pixel: for draws */
  uint count;
  uint live; /* bit of each path whose first ray met a surface; of the others the gain is whole */
  Ends16 ends;
  uint went[16]; /* side by which each went on last */
} RC_LINE Paths16;

#if RC_GLOSSY
static inline bool rc_glossy(const PathTables* t, uint surface) { return t->scattering[surface].z > 0.0f; }
#endif

/* Factors of the further lobes by which a side of a surface scatters, [further]: `scale` times how many times
 * Lambert's radiance goes from `in` to `out`. 0 where there are none. */
static inline void rc_more_factors(const PathTables* t, uint surface, uint side, float4 normal, float4 in, float4 out,
                                   float scale, float* more) {
#if RC_FURTHER
  for (uint number = 0; number < t->tile->further; ++number) {
    const Lobe lobe = t->lobes[surface * RC_LOBE_STRIDE + RC_LOBES + number];
    more[number] = 0.0f;
    const uint role = side == RC_GLOSS_SIDE ? RC_ROLE_gloss : RC_ROLE_front;
    if (side != RC_FAR_SIDE && lobe.share > 0.0f && (uint)rc_shape_role(lobe.shape) == role)
      more[number] =
          scale * rc_shape_eval(lobe.shape, 3.14159265f, rc_parameters(t->lobes, lobe), rc_angles(normal, in, out));
  }
#endif
}

static inline float16 rc_curve_at(const PathTables* t, uint role, uint material, uint m) {
  const uint id = rc_curve_id(role, material, t->tile->materials);
  return vload16(0, t->skeleton_curve + (size_t)(id - 1u) * t->tile->skeleton + m);
}

/* What of light that falls onto a side leaves by scattering, at the skeleton wavelengths, times what is carried.
 * more: factors of further lobes, as `factor` is the first one's; read where there are any. */
static inline void rc_carry_on(SceneArrays scene, const PathTables* t, uint surface, uint side, float factor,
                               const float* more, const float* carried, float* out) {
  global const Surface* s = rc_surface(scene, surface);
  for (uint m = 0; m < t->tile->skeleton; m += RC_WORD) {
    float16 curve = 0.0f;
    for (uint i = 0; i < 4u; ++i) {
      if (s->material[i] == 0u || s->fraction[i] == 0.0f) continue;
      curve = fma((float16)(s->fraction[i]), rc_curve_at(t, rc_curve_of_side(side), s->material[i] - 1u, m), curve);
    }
#if RC_FURTHER
    curve *= factor;
    for (uint i = 0; i < 4u * t->tile->further; ++i) {
      const uint material = s->material[i % 4u], number = i / 4u;
      if (material == 0u || more[number] == 0.0f) continue;
      curve = fma((float16)(more[number] * s->fraction[i % 4u]),
                  rc_curve_at(t, RC_CURVE_FURTHER + number, material - 1u, m), curve);
    }
    vstore16(curve * vload16(0, carried + m), 0, out + m);
#else
    vstore16(factor * curve * vload16(0, carried + m), 0, out + m);
#endif
  }
}

/* number: of the pixel in the image; path: in the pixel. */
static inline float rc_path_draw(const PathTables* t, uint number, uint path, uint level, uint what) {
  return rc_unit_float(rc_hash(t->seed, number, (path << 8) + level, RC_PATH_DIMENSION + what));
}

#endif
