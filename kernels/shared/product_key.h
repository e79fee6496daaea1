/* Product keys: which curves a term's weight multiplies. Valid C++20 and OpenCL C 1.2.
 *
 * A key packs up to RC_KEY_CURVES curve ids of RC_KEY_BITS bits, ascending from the lowest bits, 0 = none; so the key
 * of one curve is its id, and 0 is the key of light that no surface scattered. Bit 63 is never a key's: rows of the
 * ground around and of the skeleton have it (host/plan/plan.h).
 *
 * A material owns RC_CURVE_ROLES curves, and one of each further lobe (spectral_shape.h). Id of one: role * materials +
 * material + 1, material counted from 0; so the reflectances come first, in the materials' order, and ids say whose
 * they are without a table. */
#ifndef RAYCUBE_KERNELS_SHARED_PRODUCT_KEY_H
#define RAYCUBE_KERNELS_SHARED_PRODUCT_KEY_H

#ifdef __OPENCL_C_VERSION__
typedef ulong rc_key;
typedef uint rc_id;
#else
#include <cstdint>
typedef std::uint64_t rc_key;
typedef std::uint32_t rc_id;
#endif

#define RC_KEY_CURVES 3u
#define RC_KEY_BITS 21u
#define RC_KEY_MASK 0x1FFFFFu

#define RC_CURVE_REFLECTANCE 0u
#define RC_CURVE_TRANSMITTANCE 1u
#define RC_CURVE_GLOSS 2u
#define RC_CURVE_ROLES 3u   /* that every material has; then those of its further lobes */
#define RC_CURVE_FURTHER 3u /* of shapes that change with wavelength: what further nodes send (spectral_shape.h) */
#define RC_MOST_NODES 8u    /* of a shape */
/* The role after all others, of no curve: emission by what a front shape sends back of an even light beyond Lambert's
 * law, under the material's own curve (kernels/light/lobe_albedo.h). records: RC_FURTHER_RECORDS. */
#define RC_CURVE_LEANING(records) (RC_CURVE_FURTHER + (records))

/* Ways by which light that falls onto a surface goes to the viewer: from the side that he sees, through from the far
 * one, or from the near one by its gloss; then by the further lobes of what the near one reflects or mirrors,
 * RC_FURTHER_SIDE and on. The number of each is its curve's role. */
#define RC_NEAR_SIDE 0u
#define RC_FAR_SIDE 1u
#define RC_GLOSS_SIDE 2u
#define RC_FURTHER_SIDE 3u
static inline rc_id rc_curve_of_side(rc_id side) { return side; }

/* Curve `role` of material `material` (from 0) of `materials`. */
static inline rc_id rc_curve_id(rc_id role, rc_id material, rc_id materials) {
  return role * materials + material + 1u;
}
static inline rc_id rc_curve_material(rc_id curve, rc_id materials) { return (curve - 1u) % materials; }
static inline rc_id rc_curve_role(rc_id curve, rc_id materials) { return (curve - 1u) / materials; }

static inline rc_key rc_key_of(rc_id curve) { return (rc_key)curve; }

/* The i-th curve of a key, from 0; 0 past its last. */
static inline rc_id rc_key_curve(rc_key key, rc_id i) { return (rc_id)(key >> (RC_KEY_BITS * i)) & RC_KEY_MASK; }

static inline rc_id rc_key_count(rc_key key) {
  rc_id count = 0;
  while (count < RC_KEY_CURVES && rc_key_curve(key, count) != 0u) ++count;
  return count;
}

/* The key of the product with one more curve; a key that is full already comes back as it is. */
static inline rc_key rc_key_times(rc_key key, rc_id curve) {
  const rc_id count = rc_key_count(key);
  rc_id place = 0;
  rc_key below;
  if (count == RC_KEY_CURVES) return key;
  while (place < count && rc_key_curve(key, place) <= curve) ++place;
  below = key & (((rc_key)1 << (RC_KEY_BITS * place)) - 1u);
  return below | (rc_key)curve << (RC_KEY_BITS * place) | (key ^ below) << RC_KEY_BITS;
}

#endif
