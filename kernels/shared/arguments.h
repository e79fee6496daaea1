/* A kernel's arguments from one list, which yields its parameters and its call in OpenCL C (below) and the struct that
 * the host fills, by name and checked by type (host/cl/arguments.h). Valid C++20 and OpenCL C 1.2. A list is
 *   #define RC_NAME_ARGUMENTS(VALUE, READ, WRITE, SCENE, NEXT) VALUE(type, name) NEXT() READ(type, name) NEXT() ...
 * of VALUE (a number or a vector), READ and WRITE (buffers), SCENE (an array of the scene in as many pages as its build
 * options say, kernels/geometry/scene_arrays.h), with NEXT() between each two. A part that several kernels share is a
 * list of its own among them, LIST(VALUE, READ, WRITE, SCENE, NEXT). Types are those of structs.h. */
#ifndef RAYCUBE_KERNELS_SHARED_ARGUMENTS_H
#define RAYCUBE_KERNELS_SHARED_ARGUMENTS_H

#include "kernels/shared/structs.h"

#ifdef __OPENCL_C_VERSION__
#define RC_COMMA() ,
#define RC_VALUE_PARAMETER(type, name) type name
#define RC_READ_PARAMETER(type, name) global const type* restrict name
#define RC_WRITE_PARAMETER(type, name) global type* restrict name
#define RC_SCENE_PARAMETER(type, name, array) RC_##array
#define RC_PASSED_NAME(type, name) name
#define RC_PASSED_SCENE(type, name, array) RC_PASS_##array
/* Parameters of a kernel and of what it calls; what it hands on. */
#define RC_PARAMETERS(LIST) \
  LIST(RC_VALUE_PARAMETER, RC_READ_PARAMETER, RC_WRITE_PARAMETER, RC_SCENE_PARAMETER, RC_COMMA)
#define RC_PASSED(LIST) LIST(RC_PASSED_NAME, RC_PASSED_NAME, RC_PASSED_NAME, RC_PASSED_SCENE, RC_COMMA)
#endif

#endif
