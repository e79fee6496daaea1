/* Reads: nothing. Writes: for every shared struct its size, then the offset of every field, in the order of
 * structs.def. Next: a test compares them with the host's. */
#pragma OPENCL FP_CONTRACT OFF
#include "kernels/shared/structs.h"

#define RC_OFFSET(type, name) ((uint)(uintptr_t)(&((private type*)0)->name))

kernel void probe_structs(global uint* report) {
  uint i = 0;
#define RC_STRUCT_BEGIN(name, text) \
  {                                 \
    typedef name This;              \
    report[i++] = (uint)sizeof(This);
#define RC_FIELD(type, name, text) report[i++] = RC_OFFSET(This, name);
#define RC_ARRAY(type, name, count, text) report[i++] = RC_OFFSET(This, name);
#define RC_STRUCT_END(name, bytes) }
#include "kernels/shared/structs.def"
#undef RC_STRUCT_BEGIN
#undef RC_FIELD
#undef RC_ARRAY
#undef RC_STRUCT_END
}
