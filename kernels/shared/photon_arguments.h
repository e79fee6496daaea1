/* Arguments of trace_photons (kernels/shared/arguments.h). */
#ifndef RAYCUBE_KERNELS_SHARED_PHOTON_ARGUMENTS_H
#define RAYCUBE_KERNELS_SHARED_PHOTON_ARGUMENTS_H

#include "kernels/shared/arguments.h"

/* clang-format off */
#define RC_TRACE_PHOTONS_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) \
  SCENE(BvhNode, nodes, NODES) NEXT() \
  SCENE(TriBlock, blocks, BLOCKS) NEXT() \
  SCENE(Instance, instances, INSTANCES) NEXT() \
  READ(Lobe, lobes) NEXT()            /* [surface][RC_LOBE_STRIDE], read where RC_SHAPED or RC_THROUGH */ \
  READ(rc_float4, scattering) NEXT()  /* [surface]: x chance of the near side, y largest R + T, z of gloss */ \
  VALUE(rc_uint, count) NEXT() \
  VALUE(rc_uint, level) NEXT()        /* surfaces met, this one counted: from the third on some end by chance */ \
  VALUE(rc_uint, seed) NEXT() \
  WRITE(Photon, photons)
/* clang-format on */

#endif
