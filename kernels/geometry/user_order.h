/* Which of two hits at one distance is taken: by the user's order, not by that of the trees. */
#ifndef RAYCUBE_KERNELS_GEOMETRY_USER_ORDER_H
#define RAYCUBE_KERNELS_GEOMETRY_USER_ORDER_H

#include "kernels/geometry/scene_arrays.h"

/* The user's number of the placement that a triangle of a placed tree belongs to. */
static inline uint rc_placement_of(SceneArrays scene, uint instance, uint primitive) {
  return rc_instance(scene, instance)->placement +
         rc_block(scene, primitive / RC_BLOCK)->placed_after[primitive % RC_BLOCK];
}

/* Whether a hit goes before another at its distance: what was placed earlier, in one placement the triangle that stands
 * earlier in its mesh. Any hit goes before none (than_instance RC_NONE). scene_compiler/owner.h does the same. */
static inline bool rc_user_before(SceneArrays scene, uint instance, uint primitive, uint than_instance,
                                  uint than_primitive) {
  if (than_instance == RC_NONE) return true;
  const uint placement = rc_placement_of(scene, instance, primitive),
             than = rc_placement_of(scene, than_instance, than_primitive);
  if (placement != than) return placement < than;
  return rc_block(scene, primitive / RC_BLOCK)->triangle[primitive % RC_BLOCK] <
         rc_block(scene, than_primitive / RC_BLOCK)->triangle[than_primitive % RC_BLOCK];
}

#endif
