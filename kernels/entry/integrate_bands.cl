/* integrate_bands: L[pixel][band] = sum over the pixel's terms of weight * E[row][band], in term order.
 * Reads:  terms of resolve, the band table. Writes: radiance, W m-2 sr-1 um-1. Next: the writer.
 * One work-item per pixel, any local size; bands are padded to a multiple of 16. Truth per band is further columns
 * behind the bands, in units of its own (host/plan/band_truth.h): here they are more bands. */
#pragma OPENCL FP_CONTRACT OFF
#include "kernels/shared/camera_arguments.h"

/* A store that does not read the line first is worth 2x where memory is the limit; same bits either way. */
#if defined(__has_builtin)
#if __has_builtin(__builtin_nontemporal_store)
#define STORE16(value, address) __builtin_nontemporal_store((value), (address))
#endif
#endif
#ifndef STORE16
#define STORE16(value, address) (*(address) = (value))
#endif

RC_BODY integrate_bands_body(uint index, RC_PARAMETERS(RC_INTEGRATE_BANDS_ARGUMENTS)) {
  const uint item = first_item + index;
  if (item >= first_item + item_count) return;
  const uint pixel = use_list ? pixel_list[item] : item;
  const uint terms = term_count[item];
  __global const uint* rows = term_row + (size_t)item * term_capacity;
  __global const float* weights = term_weight + (size_t)item * term_capacity;
  __global const float16* baked = (__global const float16*)table;
  __global float16* out = (__global float16*)radiance + (size_t)pixel * words;
  uint b = 0;
  /* Four band vectors at a time: four independent chains hide the latency of the multiply-add. */
  for (; b + 4 <= words; b += 4) {
    float16 l0 = 0.0f, l1 = 0.0f, l2 = 0.0f, l3 = 0.0f;
    for (uint t = 0; t < terms; ++t) {
      __global const float16* e = baked + (size_t)rows[t] * words + b;
      const float16 w = weights[t];
      l0 = fma(w, e[0], l0);
      l1 = fma(w, e[1], l1);
      l2 = fma(w, e[2], l2);
      l3 = fma(w, e[3], l3);
    }
    STORE16(l0, out + b);
    STORE16(l1, out + b + 1);
    STORE16(l2, out + b + 2);
    STORE16(l3, out + b + 3);
  }
  for (; b < words; ++b) {
    float16 sum = 0.0f;
    for (uint t = 0; t < terms; ++t) sum = fma((float16)(weights[t]), baked[(size_t)rows[t] * words + b], sum);
    STORE16(sum, out + b);
  }
}

kernel void integrate_bands(RC_PARAMETERS(RC_INTEGRATE_BANDS_ARGUMENTS)) {
  integrate_bands_body((uint)get_global_id(0), RC_PASSED(RC_INTEGRATE_BANDS_ARGUMENTS));
}
