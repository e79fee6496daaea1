/* Structs shared by host and device, made from structs.def. Valid C++20 and OpenCL C 1.2. */
#ifndef RAYCUBE_KERNELS_SHARED_STRUCTS_H
#define RAYCUBE_KERNELS_SHARED_STRUCTS_H

#define RC_NONE 0xFFFFFFFFu /* no instance, no primitive, no surface */
#define RC_GROUP_WIDTH 4    /* pixels of one line that share a traversal: a constant of the plan, part of the results */
#define RC_BLOCK 16         /* triangles per leaf block */
#define RC_MOST_PAGES 8     /* buffers that an array of the scene may come in */
#define RC_LOBES 6          /* Lobe records of a surface: what it reflects by, four of gloss, what lets light through */
#define RC_LOBE_BEHIND 5
#ifdef __OPENCL_C_VERSION__
#ifndef RC_FURTHER_RECORDS
#define RC_FURTHER_RECORDS 0 /* records of a surface after those: of shapes that change with wavelength */
#endif
#define RC_LOBE_STRIDE (RC_LOBES + RC_FURTHER_RECORDS)
#endif
#define RC_MAX_CHANNELS 32 /* channels (source x node) of a term row */
#define RC_LAMP_POINT 0u   /* shapes of lamps */
#define RC_LAMP_SPOT 1u
#define RC_LAMP_RECTANGLE 2u /* this and the next shine from one side, by the cosine */
#define RC_LAMP_DISC 3u
#define RC_STEP_SENT 1u /* of PathStep::decided: there is such a ray */
#define RC_STEP_MET 2u  /* something lies ahead of it */
#define RC_STEP_LIT 4u  /* the sun is seen from where it ends */
#define RC_STEP_SIDE 3u /* from this bit on: side by which the path goes on, or that it ends there */
#define RC_STEP_ENDS 3u
#define RC_VOLUME_BOX 0u /* shapes of a LidarVolume */
#define RC_VOLUME_GRID 1u
#define RC_VOLUME_PLUME 2u
#define RC_PLUME_WIDTHS 6.5f /* a plume ends so many of its widths from the axis; a bell's share beyond is 8e-11 */

#ifdef __OPENCL_C_VERSION__
#if defined(__clang__) && defined(__x86_64__)
/* Clang tells of every function that takes 16 floats that its ABI is another without AVX-512; none is called from
 * elsewhere. */
#pragma clang diagnostic ignored "-Wpsabi"
#endif
/* What a kernel does, in a function of its own that the kernel only calls: PoCL makes three copies of a kernel, each
 * with all that is inlined into it, and compiles them all. A kernel passes its index; the body asks for no work-item
 * function. */
#define RC_BODY __attribute__((noinline)) static void
typedef int rc_int;
typedef uint rc_uint;
typedef ushort rc_ushort;
typedef long rc_long;
typedef ulong rc_ulong;
typedef float rc_float;
typedef float4 rc_float4;
#define RC_STRUCT_BEGIN(name, text) typedef struct name {
/* clang-format off */
#define RC_STRUCT_END(name, bytes) } name;
/* clang-format on */
#else
#include <cstdint>
namespace raycube::shared {
using rc_int = std::int32_t;
using rc_uint = std::uint32_t;
using rc_ushort = std::uint16_t;
using rc_long = std::int64_t;
using rc_ulong = std::uint64_t;
using rc_float = float;
struct alignas(16) rc_float4 {
  float x = 0, y = 0, z = 0, w = 0;
};
#define RC_STRUCT_BEGIN(name, text) struct alignas(16) name {
/* clang-format off */
#define RC_STRUCT_END(name, bytes) }; \
  static_assert(sizeof(name) == bytes, #name " has padding the field list does not name");
/* clang-format on */
#endif
#define RC_FIELD(type, name, text) type name;
#define RC_ARRAY(type, name, count, text) type name[count];
#include "structs.def"
#undef RC_STRUCT_BEGIN
#undef RC_STRUCT_END
#undef RC_FIELD
#undef RC_ARRAY
#ifndef __OPENCL_C_VERSION__
} /* namespace raycube::shared */
#endif
#endif
