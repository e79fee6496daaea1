/* Every shape of materials.def by its number: which is which, and one call for all. Valid C++20 and OpenCL C 1.2. */
#ifndef RAYCUBE_KERNELS_MATERIALS_SHAPES_H
#define RAYCUBE_KERNELS_MATERIALS_SHAPES_H

#include "kernels/materials/materials.def"

#define RC_SHAPE_TABLE(name, text, source)
#define RC_SHAPE_PARAMETER(name, index, key, unit, low, high, text)
#define RC_SHAPE_CURVE(name, index)
enum {
#define RC_SHAPE(name, role, reciprocal, conserves, text) RC_SHAPE_##name,
#include "kernels/materials/materials.def"
#undef RC_SHAPE
  RC_SHAPE_COUNT,
  RC_SHAPE_none = RC_SHAPE_COUNT
};

enum { RC_ROLE_front, RC_ROLE_behind, RC_ROLE_gloss };
static inline unsigned int rc_shape_role(unsigned int shape) {
  switch (shape) {
#define RC_SHAPE(name, role, reciprocal, conserves, text) \
  case RC_SHAPE_##name:                                   \
    return RC_ROLE_##role;
#include "kernels/materials/materials.def"
#undef RC_SHAPE
    default:
      return RC_ROLE_front;
  }
}

static inline rc_real rc_shape_eval(unsigned int shape, rc_real scale, RcParameters p, RcAngles angles) {
  switch (shape) {
#define RC_SHAPE(name, role, reciprocal, conserves, text) \
  case RC_SHAPE_##name:                                   \
    return rc_##name##_eval(scale, p, angles);
#include "kernels/materials/materials.def"
#undef RC_SHAPE
    default:
      return 0;
  }
}

static inline RcLocal rc_shape_sample(unsigned int shape, RcParameters p, RcLocal in, rc_real u, rc_real v) {
  switch (shape) {
#define RC_SHAPE(name, role, reciprocal, conserves, text) \
  case RC_SHAPE_##name:                                   \
    return rc_##name##_sample(p, in, u, v);
#include "kernels/materials/materials.def"
#undef RC_SHAPE
    default:
      return in;
  }
}

static inline rc_real rc_shape_pdf(unsigned int shape, RcParameters p, RcAngles angles) {
  switch (shape) {
#define RC_SHAPE(name, role, reciprocal, conserves, text) \
  case RC_SHAPE_##name:                                   \
    return rc_##name##_pdf(p, angles);
#include "kernels/materials/materials.def"
#undef RC_SHAPE
    default:
      return 0;
  }
}

/* Of shapes of role gloss; 0, or what they are, of others. */
#define RC_SHAPE(name, role, reciprocal, conserves, text) RC_CASE_OF_##role(name)
#define RC_CASE_OF_front(name)
#define RC_CASE_OF_behind(name)
static inline rc_real rc_shape_mirrored(unsigned int shape, RcParameters p, rc_real cosine) {
  switch (shape) {
#define RC_CASE_OF_gloss(name) \
  case RC_SHAPE_##name:        \
    return rc_##name##_mirrored(p, cosine);
#include "kernels/materials/materials.def"
#undef RC_CASE_OF_gloss
    default:
      return 0;
  }
}

static inline rc_real rc_shape_roughness(unsigned int shape, RcParameters p) {
  switch (shape) {
#define RC_CASE_OF_gloss(name) \
  case RC_SHAPE_##name:        \
    return rc_##name##_roughness(p);
#include "kernels/materials/materials.def"
#undef RC_CASE_OF_gloss
    default:
      return 0;
  }
}
static inline RcParameters rc_shape_widened(unsigned int shape, RcParameters p, rc_real least) {
  switch (shape) {
#define RC_CASE_OF_gloss(name) \
  case RC_SHAPE_##name:        \
    return rc_##name##_widened(p, least);
#include "kernels/materials/materials.def"
#undef RC_CASE_OF_gloss
    default:
      return p;
  }
}
#undef RC_SHAPE
#undef RC_CASE_OF_front
#undef RC_CASE_OF_behind
#undef RC_SHAPE_TABLE
#undef RC_SHAPE_PARAMETER
#undef RC_SHAPE_CURVE

#endif
