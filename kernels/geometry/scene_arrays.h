/* The scene's arrays as kernels see them, and the only way to an element: rc_node, rc_block, rc_instance, rc_surface.
 *
 * A device takes buffers up to a limit. An array past half of it comes as 2 to 8 pages of 2^shift elements, each a
 * buffer and a kernel argument of its own, since OpenCL C 1.2 knows no pointers inside buffers. An index counts through
 * all pages, so that ids, leaf bits and the order of ties are the same for any pages.
 *
 * Build option: RC_PAGED, default 0: every array is one buffer, and an access is pointer + index. 1, where some array
 * has several pages: each array takes RC_MOST_PAGES buffers, the first again for pages that it does not have, and its
 * shift, so that scenes of all sizes share one program.
 *
 * A kernel names its arrays as parameters (RC_NODES, RC_BLOCKS, ...) and gathers them first:
 *   kernel void k(RC_NODES, RC_BLOCKS, ...) { SceneArrays scene; RC_GATHER_NODES(scene); RC_GATHER_BLOCKS(scene); ... }
 * and hands them to a function with the same parameters as RC_PASS_NODES, RC_PASS_BLOCKS, ... */
#ifndef RAYCUBE_KERNELS_GEOMETRY_SCENE_ARRAYS_H
#define RAYCUBE_KERNELS_GEOMETRY_SCENE_ARRAYS_H

#include "kernels/shared/structs.h"

#ifndef RC_PAGED
#define RC_PAGED 0
#endif

#if RC_PAGED
#define RC_PAGES RC_MOST_PAGES
#define RC_PARAMETER(type, name)                                                                                    \
  global const type *restrict name##_0, global const type *restrict name##_1, global const type *restrict name##_2, \
      global const type *restrict name##_3, global const type *restrict name##_4,                                   \
      global const type *restrict name##_5, global const type *restrict name##_6,                                   \
      global const type *restrict name##_7, uint name##_shift
#define RC_GATHER(scene, name)                                                                                    \
  (scene).name[0] = name##_0, (scene).name[1] = name##_1, (scene).name[2] = name##_2, (scene).name[3] = name##_3, \
  (scene).name[4] = name##_4, (scene).name[5] = name##_5, (scene).name[6] = name##_6, (scene).name[7] = name##_7, \
  (scene).name##_shift = name##_shift
#define RC_PASS(name) name##_0, name##_1, name##_2, name##_3, name##_4, name##_5, name##_6, name##_7, name##_shift
#else
#define RC_PAGES 1
#define RC_PARAMETER(type, name) global const type* restrict name##_0
#define RC_GATHER(scene, name) (scene).name[0] = name##_0
#define RC_PASS(name) name##_0
#endif

/* What a kernel does not gather must not be read. */
typedef struct SceneArrays {
  global const BvhNode* nodes[RC_PAGES];
  global const TriBlock* blocks[RC_PAGES];
  global const Instance* instances[RC_PAGES];
  global const Surface* surfaces[RC_PAGES];
#if RC_PAGED
  uint nodes_shift, blocks_shift, instances_shift, surfaces_shift;
#endif
} SceneArrays;

#define RC_NODES RC_PARAMETER(BvhNode, nodes)
#define RC_BLOCKS RC_PARAMETER(TriBlock, blocks)
#define RC_INSTANCES RC_PARAMETER(Instance, instances)
#define RC_SURFACES RC_PARAMETER(Surface, surfaces)
#define RC_PASS_NODES RC_PASS(nodes)
#define RC_PASS_BLOCKS RC_PASS(blocks)
#define RC_PASS_INSTANCES RC_PASS(instances)
#define RC_PASS_SURFACES RC_PASS(surfaces)
#define RC_GATHER_NODES(scene) RC_GATHER(scene, nodes)
#define RC_GATHER_BLOCKS(scene) RC_GATHER(scene, blocks)
#define RC_GATHER_INSTANCES(scene) RC_GATHER(scene, instances)
#define RC_GATHER_SURFACES(scene) RC_GATHER(scene, surfaces)

#define RC_LEAF 0x80000000u /* of a child on a stack: a block or an instance, not a node */

/* Place of an element in its page. */
static inline uint rc_page_offset(uint index, uint shift) { return index & ((1u << shift) - 1u); }

static inline global const BvhNode* rc_paged_node(global const BvhNode* const* pages, uint shift, uint index) {
  return RC_PAGED ? pages[index >> shift] + rc_page_offset(index, shift) : pages[0] + index;
}
static inline global const TriBlock* rc_paged_block(global const TriBlock* const* pages, uint shift, uint index) {
  return RC_PAGED ? pages[index >> shift] + rc_page_offset(index, shift) : pages[0] + index;
}
static inline global const Instance* rc_paged_instance(global const Instance* const* pages, uint shift, uint index) {
  return RC_PAGED ? pages[index >> shift] + rc_page_offset(index, shift) : pages[0] + index;
}
static inline global const Surface* rc_paged_surface(global const Surface* const* pages, uint shift, uint index) {
  return RC_PAGED ? pages[index >> shift] + rc_page_offset(index, shift) : pages[0] + index;
}

/* Macros, so that the struct is read where it lies and never copied. */
#if RC_PAGED
#define RC_SHIFT(scene, name) (scene).name##_shift
#else
#define RC_SHIFT(scene, name) 0u
#endif
#define rc_node(scene, index) rc_paged_node((scene).nodes, RC_SHIFT(scene, nodes), (index))
#define rc_block(scene, index) rc_paged_block((scene).blocks, RC_SHIFT(scene, blocks), (index))
#define rc_instance(scene, index) rc_paged_instance((scene).instances, RC_SHIFT(scene, instances), (index))
#define rc_surface(scene, index) rc_paged_surface((scene).surfaces, RC_SHIFT(scene, surfaces), (index))

/* Number of the surface of primitive block * RC_BLOCK + lane; RC_NONE in a lane without a triangle. */
#define rc_surface_of(scene, primitive) (rc_block(scene, (primitive) / RC_BLOCK)->surface[(primitive) % RC_BLOCK])

#endif
