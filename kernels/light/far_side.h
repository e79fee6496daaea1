/* The side of a surface that the viewer does not see, where matter lets light through it: a leaf. */
#ifndef RAYCUBE_KERNELS_LIGHT_FAR_SIDE_H
#define RAYCUBE_KERNELS_LIGHT_FAR_SIDE_H

#include "kernels/geometry/lanes.h"
#include "kernels/geometry/scene_arrays.h"
/* Here and not where RC_SHAPED asks for it: a program has each file once. */
#include "kernels/materials/shapes.h"

static inline bool rc_is_leaf(global const Lobe* lobes, uint surface) {
  return RC_THROUGH && lobes[surface * RC_LOBE_STRIDE + RC_LOBE_BEHIND].shape == RC_SHAPE_leaf;
}

/* What such matter lets through goes straight on. */
static inline bool rc_is_plate(global const Lobe* lobes, uint surface) {
  return RC_PLATES && lobes[surface * RC_LOBE_STRIDE + RC_LOBE_BEHIND].shape == RC_SHAPE_plate;
}

#if RC_THROUGH
/* Of a word of samples, bits of those whose surface lets light through; in: its slots of hits. */
static inline uint rc_let_through(SceneArrays scene, global const Lobe* lobes, global const uint* in) {
  uint through = 0;
  for (uint k = 0; k < 16u; ++k) {
    if (in[k] == RC_NONE) continue;
    const uint surface = rc_surface_of(scene, in[RC_PLANE(RC_HIT_PRIMITIVE) + k]);
    through |= rc_is_leaf(lobes, surface) ? 1u << k : 0u;
  }
  return through;
}

/* The planes of shapes in a word's slots: zero is Lambert's law. */
static inline void rc_clear_shapes(global float* surface) {
  for (uint plane = RC_NORMAL_Z + 1; plane < RC_POINT_PLANES; ++plane)
    rc_store16((float16)(0.0f), 0, surface + RC_PLANE(plane));
}
#endif

#endif
