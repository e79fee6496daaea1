/* The scene's arrays as kernels see them, and the only way to an element: rc_node, rc_block, rc_instance, rc_surface.
 *
 * A device takes buffers up to a limit. An array past half of it comes as 2 to 8 pages of 2^SHIFT elements, each a
 * buffer and a kernel argument of its own, since OpenCL C 1.2 knows no pointers inside buffers. An index counts through
 * all pages, so that ids, leaf bits and the order of ties are the same for any pages; where one page suffices, an
 * access is pointer + index.
 *
 * Build options, for each array (NODE, BLOCK, INSTANCE, SURFACE):
 *   RC_NODE_PAGES   1 .. 8; default 1
 *   RC_NODE_SHIFT   log2 of a page's elements; needed when there are several pages
 * A kernel names its arrays as parameters (RC_NODES, RC_BLOCKS, ...: as many arguments as pages) and gathers them
 * first:
 *   kernel void k(RC_NODES, RC_BLOCKS, ...) { SceneArrays scene; RC_GATHER_NODES(scene); RC_GATHER_BLOCKS(scene); ... }
 * and hands them to a function with the same parameters as RC_PASS_NODES, RC_PASS_BLOCKS, ... */
#ifndef RAYCUBE_KERNELS_GEOMETRY_SCENE_ARRAYS_H
#define RAYCUBE_KERNELS_GEOMETRY_SCENE_ARRAYS_H

#include "kernels/shared/structs.h"

#ifndef RC_NODE_PAGES
#define RC_NODE_PAGES 1
#define RC_NODE_SHIFT 0
#endif
#ifndef RC_BLOCK_PAGES
#define RC_BLOCK_PAGES 1
#define RC_BLOCK_SHIFT 0
#endif
#ifndef RC_INSTANCE_PAGES
#define RC_INSTANCE_PAGES 1
#define RC_INSTANCE_SHIFT 0
#endif
#ifndef RC_SURFACE_PAGES
#define RC_SURFACE_PAGES 1
#define RC_SURFACE_SHIFT 0
#endif

/* What a kernel does not gather must not be read. */
typedef struct SceneArrays {
  global const BvhNode* nodes[RC_NODE_PAGES];
  global const TriBlock* blocks[RC_BLOCK_PAGES];
  global const Instance* instances[RC_INSTANCE_PAGES];
  global const Surface* surfaces[RC_SURFACE_PAGES];
} SceneArrays;

#define RC_PARAMETER_1(type, name) global const type* restrict name##_0
#define RC_PARAMETER_2(type, name) RC_PARAMETER_1(type, name), global const type* restrict name##_1
#define RC_PARAMETER_3(type, name) RC_PARAMETER_2(type, name), global const type* restrict name##_2
#define RC_PARAMETER_4(type, name) RC_PARAMETER_3(type, name), global const type* restrict name##_3
#define RC_PARAMETER_5(type, name) RC_PARAMETER_4(type, name), global const type* restrict name##_4
#define RC_PARAMETER_6(type, name) RC_PARAMETER_5(type, name), global const type* restrict name##_5
#define RC_PARAMETER_7(type, name) RC_PARAMETER_6(type, name), global const type* restrict name##_6
#define RC_PARAMETER_8(type, name) RC_PARAMETER_7(type, name), global const type* restrict name##_7
#define RC_GATHER_1(scene, name) (scene).name[0] = name##_0
#define RC_GATHER_2(scene, name) RC_GATHER_1(scene, name), (scene).name[1] = name##_1
#define RC_GATHER_3(scene, name) RC_GATHER_2(scene, name), (scene).name[2] = name##_2
#define RC_GATHER_4(scene, name) RC_GATHER_3(scene, name), (scene).name[3] = name##_3
#define RC_GATHER_5(scene, name) RC_GATHER_4(scene, name), (scene).name[4] = name##_4
#define RC_GATHER_6(scene, name) RC_GATHER_5(scene, name), (scene).name[5] = name##_5
#define RC_GATHER_7(scene, name) RC_GATHER_6(scene, name), (scene).name[6] = name##_6
#define RC_GATHER_8(scene, name) RC_GATHER_7(scene, name), (scene).name[7] = name##_7
#define RC_PASS_1(name) name##_0
#define RC_PASS_2(name) RC_PASS_1(name), name##_1
#define RC_PASS_3(name) RC_PASS_2(name), name##_2
#define RC_PASS_4(name) RC_PASS_3(name), name##_3
#define RC_PASS_5(name) RC_PASS_4(name), name##_4
#define RC_PASS_6(name) RC_PASS_5(name), name##_5
#define RC_PASS_7(name) RC_PASS_6(name), name##_6
#define RC_PASS_8(name) RC_PASS_7(name), name##_7
#define RC_JOINED(a, b) a##b
#define RC_JOIN(a, b) RC_JOINED(a, b)

#define RC_NODES RC_JOIN(RC_PARAMETER_, RC_NODE_PAGES)(BvhNode, nodes)
#define RC_BLOCKS RC_JOIN(RC_PARAMETER_, RC_BLOCK_PAGES)(TriBlock, blocks)
#define RC_INSTANCES RC_JOIN(RC_PARAMETER_, RC_INSTANCE_PAGES)(Instance, instances)
#define RC_SURFACES RC_JOIN(RC_PARAMETER_, RC_SURFACE_PAGES)(Surface, surfaces)
#define RC_PASS_NODES RC_JOIN(RC_PASS_, RC_NODE_PAGES)(nodes)
#define RC_PASS_BLOCKS RC_JOIN(RC_PASS_, RC_BLOCK_PAGES)(blocks)
#define RC_PASS_INSTANCES RC_JOIN(RC_PASS_, RC_INSTANCE_PAGES)(instances)
#define RC_PASS_SURFACES RC_JOIN(RC_PASS_, RC_SURFACE_PAGES)(surfaces)
#define RC_GATHER_NODES(scene) RC_JOIN(RC_GATHER_, RC_NODE_PAGES)(scene, nodes)
#define RC_GATHER_BLOCKS(scene) RC_JOIN(RC_GATHER_, RC_BLOCK_PAGES)(scene, blocks)
#define RC_GATHER_INSTANCES(scene) RC_JOIN(RC_GATHER_, RC_INSTANCE_PAGES)(scene, instances)
#define RC_GATHER_SURFACES(scene) RC_JOIN(RC_GATHER_, RC_SURFACE_PAGES)(scene, surfaces)

#define RC_LEAF 0x80000000u /* of a child on a stack: a block or an instance, not a node */

/* Place of an element in its page. */
static inline uint rc_page_offset(uint index, uint shift) { return index & ((1u << shift) - 1u); }

static inline global const BvhNode* rc_paged_node(global const BvhNode* const* pages, uint index) {
  return RC_NODE_PAGES == 1 ? pages[0] + index : pages[index >> RC_NODE_SHIFT] + rc_page_offset(index, RC_NODE_SHIFT);
}
static inline global const TriBlock* rc_paged_block(global const TriBlock* const* pages, uint index) {
  return RC_BLOCK_PAGES == 1 ? pages[0] + index
                             : pages[index >> RC_BLOCK_SHIFT] + rc_page_offset(index, RC_BLOCK_SHIFT);
}
static inline global const Instance* rc_paged_instance(global const Instance* const* pages, uint index) {
  return RC_INSTANCE_PAGES == 1 ? pages[0] + index
                                : pages[index >> RC_INSTANCE_SHIFT] + rc_page_offset(index, RC_INSTANCE_SHIFT);
}
static inline global const Surface* rc_paged_surface(global const Surface* const* pages, uint index) {
  return RC_SURFACE_PAGES == 1 ? pages[0] + index
                               : pages[index >> RC_SURFACE_SHIFT] + rc_page_offset(index, RC_SURFACE_SHIFT);
}

/* Macros, so that the struct is read where it lies and never copied. */
#define rc_node(scene, index) rc_paged_node((scene).nodes, (index))
#define rc_block(scene, index) rc_paged_block((scene).blocks, (index))
#define rc_instance(scene, index) rc_paged_instance((scene).instances, (index))
#define rc_surface(scene, index) rc_paged_surface((scene).surfaces, (index))

/* Number of the surface of primitive block * RC_BLOCK + lane; RC_NONE in a lane without a triangle. */
#define rc_surface_of(scene, primitive) (rc_block(scene, (primitive) / RC_BLOCK)->surface[(primitive) % RC_BLOCK])

#endif
