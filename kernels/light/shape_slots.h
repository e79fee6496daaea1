/* What samples' slots hold of scattering shapes (kernels/shared/tile_layout.h): the way to the viewer and which Lobe
 * record is theirs; slots of gloss and of further lobes, which have the near side's point and normal. */
#ifndef RAYCUBE_KERNELS_LIGHT_SHAPE_SLOTS_H
#define RAYCUBE_KERNELS_LIGHT_SHAPE_SLOTS_H

#include "kernels/geometry/lanes.h"
#include "kernels/geometry/scene_arrays.h"
#include "kernels/geometry/surface_side.h"
#include "kernels/shared/tile_layout.h"

#if RC_SHAPED
static inline void rc_store_viewer(Vector16 direction, global float* out) {
  const float16 over = -1.0f / sqrt(rc_dot16(direction, direction));
  rc_store16(over * direction.x, 0, out + RC_PLANE(RC_VIEWER_X));
  rc_store16(over * direction.y, 0, out + RC_PLANE(RC_VIEWER_Y));
  rc_store16(over * direction.z, 0, out + RC_PLANE(RC_VIEWER_Z));
}

/* Way to the viewer and shape of a word of samples; in: its slots of hits. */
static inline void rc_store_shapes(SceneArrays scene, global const uint* in, Vector16 direction, global float* out) {
  rc_store_viewer(direction, out);
  for (uint k = 0; k < 16u; ++k) {
    uint at = 0u;
    if (in[k] != RC_NONE) at = 1u + rc_surface_of(scene, in[RC_PLANE(RC_HIT_PRIMITIVE) + k]) * RC_LOBE_STRIDE;
    out[RC_PLANE(RC_LOBE_AT) + k] = as_float(at);
  }
}
#endif

#if RC_GLOSSY
/* A word's slots of what comes by gloss: of the near side, whose surfaces have one. */
static inline void rc_store_gloss(SceneArrays scene, global const Lobe* lobes, global const uint* in,
                                  Vector16 direction, const SurfaceSide16* near, global float* out,
                                  global float* moved) {
  SurfaceSide16 side;
  uint glossy = 0;
  rc_store_viewer(direction, out);
  for (uint k = 0; k < 16u; ++k) {
    uint at = 0u;
    if (in[k] != RC_NONE) {
      const uint first = rc_surface_of(scene, in[RC_PLANE(RC_HIT_PRIMITIVE) + k]) * RC_LOBE_STRIDE;
      for (uint i = 1; i < RC_LOBE_BEHIND; ++i)
        if (lobes[first + i].share > 0.0f) at = 1u + first + i, glossy |= 1u << k;
    }
    out[RC_PLANE(RC_LOBE_AT) + k] = as_float(at);
  }
  rc_clear_side(&side);
  rc_take_side(near, rc_bits16(glossy), &side);
  rc_store_side(&side, out, moved);
}
#endif

#if RC_FURTHER
/* A word's slots of further lobe `number`: of the near side, whose surfaces have one. */
static inline void rc_store_further(SceneArrays scene, global const Lobe* lobes, global const uint* in,
                                    Vector16 direction, const SurfaceSide16* near, uint number, global float* out,
                                    global float* moved) {
  SurfaceSide16 side;
  uint has = 0;
  rc_store_viewer(direction, out);
  for (uint k = 0; k < 16u; ++k) {
    uint at = 0u;
    if (in[k] != RC_NONE) {
      const uint lobe = rc_surface_of(scene, in[RC_PLANE(RC_HIT_PRIMITIVE) + k]) * RC_LOBE_STRIDE + RC_LOBES + number;
      if (lobes[lobe].share > 0.0f) at = 1u + lobe, has |= 1u << k;
    }
    out[RC_PLANE(RC_LOBE_AT) + k] = as_float(at);
  }
  rc_clear_side(&side);
  rc_take_side(near, rc_bits16(has), &side);
  rc_store_side(&side, out, moved);
}
#endif

#endif
